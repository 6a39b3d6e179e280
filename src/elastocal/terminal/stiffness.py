"""What a model says of the test poses: the error it leaves, and how the TCP gives way."""

from __future__ import annotations

from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.study.at_test_poses import AtTestPose
from elastocal.terminal.console import micrometres, out, whole
from elastocal.wording import ended
from elastocal.wording.numbers import vector
from elastocal.wording.stiffness import COMPLIANCE, STIFFNESS, left_out, ranged

_MOST = 3  # test poses of which the stiffness is shown


def show_errors_left(
    found: tuple[AtTestPose, ...], names: tuple[str, ...], *, nuisance: bool
) -> None:
    """The whole error that the compliances of `names` leave at each test pose."""
    without = "" if nuisance else "; no nuisance counts"
    for one in found:
        rigid = one.cartesian.rigid
        besides = f", {', '.join(rigid)} taken as rigid" if rigid else ""
        out.print(
            Text(
                f"Error left at {one.name!r} after compensation: ρ0 = {micrometres(one.rho0)}, "
                f"with 95 % below {micrometres(one.limit)}, by the uncertainty of "
                f"{', '.join(names)}{besides}{without}."
            )
        )


def show_stiffness(found: tuple[AtTestPose, ...]) -> None:
    """Compliance and stiffness at the test poses."""
    for one in found[:_MOST]:
        _show(one)
    if len(found) > _MOST:
        out.print(f"… and at {len(found) - _MOST} more test poses, see --json.")


def _show(one: AtTestPose) -> None:
    place = f", {one.place}" if one.place else ""
    table = Table(
        title=Text(f"Stiffness at {one.name!r}{place}: TCP of {one.tool!r}, base axes"),
        title_justify="left",
        box=box.SIMPLE_HEAD,
    )
    table.add_column("force along")
    for _, unit in (COMPLIANCE, STIFFNESS):
        table.add_column(unit, justify="right", no_wrap=True)
    stiff = one.cartesian
    for line in (*stiff.axes, *stiff.principal):
        along = line.name if len(line.name) == 1 else f"{line.name} {vector(line.direction, 2)}"
        table.add_row(
            along, ranged(line.compliance, COMPLIANCE[0]), ranged(line.stiffness, STIFFNESS[0])
        )
    whole(table)
    for sentence in left_out(stiff.missing, stiff.rigid):
        out.print(Text(ended(sentence)))
    if stiff.missing:
        return
    held = ", ".join(
        f"{axis} {ranged(interval, STIFFNESS[0])}"
        for axis, interval in zip("xyz", stiff.held[:3], strict=True)
    )
    out.print(Text(f"Held from moving any other way (diagonal of K_C): {held} {STIFFNESS[1]}."))
