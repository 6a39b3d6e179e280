"""The unknowns of absolute readings as virtual joints, for plans: how each moves a reading.

To first order about the arm as drawn, in the base frame: bases and reflectors move a reading as
sliding and turning joints at the base and the flange do, geometric errors as joints behind the
joints, compliances with what weights and loads exert on them.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.calibration.arm_model import ArmModel
from elastocal.elastic.springs import VirtualJoints
from elastocal.elastic.unknowns import Unknowns, each_spring, joined
from elastocal.robot.geometry import error_axes, turning

_AXES = ("x", "y", "z")


def unknown_columns(model: ArmModel, *, base: bool = True, tool: bool = True) -> Unknowns:
    """The unknowns of a model for one station and one mounting.

    Args:
        model: Arm with its geometric errors and compliances.
        base: Whether the pose of the base is unknown.
        tool: Whether the places of the reflectors are.
    """
    found = each_spring(_geometry(model))
    if base:
        found = joined(found, each_spring(_base()))
    if tool:
        found = joined(found, each_spring(_reflectors(model)))
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
