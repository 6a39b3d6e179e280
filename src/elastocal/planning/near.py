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
    return np.asarray(np.unique(chained(apart(robot, q, q) <= NEAR), return_inverse=True)[1])


def near_load_cases(robot: Robot, q: Array, wrench: Array, informations: Array) -> IntArray:
    """(..., S) the first of the group of each load case, by configuration, load and information.

    Args:
        robot: The robot.
        q: (..., S, n) configurations.
        wrench: (..., S, 6) loads.
        informations: (..., S, p, p) what each tells.

    Source: ours.
    """
    mean = informations.mean(axis=-3)
    close = _close(robot, q, wrench, q, wrench)
    return chained(close | _alike(informations, informations, mean))


def near_others(
    robot: Robot,
    q: Array,
    wrench: Array,
    informations: Array,
    others: tuple[Array, Array, Array],
) -> BoolArray:
    """(..., S, E) which of E other load cases each is near to, as `near_load_cases` has it.

    Args:
        robot: The robot.
        q: (..., S, n) configurations.
        wrench: (..., S, 6) loads.
        informations: (..., S, p, p) what each tells.
        others: The same of the others: (E, n), (E, 6), (E, p, p).
    """
    other_q, other_wrench, told = others
    count, more = informations.shape[-3], len(told)
    mean = (count * informations.mean(axis=-3) + told.sum(axis=0)) / (count + more)
    close = _close(robot, q, wrench, other_q, other_wrench)
    return np.asarray(close | _alike(informations, told, mean))


def _close(robot: Robot, q: Array, wrench: Array, other_q: Array, other_wrench: Array) -> BoolArray:
    """(..., A, B) which are near by configuration and load."""
    close = distances(robot, q, wrench, other_q, other_wrench) <= NEAR
    for part in (slice(0, 3), slice(3, 6)):
        one = np.linalg.norm(wrench[..., part], axis=-1)[..., :, None]
        other = np.linalg.norm(other_wrench[..., part], axis=-1)[..., None, :]
        close &= np.minimum(one, other) >= 0.5 * np.maximum(one, other)
    return np.asarray(close)


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


def _alike(informations: Array, others: Array, mean: Array) -> BoolArray:
    """(..., A, B) which informations (..., p, p) differ by next to nothing, unknown by unknown.

    Unknowns are scaled by how well the mean (..., p, p) sees them: their units do not matter.
    """
    diagonal = np.diagonal(mean, axis1=-2, axis2=-1)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    grid = (scale[..., :, None] * scale[..., None, :])[..., None, :, :]
    first, second = (
        (each * grid).reshape(*np.broadcast_shapes(each.shape, grid.shape)[:-2], -1)
        for each in (informations, others)
    )
    one, other = (first**2).sum(axis=-1)[..., :, None], (second**2).sum(axis=-1)[..., None, :]
    between = one + other - 2.0 * first @ np.swapaxes(second, -1, -2)
    return np.asarray(between <= ALIKE**2 * np.maximum(one, other))


def chained(close: BoolArray) -> IntArray:
    """(..., S) the first that a chain of a symmetric relation (..., S, S) leads to."""
    count = close.shape[-1]
    close = close | np.eye(count, dtype=bool)
    lowest = np.broadcast_to(np.arange(count), close.shape[:-1])
    while True:
        new = np.where(close, lowest[..., None, :], count).min(axis=-1, initial=count)
        if (new == lowest).all():
            return np.asarray(new)
        lowest = new
