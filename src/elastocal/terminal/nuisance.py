"""What moves readings besides, as a table: where it is, how large, and who says so."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.places import SpringPlace, places_of
from elastocal.robot.chain import Robot
from elastocal.terminal.console import numbers, out, whole
from elastocal.wording.lists import listed
from elastocal.wording.numbers import number, short

_SHARES = {
    "friction": "friction {} of each joint's deflection",
    "discrepancy": "discrepancy {} of the deflection per axis",
    "gain": "size of each load {}",
    "common_gain": "size of all loads together {}",
}
_SIZES = {
    "discrepancy_length": ("discrepancy {} mm per axis", 1e3),
    "repeatability": ("repeatability {} mm per axis", 1e3),
    "tilt": ("direction of each load {}°", float(np.degrees(1.0))),
    "common_tilt": ("direction of all loads together {}°", float(np.degrees(1.0))),
}


def show_nuisance(robot: Robot, nuisance: Nuisance | None) -> None:
    """Where every spring besides is, with the robot at zero, and what errs; nothing if None."""
    if nuisance is None:
        return
    title = "Nuisance, base frame, all joints at zero; sizes are standard uncertainties"
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("what", "gives way", "carried by", "through mm", "size"):
        table.add_column(column, justify="right" if column == "size" else "left")
    places = places_of(robot, nuisance.unknowns)
    kinds = nuisance.unknowns.kinds
    for place, kind, size in zip(places, kinds, nuisance.deviation.tolist(), strict=True):
        shown = f"{number(1e9 * size)} n{kind.compliance}"
        through = "" if place.slides else numbers(1e3 * place.origin)
        where = f"body of {place.behind}" if place.behind else "base"
        table.add_row(
            Text(place.name),
            Text(_way(place)),
            Text(where),
            through,
            Text(shown),
        )
    if places:
        whole(table)
    by_source: dict[str, list[str]] = {}
    for name, source in zip(nuisance.names, nuisance.source, strict=True):
        by_source.setdefault(source, []).append(name)
    for source, names in by_source.items():
        out.print(Text(f"Size of {listed(names)}: {source}."))
    if said := _errors(nuisance):
        out.print(Text(f"New with every load case or load: {'; '.join(said)}."))


def _way(place: SpringPlace) -> str:
    """Along or about which axes."""
    axes = ", ".join(f"[{' '.join(f'{v + 0.0:.3g}' for v in np.round(a, 6))}]" for a in place.axes)
    return f"{'slides along' if place.slides else 'turns about'} {axes}"


def _errors(nuisance: Nuisance) -> list[str]:
    """Errors of load cases that there are, in words."""
    errors = vars(nuisance.errors)
    said = [text.format(f"{short(100 * errors[n])} %") for n, text in _SHARES.items() if errors[n]]
    said += [text.format(short(f * errors[n])) for n, (text, f) in _SIZES.items() if errors[n]]
    if errors["common_gain"]:
        said.append(f"process force: {_CELL[nuisance.errors.process_force]}")
    return said


_CELL = {
    "same": "by the same cell, so that a common error cancels",
    "exact": "exact",
    "other": "by another cell",
}
