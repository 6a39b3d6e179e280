"""Configurations that are not to be taken again."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, frozen
from elastocal.constraints.base import Constraint, Pull
from elastocal.robot.posture import Posture


class Distinct(Constraint):
    """Distance in joint space from a configuration >= `least` [rad; metres count as radians].

    Whole turns do not count: they lead back to the same place.
    """

    measuring = True

    def __init__(self, name: str, q: ArrayLike, counts: ArrayLike, least: float) -> None:
        """`q` (n,) is the configuration, `counts` (n,) says which joints matter."""
        self.name, self.unit, self.least = name, "rad", least
        self.q, self.counts = frozen(q), frozen(counts)

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        difference = posture.q - self.q[:, None]
        turning = ~posture.robot.prismatic
        difference[turning] -= 2.0 * np.pi * np.round(difference[turning] / (2.0 * np.pi))
        difference *= self.counts[:, None]
        distance = np.sqrt(np.sum(difference**2, axis=0))

        def pull(weights: Array) -> Array:
            return difference * (weights / np.maximum(distance, 1e-12))

        return distance - self.least, pull
