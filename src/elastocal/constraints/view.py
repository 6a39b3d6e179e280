"""What a laser tracker sees: range, acceptance cone of a reflector, reach of the tracker's head.

All speak of the beam from the head of the tracker, fixed in the base frame, to one marker.
"""

from __future__ import annotations

import abc

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array, frozen
from elastocal.constraints.base import Constraint, Pull
from elastocal.robot.posture import Posture, dot


class ViewConstraint(Constraint, abc.ABC):
    """A constraint on the beam to one marker.

    Attributes:
        marker: Name of the marker.
        point: (3,) the marker in the flange frame [m].
        position: (3,) head of the tracker in the base frame [m].
    """

    measuring = True

    def __init__(
        self, name: str, unit: str, marker: str, point: ArrayLike, position: ArrayLike
    ) -> None:
        self.name, self.unit, self.marker = name, unit, marker
        self.point = frozen(np.reshape(point, 3))
        self.position = frozen(np.reshape(position, 3))

    def beam(self, posture: Posture) -> tuple[Array, Array, Array]:
        """Marker (3, N), length (N,) and direction (3, N) of the beam that reaches it."""
        point = posture.point(self.point)
        beam = point - self.position[:, None]
        length = np.maximum(np.sqrt(dot(beam, beam)), 1e-9)
        return point, length, beam / length


class BoundedBeam(ViewConstraint, abc.ABC):
    """One number of the beam, at least or at most a bound."""

    measured_in: str

    def __init__(
        self,
        name: str,
        marker: str,
        point: ArrayLike,
        position: ArrayLike,
        bound: float,
        *,
        upper: bool,
    ) -> None:
        """`point` in the flange frame, `position` in the base frame [m], `bound` in its unit."""
        super().__init__(name, self.measured_in, marker, point, position)
        self.bound, self.sign = bound, -1.0 if upper else 1.0


class BeamRange(BoundedBeam):
    """Distance from the tracker to a marker, at least or at most a bound [m]."""

    measured_in = "m"

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        point, length, unit = self.beam(posture)

        def pull(weights: Array) -> Array:
            return posture.pull_point(point, self.sign * weights * unit)

        return self.sign * (length - self.bound), pull


class AcceptanceCone(ViewConstraint):
    """Angle between the viewing axis of a reflector and the way back to the tracker <= limit.

    A corner cube returns the beam only within a cone about its axis.
    """

    def __init__(
        self,
        name: str,
        marker: str,
        point: ArrayLike,
        position: ArrayLike,
        axis: ArrayLike,
        limit: float,
    ) -> None:
        """`axis` points out of the reflector, flange frame; `limit` is half the opening [rad]."""
        super().__init__(name, "rad", marker, point, position)
        self.axis = frozen(np.asarray(axis, dtype=float) / np.linalg.norm(axis))
        self.limit = limit

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        point, length, unit = self.beam(posture)
        axis = posture.direction(self.axis)
        cosine = np.clip(-dot(unit, axis), -1.0, 1.0)

        def pull(weights: Array) -> Array:
            slope = weights / np.sqrt(np.maximum(1.0 - cosine**2, 1e-6))
            moved = -(slope / length) * (axis + cosine * unit)
            return posture.pull_point(point, moved) + posture.pull_direction(axis, -slope * unit)

        return self.limit - np.arccos(cosine), pull


class HeadElevation(BoundedBeam):
    """Elevation of the beam over the horizontal, at least or at most a bound [rad].

    The bound is in [-π/2, π/2]; the tracker stands upright.
    """

    measured_in = "rad"

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        point, length, unit = self.beam(posture)
        level = np.sqrt(unit[0] ** 2 + unit[1] ** 2)

        def pull(weights: Array) -> Array:
            slope = self.sign * weights / (length * np.maximum(level, 1e-6))
            moved = -unit * (unit[2] * slope)
            moved[2] += slope
            return posture.pull_point(point, moved)

        return self.sign * (np.arctan2(unit[2], level) - self.bound), pull


class HeadAzimuth(ViewConstraint):
    """Azimuth of the beam about the vertical, from the x axis of the base, within a range."""

    def __init__(
        self,
        name: str,
        marker: str,
        point: ArrayLike,
        position: ArrayLike,
        lower: float,
        upper: float,
    ) -> None:
        """From `lower` to `upper`, at most a whole turn apart [rad]."""
        super().__init__(name, "rad", marker, point, position)
        self.middle, self.half = (lower + upper) / 2.0, (upper - lower) / 2.0

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        point, length, unit = self.beam(posture)
        off = np.arctan2(unit[1], unit[0]) - self.middle
        off -= 2.0 * np.pi * np.round(off / (2.0 * np.pi))

        def pull(weights: Array) -> Array:
            level = np.maximum(unit[0] ** 2 + unit[1] ** 2, 1e-12) * length
            slope = -np.sign(off) * weights / level
            moved = np.stack([-unit[1] * slope, unit[0] * slope, np.zeros_like(slope)])
            return posture.pull_point(point, moved)

        return self.half - np.abs(off), pull
