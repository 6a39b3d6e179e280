"""Where a point of the tool may be: half-spaces (heights, boxes) and a keep-out cylinder."""

from __future__ import annotations

import abc

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, frozen
from elastocal.constraints.base import Constraint, Pull
from elastocal.robot.posture import Posture


class PointConstraint(Constraint, abc.ABC):
    """A limit on a point of the flange body.

    Attributes:
        point: (3,) in the flange frame [m].
        about: Name of the point; empty if `phrase` is the whole name.
        phrase: Name of the constraint, with a gap {} for that of the point.
    """

    def __init__(self, name: str, point: ArrayLike, about: str) -> None:
        self.name, self.unit = name.format(about) if about else name, "m"
        self.point, self.about, self.phrase = frozen(point), about, name


class HalfSpace(PointConstraint):
    """normal · p >= offset for a point p of the flange body, in the base frame [m]."""

    def __init__(
        self, name: str, point: ArrayLike, normal: ArrayLike, offset: float, about: str = ""
    ) -> None:
        """`point` in the flange frame [m]; `normal` in the base frame."""
        super().__init__(name, point, about)
        length = float(np.linalg.norm(normal))
        self.normal, self.offset = frozen(np.asarray(normal) / length), offset / length

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        point = posture.point(self.point)

        def pull(weights: Array) -> Array:
            return posture.pull_point(point, np.multiply.outer(self.normal, weights))

        return self.normal @ point - self.offset, pull


class MinRadius(PointConstraint):
    """Distance of a point of the flange body from the z axis of the base >= radius [m].

    Source: paper Table 4, r; that it is the horizontal distance is our reading.
    """

    def __init__(self, name: str, point: ArrayLike, radius: float, about: str = "") -> None:
        """`point` in the flange frame [m]."""
        super().__init__(name, point, about)
        self.radius = radius

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        point = posture.point(self.point)
        distance = np.sqrt(point[0] ** 2 + point[1] ** 2)

        def pull(weights: Array) -> Array:
            outward = point * (weights / np.maximum(distance, 1e-12))
            outward[2] = 0.0
            return posture.pull_point(point, outward)

        return distance - self.radius, pull
