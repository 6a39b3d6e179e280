"""Inverse kinematics: the configuration near another one that brings the tool to a pose.

For paths that are given as poses. Newton's method with damped steps, within the joint limits, so
it stays on the branch (elbow, wrist) of the configuration it starts from.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.damped import damped_steps
from elastocal.posture import Posture
from elastocal.robot import Robot
from elastocal.rotations import rotation_vectors

_MOST_STEPS = 200
_CLOSE = 1e-11  # remaining error that counts as none [m, rad]
_LONGEST = 0.3  # longest step [rad or m]


class Reached(NamedTuple):
    """How near the tool came to a pose."""

    q: Array
    """(n,) configuration [rad or m]."""
    distance: float
    """Distance of the point from where it should be [m]."""
    turn: float
    """Angle from the orientation it should have [rad]; zero if none was asked for."""

    @property
    def found(self) -> bool:
        """Whether it came there."""
        return self.distance < 1e2 * _CLOSE and self.turn < 1e2 * _CLOSE


def nearest_configuration(robot: Robot, point: Array, target: Array, start: Array) -> Reached:
    """The configuration that brings a point of the flange to a pose, starting from another one.

    Args:
        robot: The robot.
        point: (3,) point in the flange frame [m].
        target: (4, 4) pose of the point with the axes of the flange, base frame [m]; with fewer
            than six joints its orientation is ignored.
        start: (n,) configuration to start from [rad or m].

    Source: ours, from textbook parts.
    """
    slides, rows = robot.prismatic, 6 if len(robot.joints) >= 6 else 3
    q = np.clip(start, robot.lower, robot.upper)
    best = Reached(q, np.inf, np.inf)
    for _ in range(_MOST_STEPS):
        posture = Posture(robot, q[None])
        error, columns = _state(posture, point, target)
        distance = float(np.linalg.norm(error[:3]))
        turn = float(np.linalg.norm(error[3:])) if rows == 6 else 0.0
        if distance + turn < best.distance + best.turn:
            best = Reached(q, distance, turn)
        if max(distance, turn) < _CLOSE:
            break
        step = _step_within(robot, q, columns[:rows], error[:rows], slides)
        if np.abs(step).max() < 1e-14:
            break
        q = np.clip(q + step * min(1.0, _LONGEST / np.abs(step).max()), robot.lower, robot.upper)
    return best


def _state(posture: Posture, point: Array, target: Array) -> tuple[Array, Array]:
    """(6,) displacement and turn that are missing, and the (6, n) Jacobian."""
    robot = posture.robot
    at = posture.point(point)
    rotation = posture.bodies[-1][:3, :, 0].T
    missing = rotation_vectors((target[:3, :3] @ rotation.T)[None])[0]
    columns = np.zeros((6, len(robot.joints)))
    columns[:3] = posture.point_jacobian(at)[:, :, 0]
    columns[3:, ~robot.prismatic] = posture.axes[:, ~robot.prismatic, 0]
    return np.concatenate([target[:3, 3] - at[:, 0], missing]), columns


def _step_within(robot: Robot, q: Array, columns: Array, error: Array, slides: BoolArray) -> Array:
    """Damped step; joints that it would push beyond a limit they stand at keep still."""
    free = np.ones(len(q), dtype=bool)
    step = np.zeros(len(q))
    for _ in range(len(q)):
        step = damped_steps((columns * free)[None], error[None], slides).step[0]
        stuck = free & (((q <= robot.lower) & (step < 0.0)) | ((q >= robot.upper) & (step > 0.0)))
        if not stuck.any():
            break
        free &= ~stuck
    return step
