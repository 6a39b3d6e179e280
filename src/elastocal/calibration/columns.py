"""The unknowns of absolute readings as virtual joints, for plans: how each moves a reading.

To first order about the arm as drawn, in the base frame: bases and reflectors move a reading as
sliding and turning joints at the base and the flange do, geometric errors as joints behind the
joints, compliances with what weights and loads exert on them.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.calibration.arm_model import ArmModel
from elastocal.elastic.springs import VirtualJoints, joint_springs
from elastocal.elastic.unknowns import Unknowns, each_spring, joined
from elastocal.robot.compensators import lever_share
from elastocal.robot.geometry import error_axes, turning

_AXES = ("x", "y", "z")


def unknown_columns(
    model: ArmModel, limits: Array, *, base: bool = True, tool: bool = True
) -> Unknowns:
    """The unknowns of a model for one station and one mounting.

    Args:
        model: Arm with its geometric errors, compliances and compensators.
        limits: (2, n) joint values that are allowed, all finite [rad or m].
        base: Whether the pose of the base is unknown.
        tool: Whether the places of the reflectors are.
    """
    found = each_spring(_geometry(model))
    if base:
        found = joined(found, each_spring(_base()))
    if tool:
        found = joined(found, each_spring(_reflectors(model)))
    if model.compensators:
        found = joined(found, each_spring(_compensated(model, limits)))
    return joined(found, model.compliances) if len(model.compliances) else found


def _base() -> VirtualJoints:
    """Shift and turn of the base."""
    turns = np.arange(6) >= 3
    names = tuple(f"base {'turn ' if i > 2 else ''}{axis}" for i, axis in enumerate(2 * _AXES))
    return _displacements(names, np.zeros(6), np.tile(np.eye(3), (2, 1)), np.zeros((6, 3)), ~turns)


def _reflectors(model: ArmModel) -> VirtualJoints:
    """Shifts of every reflector along the axes of the flange."""
    robot, tool = model.robot, model.tool
    T = robot.links[robot.last]
    count = len(tool.markers)
    names = tuple(f"{name} {axis}" for name in tool.marker_names for axis in _AXES)
    axes = np.tile(T[:3, :3].T, (count, 1))
    body, slides = np.full(3 * count, robot.last), np.ones(3 * count)
    only = np.asarray(np.repeat(np.arange(count), 3), dtype=np.int64)
    return _displacements(names, body, axes, np.zeros((3 * count, 3)), slides, only)


def _geometry(model: ArmModel) -> VirtualJoints:
    """Geometric errors."""
    errors = model.errors
    axes, points = error_axes(errors, np.zeros(len(errors)), model.robot.last)
    return _displacements(errors.names, errors.body, axes, points, turning(errors) == 0)


def _compensated(model: ArmModel, limits: Array) -> VirtualJoints:
    """What compensators turn their joints, at their largest levers."""
    held = sorted(model.compensators, key=lambda one: int(model.robot.place[one.joint]))
    in_joint = [joint_springs(model.robot, [model.robot.joint_names[c.joint]]) for c in held]
    body, axis, origin, joint = (
        np.concatenate([getattr(one, of) for one in in_joint])
        for of in ("body", "axis", "origin", "joint")
    )
    count = len(held)
    return VirtualJoints(
        tuple(f"compensator {one.name}" for one in held),
        body,
        axis,
        origin,
        np.zeros(count, dtype=bool),
        joint,
        np.ones(count, dtype=bool),
        by=tuple(lever_share(one, *limits[:, one.joint].tolist()) for one in held),
    )


def _displacements(
    names: tuple[str, ...],
    body: Array | IntArray,
    axis: Array,
    origin: Array,
    slides: Array | BoolArray,
    only: IntArray | None = None,
) -> VirtualJoints:
    """Virtual joints that no load moves."""
    return VirtualJoints(
        names,
        np.asarray(body, dtype=np.int64),
        axis,
        origin,
        np.asarray(slides, dtype=bool),
        stiff=np.ones(len(names), dtype=bool),
        only=np.full(len(names), -1) if only is None else np.asarray(only, dtype=np.int64),
    )


def told_apart(rows: Array, order: IntArray) -> tuple[IntArray, Array]:
    """Columns of rows (R, c) that are not made of others, and how they make the rest.

    Args:
        rows: Rows of readings, many more than columns.
        order: (c,) columns, those first that are to be kept.

    Returns:
        (k,) the columns that are kept, ascending, and (k, c): every column made of them.

    Source: ours; modified Gram-Schmidt in that order.
    """
    size = np.linalg.norm(rows, axis=0)
    scaled = rows / np.where(size > 0.0, size, 1.0)
    basis, kept = np.zeros((len(rows), 0)), []
    for c in order.tolist():
        rest = scaled[:, c]
        for _ in range(2):  # once more for what rounding leaves
            rest = rest - basis @ (basis.T @ rest)
        left = float(np.linalg.norm(rest))
        if left > _REDUNDANT:
            kept.append(c)
            basis = np.column_stack([basis, rest / left])
    chosen = np.sort(np.array(kept, dtype=np.int64))
    share = np.linalg.lstsq(rows[:, chosen], rows, rcond=None)[0]
    return chosen, np.asarray(share, dtype=float)


_REDUNDANT = 1e-6  # length of what is new in a column of unit length, below which it is none
