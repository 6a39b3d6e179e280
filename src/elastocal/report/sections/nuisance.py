"""Section of what was fitted along: nuisance parameters, and what they do to predictions."""

from __future__ import annotations

from elastocal.identification.left_out_error import left_out_error, repeats_left
from elastocal.identification.nuisance_found import NuisanceFound, nuisance_found
from elastocal.identification.result import Identification
from elastocal.report.charts.expected import expected_chart
from elastocal.report.layout import two_widths
from elastocal.report.section import PageSection
from elastocal.report.tables import BarTable, Row
from elastocal.report.verdict import Tile
from elastocal.wording.numbers import number, small


def nuisance_section(found: Identification) -> PageSection:
    """What was found of each parameter beside what was expected, and what predictions gain."""
    told = nuisance_found(found)
    return PageSection(
        "nuisance",
        "Fitted along",
        {
            "tiles": _tiles(found),
            "chart": two_widths(lambda width: expected_chart(told, width)),
            "table": _table(told),
            "held": any(one.held for one in told),
        },
    )


def _tiles(found: Identification) -> list[Tile]:
    mixed = left_out_error(found)
    gone = repeats_left(found, mixed)
    tiles = [
        Tile(
            "Left out, predicted",
            small(mixed.seen, "m"),
            f"Error of experiments left out one after the other{gone} (RMS); promised "
            f"{small(mixed.promised, 'm')}.",
        )
    ]
    if found.alone is not None:
        alone = left_out_error(found.alone)
        stay = repeats_left(found, alone)
        tiles.append(
            Tile(
                "With the joints alone",
                small(alone.seen, "m"),
                f"The same without what was fitted along{'' if stay == gone else stay}; promised "
                f"{small(alone.promised, 'm')}.",
            )
        )
    return tiles


def _table(told: tuple[NuisanceFound, ...]) -> BarTable:
    """Values in units people read; where their sizes are from stands with the plan."""
    rows = []
    for one in told:
        factor, unit = (1e9, f"n{one.unit}") if one.unit else (1.0, "uncertainties")
        value = number(factor * one.value, 3)
        if one.held:
            value = "held at 0"
        elif abs(one.value) < _NOTHING * one.deviation:
            value = "0"
        cells = (
            one.name,
            value,
            f"± {number(factor * one.standard_error, 2)}",
            f"{number(factor * one.mean, 2)} ± {number(factor * one.deviation, 2)}",
            unit,
        )
        rows.append(Row(cells))
    return BarTable(("", "found", "error", "expected", "unit"), tuple(rows))


_NOTHING = 0.005  # prior uncertainties that are too little to be a number
