"""Inverse kinematics: the configuration near another one that brings the tool to a pose.

For paths that are given as poses. Newton's method with damped steps, within the joint limits, so
it stays on the branch (elbow, wrist) of the configuration it starts from.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.robot.chain import Robot
from elastocal.robot.damped_steps import damped_steps
from elastocal.robot.posture import Posture
from elastocal.robot.rotations import rotation_vectors

_MOST_STEPS = 200
_CLOSE = 1e-11  # remaining error that counts as none [m, rad]
_LONGEST = 0.3  # longest step [rad or m]
_STRIDE = 16
_MOST_TOGETHER = 12
_BLOCKS = 128  # times that many points are searched at once ...
_MANY = 2048  # on paths of more points than this
_SLACK = 0.02  # how far a path may bend between two points of the line [rad or m]


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
        errors, jacobians = _state(robot, q[None], point, target[None])
        error, columns = errors[0], jacobians[0]
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


def follow(robot: Robot, point: Array, targets: Array, start: Array) -> tuple[Array, Reached]:
    """Configurations along a path of poses, each on the branch of the one before.

    Every sixteenth point is searched from the one before it. Those between start on the straight
    line between their neighbours and are searched all at once; where that leads away from the
    line, one after the other. Of a path of thousands of points every sixteenth is followed so,
    then the points between them all at once, as far as that goes well.

    Args:
        robot: The robot.
        point: (3,) point in the flange frame [m].
        targets: (N, 4, 4) poses of the point, N at least 1, as for `nearest_configuration`.
        start: (n,) configuration near the first one [rad or m].

    Returns:
        (M, n) configurations [rad or m] and how near the last one is to its pose: M is N, or the
        number of points up to the first that is not reached.
    """
    first = nearest_configuration(robot, point, targets[0], start)
    known = first.q[None]
    if len(targets) > _MANY and first.found:
        coarse, end = follow(robot, point, targets[::_STRIDE], first.q)
        known = _between(robot, point, targets, coarse if end.found else coarse[:-1])
        first = Reached(known[-1], 0.0, 0.0)
    parts, last, done = [known], first, len(known)
    while done < len(targets) and last.found:
        block = targets[done : done + _STRIDE]
        end = nearest_configuration(robot, point, block[-1], last.q)
        shares = np.arange(1, len(block) + 1)[:, None] / len(block)
        line = last.q + shares * (end.q - last.q)
        q = _together(robot, point, block, line) if end.found else None
        if q is None:
            q, last = _one_by_one(robot, point, block, last.q)
        else:
            last = end
        parts.append(q)
        done += len(q)
    return np.concatenate(parts), last


def _between(robot: Robot, point: Array, targets: Array, coarse: Array) -> Array:
    """Configurations near the straight lines between those of every sixteenth point.

    As far as they are found, up to the last such point before one that is not.
    """
    rows = 6 if len(robot.joints) >= 6 else 3
    shares = np.arange(1, _STRIDE + 1)[:, None] / _STRIDE
    parts = [coarse[:1]]
    for i in range(0, len(coarse) - 1, _BLOCKS):
        ends = coarse[i : i + _BLOCKS + 1]
        ways = np.diff(ends, axis=0)
        line = (ends[:-1, None] + shares * ways[:, None]).reshape(-1, len(robot.joints))
        wanted = targets[1 + i * _STRIDE :][: len(line)]
        q, left = line.copy(), np.arange(len(line))
        for _ in range(_MOST_TOGETHER):
            errors, jacobians = _state(robot, q[left], point, wanted[left])
            off = ~(np.abs(errors[:, :rows]).max(axis=1) < _CLOSE)
            left = left[off]
            if not len(left):
                break
            wrong, columns = errors[off, :rows], jacobians[off, :rows]
            q[left] += damped_steps(columns, wrong, robot.prismatic).step
        near = np.abs(q - line) <= _SLACK + np.repeat(np.abs(ways), _STRIDE, axis=0)
        inside = (q >= robot.lower) & (q <= robot.upper)
        bad = np.append(left, np.flatnonzero(~(near & inside).all(axis=1)))
        good = int(bad.min()) // _STRIDE * _STRIDE if len(bad) else len(q)
        parts.append(q[:good])
        if len(bad):
            break
    return np.concatenate(parts)


def _one_by_one(robot: Robot, point: Array, targets: Array, near: Array) -> tuple[Array, Reached]:
    """Configurations up to the first pose that is not reached, and how near the last one is."""
    found = []
    for target in targets:
        reached = nearest_configuration(robot, point, target, near)
        near = reached.q
        found.append(near)
        if not reached.found:
            break
    return np.array(found), reached


def _together(robot: Robot, point: Array, targets: Array, line: Array) -> Array | None:
    """Configurations near a straight line; None if one is not found, or leads away from it."""
    rows, q = 6 if len(robot.joints) >= 6 else 3, line.copy()
    for _ in range(_MOST_TOGETHER):
        errors, jacobians = _state(robot, q, point, targets)
        if np.abs(errors[:, :rows]).max() < _CLOSE:
            near = np.abs(q - line) <= _SLACK + np.abs(line[-1] - line[0])
            inside = (q >= robot.lower) & (q <= robot.upper)
            return q if bool((near & inside).all()) else None
        q = q + damped_steps(jacobians[:, :rows], errors[:, :rows], robot.prismatic).step
        if not np.abs(q - line).max() < _LONGEST:
            return None
    return None


def _state(robot: Robot, q: Array, point: Array, targets: Array) -> tuple[Array, Array]:
    """(N, 6) displacement and turn that are missing, and the (N, 6, n) Jacobians."""
    posture = Posture(robot, q)
    at = posture.point(point)
    rotation = posture.bodies[-1][:3].transpose(2, 0, 1)  # transposed: rows are the axes
    missing = rotation_vectors(targets[:, :3, :3] @ rotation)
    columns = np.zeros((len(q), 6, len(robot.joints)))
    columns[:, :3] = posture.point_jacobian(at).transpose(2, 0, 1)
    columns[:, 3:] = posture.turns.transpose(2, 0, 1)
    return np.hstack([targets[:, :3, 3] - at.T, missing]), columns


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
