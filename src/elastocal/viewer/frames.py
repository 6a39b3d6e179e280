"""Frames: where the bodies of a robot are, rigid or bent.

In: robot, configuration. Out: poses of the bodies in the base frame, 0 to n, then the flange.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture


def rigid_frames(robot: Robot, q: Array) -> Array:
    """(B + 1, 4, 4) poses of B bodies and flange [m] in a configuration (n,) [rad or m]."""
    return _stacked(Posture(robot, q[None]).bodies)


def bent_frames(arm: ElasticArm, q: Array, displacement: Array) -> Array:
    """The same with the springs of an arm displaced by (p,) [rad or m].

    A body is shown as a whole, beyond the spring of its joint and before those of its link.
    """
    bodies = Posture(arm.chain, arm.bent(q[None], displacement[None])).bodies
    return _stacked([*(bodies[number] for number in arm.numbers.tolist()), bodies[-1]])


def magnified(idle: Array, displacement: Array, factor: float) -> Array:
    """(p,) displacements of the springs to be drawn: what the load adds, `factor` times."""
    return np.asarray(idle + factor * displacement)


def suitable_factor(largest: float, size: float) -> float:
    """Magnification by which a deflection looks like a tenth of the robot: 1, 2, 5, 10, …

    Args:
        largest: Largest deflection to be shown [m].
        size: Size of the robot [m].
    """
    if not largest > 0.0:
        return 1.0
    wanted = max(0.1 * size / largest, 1.0)
    power = 10.0 ** np.floor(np.log10(wanted))
    return float(max(step * power for step in (1.0, 2.0, 5.0) if step * power <= wanted))


def _stacked(bodies: list[Array]) -> Array:
    """(len(bodies), 4, 4) transforms of frames (4, 3, 1)."""
    transforms = np.zeros((len(bodies), 4, 4))
    for transform, body in zip(transforms, bodies, strict=True):
        transform[:3] = body[:, :, 0].T
        transform[3, 3] = 1.0
    return transforms
