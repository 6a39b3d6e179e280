"""How the tool may be held: elevation over the horizontal, tilt from a direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, frozen
from elastocal.constraints.base import Constraint, Pull
from elastocal.robot.posture import Posture


class Elevation(Constraint):
    """Angle of a flange axis over the horizontal plane, up or down, <= limit [rad].

    Source: paper Table 4, φ; which axis it means is recovered in docs/validation.md.
    """

    measuring = True

    def __init__(self, name: str, axis: ArrayLike, limit: float) -> None:
        """`axis` in the flange frame."""
        self.name, self.unit = name, "rad"
        self.axis, self.limit = _unit(axis), limit

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        axis = posture.direction(self.axis)
        rise = np.clip(axis[2], -1.0, 1.0)

        def pull(weights: Array) -> Array:
            steepness = np.zeros_like(axis)
            slope = -np.sign(rise) / np.sqrt(np.maximum(1.0 - rise**2, 1e-6))
            steepness[2] = slope * weights
            return posture.pull_direction(axis, steepness)

        return self.limit - np.abs(np.arcsin(rise)), pull


class Tilt(Constraint):
    """Angle between a flange axis and a direction of the base frame <= limit [rad]."""

    measuring = True

    def __init__(self, name: str, axis: ArrayLike, towards: ArrayLike, limit: float) -> None:
        """`axis` in the flange frame, `towards` in the base frame."""
        self.name, self.unit = name, "rad"
        self.axis, self.towards, self.limit = _unit(axis), _unit(towards), limit

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        axis = posture.direction(self.axis)
        cosine = np.clip(self.towards @ axis, -1.0, 1.0)

        def pull(weights: Array) -> Array:
            slope = weights / np.sqrt(np.maximum(1.0 - cosine**2, 1e-6))
            return posture.pull_direction(axis, np.multiply.outer(self.towards, slope))

        return self.limit - np.arccos(cosine), pull


def _unit(vector: ArrayLike) -> Array:
    return frozen(np.asarray(vector, dtype=float) / np.linalg.norm(vector))
