"""Corrected paths: CSV for controllers and people, a document for programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.compensation.compensate import Compensation
from elastocal.files.doubt_entries import doubt_entries
from elastocal.files.paths.orientation_columns import FORMS, Form
from elastocal.files.paths.path_file import CORRECTED, ToolPath
from elastocal.robot.chain import Robot
from elastocal.wording import together, worded
from elastocal.writing import signature, table_row, write_text

_WRENCH = ("Fx [N]", "Fy [N]", "Fz [N]", "Tx [N.m]", "Ty [N.m]", "Tz [N.m]")


def write_corrected(done: Compensation, task: ToolPath, path: str | Path) -> None:
    """Write a corrected path: one row for each point, in the order of the path.

    Columns: the corrected joint values; the corrected pose for controllers that take poses, with
    the orientation written as in the path file; the load; the joint values the task wanted; the
    deflection without compensation; what remains with it; its uncertainty; what is odd.
    """
    robot = done.arm.robot
    form = (task.form or FORMS["quaternion"]) if len(robot.joints) >= 6 else None
    parts = [
        (_joints(robot, ""), robot.shown_scale * done.q, "0.7f"),
        (("x [mm]", "y [mm]", "z [mm]"), 1e3 * done.command[:, :3, 3], "0.6f"),
        *_orientations(form, done.command),
        (_WRENCH, done.cases.wrench, "0.9g"),
        (_joints(robot, " wanted"), robot.shown_scale * done.cases.q, "0.7f"),
        (_vector(CORRECTED), 1e3 * done.before, "0.6f"),
        (_vector("remaining dx"), 1e3 * done.after, "0.6f"),
        (("rho0 [mm]",), 1e3 * done.rho0[:, None], "0.6f"),
    ]
    header = ["point", *(name for names, _, _ in parts for name in names), "remark"]
    lines = [table_row([*header, signature("corrected path")])]
    for i, point in enumerate(task.names):
        cells = [_shown(v, shown) for _, values, shown in parts for v in values[i]]
        lines.append(table_row([point, *cells, together(done.doubts[i]), ""]))
    write_text(Path(path), "".join(lines))


def corrected_document(
    done: Compensation, task: ToolPath, residual: Array | None = None
) -> dict[str, Any]:
    """What a compensation says, for programs.

    Args:
        done: The compensation.
        task: The path it is for.
        residual: (N, 3) what remains with the true compliances [m], if they are known.
    """
    robot = done.arm.robot
    points = []
    for i, name in enumerate(task.names):
        point: dict[str, Any] = {"point": name, "line": task.lines[i]}
        for joint, value in zip(robot.joints, done.q[i], strict=True):
            key = f"q_{joint.kind.key}"
            point.setdefault(key, {})[joint.name] = float(joint.kind.scale * value)
        point["before_mm"] = _listed(1e3 * done.before[i])
        point["after_mm"] = _listed(1e3 * done.after[i])
        point["rho0_mm"] = float(1e3 * done.rho0[i])
        point["expected_mm"] = float(1e3 * done.expected[i])
        if residual is not None:
            point["residual_mm"] = _listed(1e3 * residual[i])
        point |= {
            "converged": bool(done.converged[i]),
            "iterations": int(done.iterations[i]),
            "damped": bool(done.damped[i]),
            "remark": together(done.doubts[i]),
            "doubts": doubt_entries(done.doubts[i]),
        }
        points.append(point)
    return {
        "rule": done.rule,
        "path": {"file": task.source, "sha256": task.sha256, "remarks": list(task.remarks)},
        "model": done.model.source,
        "tool": done.arm.tool.name,
        "limit_95_mm": 1e3 * done.limit,
        "notes": [worded(note) for note in done.notes],
        "points": points,
    }


def _joints(robot: Robot, what: str) -> tuple[str, ...]:
    return tuple(f"{j.name}{what} [{j.kind.key}]" for j in robot.joints)


def _vector(first: str) -> tuple[str, ...]:
    """Three columns, for 'deflection dx' that one and 'deflection dy', 'deflection dz'."""
    return tuple(f"{first[:-1]}{axis} [mm]" for axis in "xyz")


def _orientations(form: Form | None, poses: Array) -> list[tuple[tuple[str, ...], Array, str]]:
    """The orientation columns, none for robots that cannot choose it."""
    if form is None:
        return []
    unit = f" [{form.written}]" if form.written else ""
    there = np.isfinite(poses).all(axis=(1, 2))
    values = np.full((len(poses), len(form.columns)), np.nan)
    values[there] = form.values(poses[there, :3, :3]) / form.units[form.written]
    return [(tuple(f"{name}{unit}" for name in form.columns), values, "0.9f")]


def _listed(vector: Array) -> list[float]:
    return [float(v) for v in vector]


def _shown(value: float, digits: str) -> str:
    """A number in a cell, without a minus before zero; empty if there is none."""
    if not np.isfinite(value):
        return ""
    text = format(value, digits)
    return text.removeprefix("-") if not float(text) else text
