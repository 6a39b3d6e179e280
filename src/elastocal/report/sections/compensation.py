"""Sections of a compensation: the path, what remains of the error, what the joints do for it.

In: compensation, residuals of a true model if there are any. Out: sections.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.compensation.compensate import Compensation
from elastocal.compensation.remaining import alarms, as_expected, doubts_of_path, rms
from elastocal.drawing.picture import portrait
from elastocal.drawing.stage import boxed, posed
from elastocal.elastic.load_cases import LoadCases
from elastocal.report.charts.lines import Line, error_chart, joint_chart
from elastocal.report.contents import Contents
from elastocal.report.layout import two_widths
from elastocal.report.path_picture import magnification, path_picture
from elastocal.report.scene import path_scene
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.tables import BarTable, Row
from elastocal.wording import together, worded
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, plain

_NOTHING = 1e-9  # an error that is not worth a line [m]
_MOST_ALARMS = 8


def compensation_chapter(contents: Contents) -> Chapter | None:
    """The sections of the compensation."""
    done = contents.compensation
    if done is None:
        return None
    path, scene = _path(contents, done)
    sections = (
        PageSection("path", "Path", path, scene),
        PageSection("remaining", "What remains", _remaining(contents, done)),
        PageSection("corrections", "Corrections", _corrections(done)),
    )
    return Chapter("Compensation", sections)


def compensation_remarks(contents: Contents) -> tuple[str, ...]:
    """What is weak in the compensation."""
    if contents.compensation is None:
        return ()
    doubts = doubts_of_path(contents.compensation, contents.judged)
    return tuple(f"path: {worded(doubt)}" for doubt in doubts)


def _groups(done: Compensation) -> list[tuple[str, str]]:
    """Points and what is said of them, points that share a sentence together."""
    by_sentence: dict[str, list[int]] = {}
    for i, doubts in enumerate(done.doubts):
        if doubts:
            by_sentence.setdefault(together(doubts), []).append(i + 1)
    grouped = [(_ranges(points), sentence) for sentence, points in by_sentence.items()]
    if len(grouped) > _MOST_ALARMS:
        left = sum(len(p) for p in list(by_sentence.values())[_MOST_ALARMS:])
        grouped = grouped[:_MOST_ALARMS]
        grouped.append((counted(left, "further point"), "see the corrected path file"))
    return grouped


def _ranges(points: list[int]) -> str:
    """Numbers in words: 'point 3', 'points 3 to 17, 20'."""
    pieces: list[list[int]] = []
    for point in points:
        if pieces and point == pieces[-1][-1] + 1:
            pieces[-1] = [pieces[-1][0], point]
        else:
            pieces.append([point])
    shown = [str(p[0]) if len(p) == 1 else f"{p[0]} to {p[-1]}" for p in pieces[:6]]
    more = " and more" if len(pieces) > 6 else ""
    return f"point{'s' if len(points) > 1 else ''} {', '.join(shown)}{more}"


def _path(contents: Contents, done: Compensation) -> tuple[Values, Values]:
    """Pictures of the path and the 3D scene."""
    wanted = done.target[:, :3, 3]
    after, name = done.after, "with compensation, by the model"
    if contents.judged is not None:
        after, name = contents.judged, "with compensation, true robot"
    before = np.linalg.norm(done.before, axis=1)
    factor = magnification(float(np.nanmax(before, initial=0.0)), wanted)
    lines = [("without compensation", "before", done.before), (name, "after", after)]
    middle = len(done) // 2
    robot, tool = done.arm.robot, done.arm.tool
    cases = LoadCases(done.cases.q[middle : middle + 1], done.cases.wrench[middle : middle + 1])
    figures = posed(robot, tool, cases, [f"{middle + 1}"])
    bent = wanted + factor * done.before
    bent = bent[np.isfinite(bent).all(axis=1)]
    unnamed = (replace(figures[0], load=""),)  # the caption says the load
    stage = boxed(unnamed, further=np.vstack([wanted, bent]))
    corrected = wanted + factor * after
    traces = {
        "wanted": (wanted, "ink", 6),
        "before": (bent, "contrast", 5),
        "after": (corrected[np.isfinite(corrected).all(axis=1)], "accent", 5),
    }
    values = {
        "magnification": plain(factor),
        "picture": two_widths(lambda width: path_picture(wanted, lines, factor, min(width, 640.0))),
        "portrait": portrait(figures[0], stage, lines=(wanted,)),
        "point": middle + 1,
        "load": figures[0].load,
        "count": len(done),
        "length": length(_length(wanted)),
        "rule": done.rule,
        "judged": contents.judged is not None,
    }
    return values, path_scene(stage, robot, traces)


def _length(points: Array) -> float:
    """Length of a path through points (N, 3)."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _way(done: Compensation) -> tuple[Array, str]:
    """Place of every point along the path, and what it is."""
    steps = np.linalg.norm(np.diff(done.target[:, :3, 3], axis=0), axis=1)
    if len(steps) and steps.min(initial=1.0) > 1e-7:
        return 1e3 * np.concatenate([[0.0], np.cumsum(steps)]), "way along the path [mm]"
    return np.arange(1.0, len(done) + 1.0), "point"


def _remaining(contents: Contents, done: Compensation) -> Values:
    """Errors along the path and their sizes."""
    way, title = _way(done)
    size = np.linalg.norm(done.before, axis=1)
    lines = [Line("without compensation", "before", size)]
    if contents.control is not None:
        control = np.linalg.norm(contents.control, axis=1)
        lines.append(Line("negative control: wrong sign", "control", control))
    if contents.judged is not None:
        judged = np.linalg.norm(contents.judged, axis=1)
        lines.append(Line("with compensation, true robot", "after", judged))
    own = np.linalg.norm(done.after, axis=1)
    if np.nanmax(own, initial=0.0) > _NOTHING:
        lines.append(Line(f"left by the {done.rule} rule", "rule", own))
    lines.append(Line("expected, ρ₀", "expected", done.expected))
    rows = [_row(item.name, item.value) for item in lines]
    return {
        "chart": two_widths(
            lambda width: error_chart(way, title, lines, 2.0 * done.expected, width)
        ),
        "table": BarTable(
            ("Position error", "Root mean square", "Mean", "Median", "Largest"), tuple(rows)
        ),
        "alarms": tuple(map(worded, alarms(done))),
        "groups": _groups(done),
        "notes": compensation_remarks(contents),
        "before": length(rms(done.before)),
        "expected": length(rms(done.expected)),
        "judged": None if contents.judged is None else length(rms(contents.judged)),
        "inside": None if contents.judged is None else as_expected(done, contents.judged),
        "control": None if contents.control is None else length(rms(contents.control)),
        "limit": length(done.limit),
        "floor": length(rms(done.floor)) if done.floor.any() else "",
        "exact": bool((done.model.covariance == 0.0).all()),
    }


def _row(name: str, size: Array) -> Row:
    """Sizes (N,) of an error [m]."""
    size = size[np.isfinite(size)]
    if not len(size):
        return Row((name, "–", "–", "–", "–"))
    values = (rms(size), float(size.mean()), float(np.median(size)), float(size.max()))
    return Row((name, *(length(value) for value in values)))


def _corrections(done: Compensation) -> Values:
    """What the joints do."""
    way, title = _way(done)
    robot = done.arm.robot
    shift = robot.shown_scale * (done.q - done.cases.q)
    units = [joint.kind.shown_unit for joint in robot.joints]
    largest = np.nanmax(np.abs(shift), axis=0, initial=0.0)
    most = int(np.argmax(np.where(robot.prismatic, 0.0, largest)))
    return {
        "chart": two_widths(
            lambda width: joint_chart(way, title, shift, robot.joint_names, units, width)
        ),
        "most": robot.joint_names[most],
        "steps": int(done.iterations.max(initial=0)),
    }
