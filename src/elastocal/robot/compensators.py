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
        return np.asarray(-(1.0 - self.rest / self._length(ways)) * along * np.sin(ways))

    def slope(self, q: Array) -> Array:
        """(N,) derivative of the lever in the joint value [m²/rad]."""
        along = self.crank * self.reach
        ways = self.angle - np.asarray(q, dtype=float)
        length = self._length(ways)
        straight = (1.0 - self.rest / length) * along * np.cos(ways)
        return np.asarray(straight - self.rest * (along * np.sin(ways)) ** 2 / length**3)

    def _length(self, ways: Array) -> Array:
        """(N,) length at angles (N,) from the line of both ends [m]."""
        along = 2.0 * self.crank * self.reach * np.cos(ways)
        return np.sqrt(np.maximum(self.crank**2 + self.reach**2 + along, 1e-12))


@dataclass(frozen=True)
class LeverShare:
    """The lever of a compensator as a share of the largest there is in a range of its joint.

    Attributes:
        compensator: The compensator.
        largest: That lever [m²].
    """

    compensator: Compensator
    largest: float

    def at(self, q: Array) -> Array:
        """(N,) shares at configurations (n, N)."""
        return self.compensator.lever(q[self.compensator.joint]) / self.largest

    def slope(self, q: Array) -> Array:
        """(N,) their derivatives in the joint value [1/rad]."""
        return self.compensator.slope(q[self.compensator.joint]) / self.largest


def lever_share(compensator: Compensator, lower: float, upper: float) -> LeverShare:
    """The share of the lever where its joint has values from `lower` to `upper` [rad]."""
    levers = compensator.lever(np.linspace(lower, upper, _STEPS))
    return LeverShare(compensator, max(float(np.abs(levers).max()), 1e-9))


_STEPS = 181


def turning_joint(robot: Robot, name: str) -> int:
    """Number of a joint that a compensator may hold.

    Raises:
        InputError: there is no such joint, or it slides.
    """
    (joint,) = robot.index([name])
    if robot.prismatic[joint]:
        raise InputError(f"joint {name!r} slides; a compensator holds one that turns")
    return joint
