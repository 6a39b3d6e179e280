"""What was understood of measurement files."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.measuring.measurements import Measurements
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot
from elastocal.terminal.console import numbers, out, whole
from elastocal.wording import ended, worded
from elastocal.wording.placements import distance, from_drawing

_SHOWN = 12


def show_measurements(found: Measurements, robot: Robot) -> None:
    """Experiments with their loads and largest deflections, the noise, and what looks odd."""
    n, tool = len(found.cases), found.tool
    out.print(Text(f"{found.source}: {_count(len(found), 'reading')} of {_count(n, 'experiment')}"))
    per_marker = np.bincount(found.marker, minlength=len(tool.targets))
    markers = ", ".join(
        f"{name} {count}×" for name, count in zip(tool.targets, per_marker, strict=True)
    )
    out.print(Text(f"Markers of tool {tool.name!r}: {markers}"))
    whence = "of the readings" if found.own_uncertainty else "of the instrument"
    ranges = " and ".join(
        f"{noise.min():.4g} … {noise.max():.4g} {'mm' if kind.unit == 'm' else 'mrad'}"
        for kind in found.quantities
        for noise in [1e3 * found.deviation[kind.readings]]
    )
    out.print(f"Noise {whence}: {ranges}, standard deviation of one coordinate")
    if (at := found.placement) is not None:
        said = distance(at.rms, at.apart, chosen=at.chosen)
        out.print(Text(ended(said[0].upper() + said[1:])))
    table = Table(box=box.SIMPLE_HEAD)
    sizes = ["deflection mm" if kind.unit == "m" else "rotation mrad" for kind in found.quantities]
    for column in ("experiment", *robot.joint_names, "force N", "torque N·m", *sizes):
        table.add_column(column, justify="right")
    size = 1e3 * np.linalg.norm(found.deflection, axis=1)
    largest = np.zeros((n, len(found.quantities)))
    for k, kind in enumerate(found.quantities):
        np.maximum.at(largest[:, k], found.case[kind.readings], size[kind.readings])
    shown = robot.shown_scale * found.cases.q
    for i in range(min(n, _SHOWN)):
        wrench = found.cases.wrench[i]
        joints = (f"{value + 0.0:.6g}" for value in shown[i])
        loads = numbers(wrench[:3]), numbers(wrench[3:])
        table.add_row(Text(found.names[i][:30]), *joints, *loads, *(f"{v:.4g}" for v in largest[i]))
    whole(table)
    if n > _SHOWN:
        out.print(f"… and {n - _SHOWN} more")
    for remark in (*found.remarks, *map(worded, found.doubts)):
        out.print(Text(f"Note: {ended(remark)}", style="yellow"))


def show_positions(found: Positions, robot: Robot) -> None:
    """Poses with the spread of their readings, the noise, how far the arm is, and what is odd."""
    n, tool = len(found.cases), found.tool
    out.print(Text(f"{found.source}: {_count(len(found), 'reading')} of {_count(n, 'pose')}"))
    per_marker = np.bincount(found.marker, minlength=len(tool.targets))
    parts = [f"{name} {c}×" for name, c in zip(tool.targets, per_marker, strict=True)]
    if found.foot is not None:
        each = np.bincount(found.foot.reflector, minlength=len(found.foot.names))
        parts += [f"{name} {c}× (still)" for name, c in zip(found.foot.names, each, strict=True)]
    out.print(Text(f"Reflectors of tool {tool.name!r}: {', '.join(parts)}"))
    for what, names in (("Stations", found.stations), ("Mountings", found.mountings)):
        if len(names) > 1:
            out.print(Text(f"{what}: {', '.join(names)}"))
    carried = np.bincount(found.payload + 1, minlength=len(found.payloads) + 1)
    if found.payloads:
        loads = zip(("nothing", *found.payloads), carried.tolist(), strict=True)
        out.print(Text(f"Carried: {', '.join(f'{name} in {c} poses' for name, c in loads if c)}"))
    whence = "of the readings" if found.own_uncertainty else "of the instrument"
    deviation = 1e3 * np.sqrt(np.einsum("rii->ri", found.covariance))
    ranges = " and ".join(
        f"{noise.min():.4g} … {noise.max():.4g} {unit}"
        for unit, own in (("mm", ~found.rotations), ("mrad", found.rotations))
        if own.any()
        for noise in [deviation[own]]
    )
    out.print(f"Noise {whence}: {ranges}, standard deviation of one coordinate")
    if np.isfinite(found.apart):
        said = from_drawing(found.apart)
        out.print(Text(ended(said[0].upper() + said[1:])))
    table = Table(box=box.SIMPLE_HEAD)
    for column in ("pose", *robot.joint_names, "x mm", "y mm", "z mm"):
        table.add_column(column, justify="right")
    shown = robot.shown_scale * found.cases.q
    first = {int(found.case[r]): r for r in np.flatnonzero(~found.rotations)[::-1].tolist()}
    for i in range(min(n, _SHOWN)):
        joints = [f"{value + 0.0:.6g}" for value in shown[i]]
        place = [f"{1e3 * v:.3f}" for v in found.value[first[i]]] if i in first else [""] * 3
        table.add_row(Text(found.names[i][:30]), *joints, *place)
    whole(table)
    if n > _SHOWN:
        out.print(f"… and {n - _SHOWN} more")
    for remark in (*found.remarks, *map(worded, found.doubts)):
        out.print(Text(f"Note: {ended(remark)}", style="yellow"))


def show_remarks(data: Measurements) -> None:
    """What looks odd in readings."""
    for remark in (*data.remarks, *map(worded, data.doubts)):
        out.print(Text(f"Note: {ended(remark)}", style="yellow"))


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
