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
from elastocal.design.twins import twins
from elastocal.elastic.load_cases import LoadCases
from elastocal.robot.chain import Robot

NEAR = float(np.radians(10.0))
"""Joint values, and directions of loads, up to which two are near [rad]; ours."""
NEAR_SLIDING = 0.1
"""The same of joints that slide [m]."""


def near_configurations(robot: Robot, q: Array) -> IntArray:
    """(S,) number of the group of each configuration (S, n): a chain of near ones is one."""
    return _groups(apart(robot, q, q) <= NEAR)


def near_load_cases(robot: Robot, cases: LoadCases, informations: Array) -> IntArray:
    """(S,) number of the group of each load case, by configuration, load and information (S, p, p).

    Source: ours.
    """
    close = distances(robot, cases, cases) <= NEAR
    for part in (cases.wrench[:, :3], cases.wrench[:, 3:]):
        size = np.linalg.norm(part, axis=1)
        close &= np.minimum.outer(size, size) >= 0.5 * np.maximum.outer(size, size)
    for group in twins(informations, np.ones(len(cases), dtype=np.int64)):
        close[np.ix_(group, group)] = True
    return _groups(close)


def distances(robot: Robot, one: LoadCases, other: LoadCases) -> Array:
    """(A, B) largest difference of a joint, or of the direction of force or moment [rad]."""
    between = apart(robot, one.q, other.q)
    for part in (slice(0, 3), slice(3, 6)):
        first, second = one.wrench[:, part], other.wrench[:, part]
        size = np.outer(np.linalg.norm(first, axis=1), np.linalg.norm(second, axis=1))
        there = size > 0.0
        cosine = np.clip((first @ second.T) / np.where(there, size, 1.0), -1.0, 1.0)
        between = np.maximum(between, np.where(there, np.arccos(cosine), 0.0))
    return np.asarray(between)


def apart(robot: Robot, first: Array, second: Array) -> Array:
    """(A, B) largest difference of a joint; whole turns do not matter, 0.1 m are 10° [rad]."""
    between = np.abs(first[:, None] - second)
    turned = np.abs(between - 2.0 * np.pi * np.round(between / (2.0 * np.pi)))
    between = np.where(robot.prismatic, between * (NEAR / NEAR_SLIDING), turned)
    return np.asarray(between.max(axis=2, initial=0.0))


def _groups(close: BoolArray) -> IntArray:
    """(S,) numbers of the groups that a symmetric relation (S, S) makes, in order."""
    lowest = np.arange(len(close))
    while True:
        new = np.where(close, lowest, len(close)).min(axis=1, initial=len(close))
        if (new == lowest).all():
            return np.asarray(np.unique(lowest, return_inverse=True)[1].reshape(len(close)))
        lowest = new
