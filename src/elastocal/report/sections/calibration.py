"""Sections of a calibration from absolute readings.

In: calibration, models that grow, a check on other poses. Out: the sections.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from markupsafe import Markup

from elastocal.calibration.by_joint import joint_shares
from elastocal.calibration.calibrate import Calibration, values_of
from elastocal.calibration.doubts import doubts
from elastocal.calibration.nested import Ladder
from elastocal.calibration.parameters import BASE, COMPENSATOR, COMPLIANCE, PAYLOAD, PROBE, TOOL
from elastocal.calibration.redundancy import together
from elastocal.calibration.stations import StationMotion
from elastocal.calibration.validate import Check
from elastocal.report.charts.calibrated import Bars, Found, bar_chart, error_map, interval_chart
from elastocal.report.layout import two_widths
from elastocal.report.section import Chapter, PageSection
from elastocal.report.tables import BarTable, Row
from elastocal.wording import worded
from elastocal.wording.calibration import combination
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, number

_LONG = 0.12  # an error of usual size is drawn so long [m]


@dataclass(frozen=True)
class CalibrationContents:
    """What there is to show of a calibration.

    Attributes:
        name: Name of the study.
        found: The calibration.
        grown: Models that grow to it.
        check: The calibrated robot on poses that were not used; None if there are none.
        motions: How stations moved, as reflectors on the foot show.
    """

    name: str
    found: Calibration
    grown: Ladder
    check: Check | None = None
    motions: tuple[StationMotion, ...] = ()


def calibration_top(contents: CalibrationContents) -> PageSection:
    """What it comes to."""
    found, grown = contents.found, contents.grown
    first, last = grown.rungs[0], grown.rungs[-1]
    check = contents.check
    values = {
        "name": contents.name,
        "robot": found.model.robot.name,
        "before": length(first.left_out),
        "after": length(last.left_out),
        "poses": counted(len(found.positions.cases), "pose"),
        "readings": counted(len(found.positions), "reading"),
        "check": None
        if check is None
        else {
            "poses": counted(len(check.positions.cases), "pose"),
            "error": length(check.rms),
            "expected": length(check.expected),
            "set_up": counted(len(check.set_up), "pose") if check.set_up else "",
        },
        "told": found.redundancy.told,
        "unknowns": len(found.parameters) - int(found.parameters.held.sum()),
        "remarks": tuple(worded(doubt) for doubt in doubts(found, grown)),
    }
    return PageSection("calibrated", "Result", values)


def calibration_chapter(contents: CalibrationContents) -> Chapter:
    """All sections behind the top."""
    return Chapter(
        "Calibration",
        (
            _growth(contents),
            _where(contents),
            _joints(contents.found),
            _unknowns(contents.found),
            _apart(contents),
        ),
    )


def _growth(contents: CalibrationContents) -> PageSection:
    """Errors by model."""
    grown = contents.grown
    rows = [
        Bars(
            ("+ " if i else "") + rung.name,
            rung.left_out,
            rung.error,
            "proposed" if i == grown.proposed else "",
        )
        for i, rung in enumerate(grown.rungs)
    ]
    names = "poses left out", "fit"
    picture = two_widths(lambda w: bar_chart(rows, names, "position error (RMS)", w))
    table = BarTable(
        ("Model", "Unknowns", "Told", "Fit", "Poses left out"),
        tuple(
            Row(
                (
                    row.name,
                    str(rung.unknowns),
                    "–" if rung.calibration is None else str(rung.calibration.redundancy.told),
                    length(rung.error),
                    length(rung.left_out),
                )
            )
            for row, rung in zip(rows, grown.rungs, strict=True)
        ),
    )
    return PageSection("growth", "Models that grow", {"picture": picture, "table": table})


def _where(contents: CalibrationContents) -> PageSection:
    """Errors in space, before and after."""
    found, bare = contents.found, contents.grown.rungs[0].calibration
    p = found.positions
    points = ~p.rotations
    turn = found.state.base[p.station[points], :3, :3]
    at = np.einsum("rji,rj->ri", turn, p.value[points] - found.state.base[p.station[points], :3, 3])
    after = np.einsum("rji,rj->ri", turn, found.error[points])
    before = after if bare is None else np.einsum("rji,rj->ri", turn, bare.error[points])
    usual = float(np.sqrt((before**2).sum(axis=1).mean()))
    enlarged = float(f"{_LONG / max(usual, 1e-9):.1g}")

    def drawn(plane: tuple[int, int]) -> Markup:
        return two_widths(
            lambda w: error_map(at, before, after, plane, enlarged, 0.48 * w if w > 500 else w)
        )

    return PageSection("where", "Errors in space", {"pictures": [drawn((0, 1)), drawn((0, 2))]})


def _joints(found: Calibration) -> PageSection:
    """What every joint does to the tool."""
    rows = [Bars(share.name, share.geometry, share.sag) for share in joint_shares(found)]
    names = "geometry", "sag"
    picture = (
        two_widths(lambda w: bar_chart(rows, names, "moves the tool by (RMS)", w)) if rows else ""
    )
    return PageSection("by-joint", "Joint by joint", {"picture": picture})


def _unknowns(found: Calibration) -> PageSection:
    """Values with intervals, by unit."""
    p, error, values = found.parameters, found.standard_error, values_of(found)
    groups: dict[tuple[str, str], list[Found]] = {}
    for u, block in enumerate(p.block):
        if block in (BASE, PROBE, TOOL) or p.held[u]:
            continue
        factor, unit = p.shown(u)
        half = found.width * factor * float(error[u])
        one = Found(p.names[u], factor * float(values[u]), half, bool(found.redundancy.seen[u]))
        groups.setdefault((_title(block, unit), unit), []).append(one)
    pictures = [
        (title, two_widths(partial(_intervals, of, unit))) for (title, unit), of in groups.items()
    ]
    table = BarTable(
        ("Reflector", "x [mm]", "y [mm]", "z [mm]"),
        tuple(
            Row(
                (name, *(_coordinate(found, u) for u in np.arange(len(p))[p.marker(m, k)].tolist()))
            )
            for m, mounting in enumerate(found.positions.mountings)
            for k, name in enumerate(_reflectors(found, mounting))
            if p.targets[m, k]
        ),
    )
    return PageSection("unknowns", "Unknowns", {"pictures": pictures, "table": table})


def _coordinate(found: Calibration, u: int) -> str:
    """Where a reflector is along an axis, with 95 %, or that the readings do not tell it."""
    value = f"{1e3 * float(values_of(found)[u]):.3f}"
    if found.parameters.held[u]:
        return f"{value}, taken as known"
    if not found.redundancy.seen[u]:
        return f"{value}, not told by itself"
    return f"{value} ± {number(1e3 * found.width * float(found.standard_error[u]), 2)}"


def _intervals(found: list[Found], unit: str, width: float) -> Markup:
    return interval_chart(found, unit, width)


def _reflectors(found: Calibration, mounting: str) -> list[str]:
    several = len(found.positions.mountings) > 1
    names = found.positions.tool.marker_names
    return [f"{name} of {mounting}" if several else name for name in names]


def _title(block: str, unit: str) -> str:
    """Of the unknowns of a block that have this unit."""
    if block == PAYLOAD:
        return "Payload, mass" if unit == "kg" else "Payload, moment"
    named = {COMPLIANCE: "Compliances", COMPENSATOR: "Compensators"}
    return named.get(block, "Zeros and angles" if unit == "mrad" else "Lengths")


def _apart(contents: CalibrationContents) -> PageSection:
    """What cannot be told apart, how readings scatter, how stations moved."""
    found = contents.found
    same = together(found.redundancy.open, found.parameters.names)
    noise = [
        (name or "the station", length(float(own)), length(float(shared)))
        for name, own, shared in zip(
            found.positions.stations, found.noise.own, found.noise.shared, strict=True
        )
    ]
    moved = [
        (
            found.positions.stations[one.station] or "the station",
            one.verdict,
            length(float(np.linalg.norm(one.motion[:, :3], axis=1).max(initial=0.0))),
            str(len(one.motion)),
        )
        for one in contents.motions
    ]
    values = {
        "combinations": [*map(combination, same)],
        "well": found.redundancy.well,
        "noise": noise,
        "moved": moved,
    }
    return PageSection("apart", "What is not told", values)
