"""Motion space: where and how fast a robot may move, and what it must not touch on the way."""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.arrays import Array
from elastocal.constraints import Clearance, Constraint
from elastocal.motion.pace import Pace
from elastocal.robot.chain import Robot


@dataclass(frozen=True)
class MotionSpace:
    """The configurations that a robot moves among.

    Attributes:
        robot: The robot.
        limits: (2, n) lower and upper joint values allowed [rad or m].
        pace: Home and speeds, with a value for every joint.
        clearances: What must not be touched; nothing is watched if empty.
        holding: What else holds wherever the robot is, such as a least height.
    """

    robot: Robot
    limits: Array
    pace: Pace
    clearances: tuple[Clearance, ...] = ()
    holding: tuple[Constraint, ...] = ()
