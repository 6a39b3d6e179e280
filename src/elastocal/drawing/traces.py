"""The way of the tool along a test path, as a line."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture
from elastocal.study.study import TestPose
from elastocal.study.test_path import TestPath

_MOST = 400  # points that a line needs


def trace(robot: Robot, pose: TestPose | TestPath) -> Array:
    """(K, 3) where the TCP is along a path, in even steps [m]; none for a single pose."""
    if not isinstance(pose, TestPath):
        return np.zeros((0, 3))
    count = len(pose.cases)
    taken = np.unique(np.linspace(0, count - 1, min(count, _MOST)).round().astype(int))
    return Posture(robot, pose.cases.q[taken]).point(pose.tool.tcp).T
