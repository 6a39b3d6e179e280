"""How the tool may be held: elevation over the horizontal, tilt from a direction."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, frozen
from elastocal.constraints.base import Constraint
from elastocal.posture import Posture


class Elevation(Constraint):
    """Angle of a flange axis over the horizontal plane, up or down, <= limit [rad].

    Source: paper Table 4, φ; which axis it means is recovered in docs/validation.md.
    """

    def __init__(self, name: str, axis: ArrayLike, limit: float) -> None:
        """`axis` in the flange frame."""
        self.name, self.unit = name, "rad"
        self.axis, self.limit = _unit(axis), limit

    def at(self, posture: Posture) -> tuple[Array, Array]:
        axis = posture.direction(self.axis)
        rise = np.clip(axis[2], -1.0, 1.0)
        steepness = np.zeros_like(axis)
        steepness[2] = -np.sign(rise) / np.sqrt(np.maximum(1.0 - rise**2, 1e-6))
        return self.limit - np.abs(np.arcsin(rise)), posture.pull_direction(axis, steepness)


class Tilt(Constraint):
    """Angle between a flange axis and a direction of the base frame <= limit [rad]."""

    def __init__(self, name: str, axis: ArrayLike, towards: ArrayLike, limit: float) -> None:
        """`axis` in the flange frame, `towards` in the base frame."""
        self.name, self.unit = name, "rad"
        self.axis, self.towards, self.limit = _unit(axis), _unit(towards), limit

    def at(self, posture: Posture) -> tuple[Array, Array]:
        axis = posture.direction(self.axis)
        cosine = np.clip(self.towards @ axis, -1.0, 1.0)
        steepness = self.towards[:, None] / np.sqrt(np.maximum(1.0 - cosine**2, 1e-6))
        return self.limit - np.arccos(cosine), posture.pull_direction(axis, steepness)


def _unit(vector: ArrayLike) -> Array:
    return frozen(np.asarray(vector, dtype=float) / np.linalg.norm(vector))
