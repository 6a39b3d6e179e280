"""Near: load cases so close to each other that what no model explains is the same in both.

Nothing is known of how friction and discrepancy change from configuration to configuration, but a
degree beside it they are what they were. Who counts close load cases as independent can make any
error of load cases vanish by splitting one into many.

In: a robot, load cases. Out: which go together, and how many readings share their errors.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.robot.chain import Robot

NEAR = float(np.radians(10.0))
"""Joint values, and directions of loads, up to which two are near [rad]; ours."""
NEAR_SLIDING = 0.1
"""The same of joints that slide [m]."""


def near_configurations(robot: Robot, q: Array) -> IntArray:
    """(S,) number of the group of each configuration (S, n): a chain of near ones is one."""
    return _groups(_close(robot, q))


def near_load_cases(robot: Robot, cases: LoadCases) -> IntArray:
    """(S,) number of the group of each load case, by configuration and load."""
    close = _close(robot, cases.q)
    for part in (cases.wrench[:, :3], cases.wrench[:, 3:]):
        size = np.linalg.norm(part, axis=1)
        along = part @ part.T >= np.cos(NEAR) * np.outer(size, size)
        close &= along & (np.minimum.outer(size, size) >= 0.5 * np.maximum.outer(size, size))
    return _groups(close)


def together(robot: Robot, cases: LoadCases, repeats: IntArray) -> Array:
    """(S,) readings that share the errors of each load case, measured (S,) times."""
    group = near_load_cases(robot, cases)
    return np.asarray(np.bincount(group, weights=repeats.astype(float))[group])


def _close(robot: Robot, q: Array) -> BoolArray:
    """(S, S) which configurations are near; whole turns do not matter."""
    apart = np.abs(q[:, None] - q)
    turned = np.abs(apart - 2.0 * np.pi * np.round(apart / (2.0 * np.pi)))
    apart = np.where(robot.prismatic, apart * (NEAR / NEAR_SLIDING), turned)
    return np.asarray(apart.max(axis=2, initial=0.0) <= NEAR)


def _groups(close: BoolArray) -> IntArray:
    """(S,) numbers of the groups that a symmetric relation (S, S) makes, in order."""
    lowest = np.arange(len(close))
    while True:
        new = np.where(close, lowest, len(close)).min(axis=1, initial=len(close))
        if (new == lowest).all():
            return np.asarray(np.unique(lowest, return_inverse=True)[1].reshape(len(close)))
        lowest = new
