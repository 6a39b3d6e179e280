"""Skeleton: a robot in one configuration as the few points one draws.

In: robot, tool, configurations. Out: points in the base frame [m].
A link leaves its joint along the joint axis and turns off square where the next joint stands:
so offsets along axes look like the arm they are, and not like diagonals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.posture import Posture

_SAME = 1e-6  # points nearer than this are one point [m]


@dataclass(frozen=True)
class Skeleton:
    """One drawn configuration, in the base frame [m].

    Attributes:
        arm: (K, 3) polyline from the base to the flange.
        tool: Polylines (., 3) from the flange to the load point, the TCP and the markers.
        centres: (n, 3) a point of each joint.
        axes: (n, 3) unit axis of each joint.
        load_point: (3,) where the wrench acts.
        tcp: (3,) tool centre point.
        markers: (M, 3) measured points.
    """

    arm: Array
    tool: tuple[Array, ...]
    centres: Array
    axes: Array
    load_point: Array
    tcp: Array
    markers: Array

    @property
    def points(self) -> Array:
        """(., 3) all points, for a bounding box."""
        return np.vstack([self.arm, *self.tool])


def skeletons(robot: Robot, tool: Tool, q: Array) -> tuple[Skeleton, ...]:
    """Skeletons of N configurations `q`, (N, n) [rad or m], with `tool` on the flange."""
    posture = Posture(robot, q)
    tcp = tool.load_point if tool.tcp is None else tool.tcp
    ends = [tool.load_point, tcp, *tool.markers]
    placed = np.array([posture.point(end) for end in ends])
    return tuple(_skeleton(posture, placed[:, :, i], i) for i in range(posture.count))


def _skeleton(posture: Posture, ends: Array, i: int) -> Skeleton:
    """Skeleton of configuration `i`; `ends` (2 + M, 3): load point, TCP, markers [m]."""
    robot = posture.robot
    m = robot.last
    axes, origins = posture.all_axes[:, :m, i].T, posture.all_origins[:, :m, i].T
    starts = np.array([body[3, :, i] for body in posture.bodies[1 : m + 1]])
    flange = posture.bodies[-1][3, :, i]
    arm = [np.zeros(3), origins[0]]
    for start, axis, end in zip(starts, axes, [*origins[1:], flange], strict=True):
        arm += _square(start, axis, end)
    distinct: list[Array] = []
    for end in ends:
        if not any(np.linalg.norm(end - other) < _SAME for other in [*distinct, flange]):
            distinct.append(end)
    return Skeleton(
        arm=_without_repeats(arm),
        tool=tuple(_without_repeats(_square(flange, axes[-1], end)) for end in distinct),
        centres=starts[robot.place],
        axes=axes[robot.place],
        load_point=ends[0],
        tcp=ends[1],
        markers=ends[2:],
    )


def _square(start: Array, axis: Array, end: Array) -> list[Array]:
    """Way from `start` along `axis`, then square to it, to `end`."""
    corner = start + axis * float(axis @ (end - start))
    return [start, corner, end]


def _without_repeats(points: list[Array]) -> Array:
    """Points without those that repeat the one before."""
    kept = points[:1]
    for point in points[1:]:
        if np.linalg.norm(point - kept[-1]) > _SAME:
            kept.append(point)
    return np.array(kept)
