"""How large a robot is: how far its flange gets, whatever frames its description uses."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture

_SAMPLES = 1000  # random configurations


def reach_of(robot: Robot) -> float:
    """Largest distance of the flange from the middle of the arm [m].

    Over random configurations within the robot's limits. The middle is that of all positions, put
    on the first axis if that turns; a rail under the arm stands still. Nothing of it depends on
    where frames are: a calibrated table may have them hundreds of metres from the arm.

    Source: ours.
    """
    first = first_turning(robot)
    rail = 1 if first == 1 else 0
    posture = random_posture(robot, np.array([robot.lower, robot.upper]), still=rail)
    flange = posture.bodies[-1][3]
    middle = 0.5 * (flange.min(axis=1) + flange.max(axis=1))[:, None]
    if first == rail < len(robot.joints):
        axis, origin = posture.axes[:, first, :1], posture.origins[:, first, :1]
        middle = origin + axis * float((axis * (middle - origin)).sum())
    return float(np.sqrt(((flange - middle) ** 2).sum(axis=0)).max())


def first_turning(robot: Robot) -> int:
    """Number of the first joint that turns; n if none does."""
    return int(np.argmin(np.append(robot.prismatic, False)))


def random_posture(robot: Robot, limits: Array, *, still: int = 0) -> Posture:
    """The robot in 1000 configurations, always the same, uniform in `limits`, (2, n) [rad or m].

    A joint without limits turns within half a turn, or does not slide. The first `still` joints
    stay as near to zero as they get.
    """
    endless = np.outer([-np.pi, np.pi], ~robot.prismatic)
    low, high = np.where(np.isfinite(limits), limits, endless)
    q = np.random.default_rng(0).uniform(low, np.maximum(low, high), (_SAMPLES, len(robot.joints)))
    q[:, :still] = np.clip(0.0, low, high)[:still]
    return Posture(robot, q)
