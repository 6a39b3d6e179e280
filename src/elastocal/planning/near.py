"""Near: load cases so close to each other that what no model explains is the same in both.

Nothing is known of how friction and discrepancy change from configuration to configuration, but a
degree beside it they are what they were. Who counts close load cases as independent can make any
error of load cases vanish by splitting one into many. The same is true of load cases that nothing
tells apart but the way the arm is folded, as with the wrist turned over.

In: a robot, load cases, what they tell. Out: which go together.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.design.twins import ALIKE
from elastocal.robot.chain import Robot

NEAR = float(np.radians(10.0))
"""Joint values, and directions of loads, up to which two are near [rad]; ours."""
NEAR_SLIDING = 0.1
"""The same of joints that slide [m]."""


def near_configurations(robot: Robot, q: Array) -> IntArray:
    """(S,) number of the group of each configuration (S, n): a chain of near ones is one."""
    return np.asarray(np.unique(_first(apart(robot, q, q) <= NEAR), return_inverse=True)[1])


def near_load_cases(robot: Robot, q: Array, wrench: Array, informations: Array) -> IntArray:
    """(..., S) the first of the group of each load case, by configuration, load and information.

    Args:
        robot: The robot.
        q: (..., S, n) configurations.
        wrench: (..., S, 6) loads.
        informations: (..., S, p, p) what each tells.

    Source: ours.
    """
    close = distances(robot, q, wrench, q, wrench) <= NEAR
    for part in (wrench[..., :3], wrench[..., 3:]):
        size = np.linalg.norm(part, axis=-1)
        least = np.minimum(size[..., :, None], size[..., None, :])
        close &= least >= 0.5 * np.maximum(size[..., :, None], size[..., None, :])
    return _first(close | _alike(informations))


def distances(robot: Robot, q: Array, wrench: Array, other_q: Array, other_wrench: Array) -> Array:
    """(..., A, B) largest difference of a joint, or of the direction of force or moment [rad]."""
    between = apart(robot, q, other_q)
    for part in (slice(0, 3), slice(3, 6)):
        first, second = wrench[..., part], other_wrench[..., part]
        sizes = (np.linalg.norm(one, axis=-1) for one in (first, second))
        one, other = sizes
        size = one[..., :, None] * other[..., None, :]
        there = size > 0.0
        along = first @ np.swapaxes(second, -1, -2) / np.where(there, size, 1.0)
        turned = np.arccos(np.clip(along, -1.0, 1.0))
        between = np.maximum(between, np.where(there, turned, 0.0))
    return np.asarray(between)


def apart(robot: Robot, first: Array, second: Array) -> Array:
    """(..., A, B) largest difference of a joint; whole turns do not matter, 0.1 m are 10° [rad]."""
    between = np.abs(first[..., :, None, :] - second[..., None, :, :])
    turned = np.abs(between - 2.0 * np.pi * np.round(between / (2.0 * np.pi)))
    between = np.where(robot.prismatic, between * (NEAR / NEAR_SLIDING), turned)
    return np.asarray(between.max(axis=-1, initial=0.0))


def _alike(informations: Array) -> BoolArray:
    """(..., S, S) which informations (..., S, p, p) differ by next to nothing, unknown by unknown.

    Unknowns are scaled by how well all together see them: their units do not matter.
    """
    diagonal = np.diagonal(informations.mean(axis=-3), axis1=-2, axis2=-1)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    scaled = informations * (scale[..., :, None] * scale[..., None, :])[..., None, :, :]
    flat = scaled.reshape(*scaled.shape[:-2], -1)
    square = (flat**2).sum(axis=-1)
    between = square[..., :, None] + square[..., None, :] - 2.0 * flat @ np.swapaxes(flat, -1, -2)
    largest = np.maximum(square[..., :, None], square[..., None, :])
    return np.asarray(between <= ALIKE**2 * largest)


def _first(close: BoolArray) -> IntArray:
    """(..., S) the first that a chain of a symmetric relation (..., S, S) leads to."""
    count = close.shape[-1]
    close = close | np.eye(count, dtype=bool)
    lowest = np.broadcast_to(np.arange(count), close.shape[:-1])
    while True:
        new = np.where(close, lowest[..., None, :], count).min(axis=-1, initial=count)
        if (new == lowest).all():
            return np.asarray(new)
        lowest = new
