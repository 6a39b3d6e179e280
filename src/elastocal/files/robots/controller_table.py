"""Values for a controller as a table (CSV): zeros of joints, tools, bases, each with its error."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.for_controller import ForController, MountedTool, StandingBase, ZeroShift
from elastocal.robot.rotations import quaternions, rotation_vectors, zyx_angles
from elastocal.writing import signature, table_row

KIND = "controller table"
_HEADER = ("what", "of", "number", "value", "unit", "standard error", "remark")
_RESTS = "not measured: rests on what was known before"


def controller_table(values: ForController, about: Sequence[str]) -> str:
    """The text of the table.

    Args:
        values: What goes into the controller.
        about: Lines on where it comes from.
    """
    head = [*about, *_words(values), signature(KIND)]
    lines = [f"# {line}\n" for line in head]
    lines.append(table_row(_HEADER))
    rows = [*_zeros(values.zeros)]
    for tool in values.tools:
        rows += _tool(tool)
    for base in values.bases:
        rows += _base(base)
    return "".join([*lines, *(table_row(row) for row in rows)])


def _words(values: ForController) -> list[str]:
    left = values.left
    under = f" with {left.payload}" if left.payload else ""
    worse = "" if left.zeros < left.drawn else "; the zeros alone make it worse: leave them out"
    return [
        "zero: what must be added to what the controller shows. Where it shows q the joint",
        "stands at q + value. Zeros and tool belong together: enter all of them, or none.",
        "tool: in the frame of the flange as the model has it, which must be the controller's.",
        "base: the frame of the station, seen from the base of the robot: a base (work object,",
        "user frame) in which the controller takes what the station reads.",
        "A, B, C: Rot_z(A) Rot_y(B) Rot_x(C), as KUKA counts; FANUC's W, P, R are C, B, A.",
        "q1 to q4: quaternion, scalar first, as ABB has it.",
        "rx, ry, rz: rotation vector, as UR has it.",
        "Lengths, angles and compliances of the arm have no place in a controller. They leave of",
        f"{left.point}{under}, RMS over the joint ranges: {1e3 * left.drawn:.3g} mm with tool and",
        f"base alone, {1e3 * left.zeros:.3g} mm with the zeros{worse}.",
    ]


def _zeros(zeros: Sequence[ZeroShift]) -> Iterator[tuple[object, ...]]:
    for one in zeros:
        if not one.sought:
            continue
        scale, unit = one.kind.scale, one.kind.key
        remark = "" if one.seen else _RESTS
        yield (
            "zero", one.joint, "add to shown", _shown(scale * one.shift), unit,
            _error(scale * one.error), remark,
        )  # fmt: skip


def _tool(tool: MountedTool) -> Iterator[tuple[object, ...]]:
    mounting = f" of {tool.mounting}" if tool.mounting else ""
    for point, errors in zip(tool.points, tool.errors, strict=True):
        remark = "" if point.measured else "as drawn: not read, and carried by no reflectors"
        for axis, value, error in zip("XYZ", point.point, errors, strict=True):
            yield (
                "tool", f"{point.name}{mounting}", axis, _shown(1e3 * value), "mm",
                _error(1e3 * error), remark,
            )  # fmt: skip
    if tool.frame is not None:
        yield from _turns("tool", f"{tool.points[0].name}{mounting}", tool.frame)


def _base(base: StandingBase) -> Iterator[tuple[object, ...]]:
    of = base.station or "station"
    for axis, value, error in zip("XYZ", base.T_base_station[:3, 3], base.errors[:3], strict=True):
        yield "base", of, axis, _shown(1e3 * value), "mm", _error(1e3 * error), ""
    yield from _turns("base", of, base.T_base_station)
    for axis, error in zip("xyz", np.degrees(base.errors[3:]), strict=True):
        yield "base", of, f"turn about {axis}", "0", "deg", _error(error), "how uncertain it is"


def _turns(what: str, of: str, T: Array) -> Iterator[tuple[object, ...]]:
    """The orientation of a frame, as makers write it."""
    R = T[None, :3, :3]
    for names, values, unit in (
        (("A", "B", "C"), np.degrees(zyx_angles(R)[0]), "deg"),
        (("q1", "q2", "q3", "q4"), quaternions(R)[0], ""),
        (("rx", "ry", "rz"), rotation_vectors(R)[0], "rad"),
    ):
        for name, value in zip(names, values, strict=True):
            yield what, of, name, _shown(value), unit, "", ""


def _shown(value: float) -> str:
    """A number to a billionth, without a minus before zero."""
    text = f"{value:.9f}"
    return text.removeprefix("-") if not float(text) else text


def _error(value: float) -> str:
    return f"{value:.3g}" if np.isfinite(value) else ""
