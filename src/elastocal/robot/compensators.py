"""Compensators: springs that hold part of an arm's weight at one of its joints."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.robot.chain import Robot


@dataclass(frozen=True)
class Compensator:
    """A spring, of coils or gas, from a point of the carrier to a crank that turns with a joint.

    Attributes:
        name: What it is called.
        joint: Number of the joint among those that move on their own; it turns.
        crank: Distance of the end that turns from the axis [m].
        reach: Distance of the end that stands from the axis [m].
        angle: Joint value at which both ends are in line, on opposite sides [rad].
        rest: Length at which it pulls with nothing [m].
    """

    name: str
    joint: int
    crank: float
    reach: float
    angle: float = 0.0
    rest: float = 0.0

    def __post_init__(self) -> None:
        for what in ("crank", "reach"):
            if not 0.0 < getattr(self, what) < np.inf:
                raise InputError(
                    f"compensator {self.name!r}: {what} must be a positive length, found "
                    f"{getattr(self, what):g} m"
                )
        if not 0.0 <= self.rest < np.inf:
            raise InputError(
                f"compensator {self.name!r}: its rest length must not be negative, found "
                f"{self.rest:g} m"
            )

    def lever(self, q: Array) -> Array:
        """(N,) moment on the joint at values (N,) [rad] for a spring of 1 N/m [m²].

        Source: s² = a² + L² + 2 a L cos(alpha - q), M = -K (1 - s0/s) ∂(s²/2)/∂q; textbook.
        """
        along = self.crank * self.reach
        ways = self.angle - np.asarray(q, dtype=float)
        squared = self.crank**2 + self.reach**2 + 2.0 * along * np.cos(ways)
        length = np.sqrt(np.maximum(squared, 1e-12))
        return np.asarray(-(1.0 - self.rest / length) * along * np.sin(ways))


def turning_joint(robot: Robot, name: str) -> int:
    """Number of a joint that a compensator may hold.

    Raises:
        InputError: there is no such joint, or it slides.
    """
    (joint,) = robot.index([name])
    if robot.prismatic[joint]:
        raise InputError(f"joint {name!r} slides; a compensator holds one that turns")
    return joint
