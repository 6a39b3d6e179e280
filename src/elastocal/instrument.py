"""Instruments: how well a deflection is measured, as a covariance at every measured point.

In: points in the base frame. Out: (…, 3, 3) covariances of one measured deflection [m²].
"""

from __future__ import annotations

import abc
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.errors import InputError


class Instrument(abc.ABC):
    """What measures deflections."""

    @abc.abstractmethod
    def covariance(self, points: Array) -> Array:
        """(N, 3, 3) covariance of a deflection measured at `points`, (N, 3) [m²], base frame."""

    @property
    @abc.abstractmethod
    def sigma(self) -> float:
        """Standard deviation of one coordinate [m], typical where it depends on the point."""


@dataclass(frozen=True)
class Isotropic(Instrument):
    """The same independent noise in every coordinate, wherever the point is.

    Attributes:
        deviation: Standard deviation of one coordinate of one deflection [m].

    Source: paper eq. (10); per axis, see docs/conventions.md.
    """

    deviation: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.deviation) and self.deviation > 0.0):
            raise InputError(f"sigma must be a positive length, found {self.deviation}")

    @property
    def sigma(self) -> float:
        """Standard deviation of one coordinate [m]."""
        return self.deviation

    def covariance(self, points: Array) -> Array:
        """(N, 3, 3) σ² I₃ [m²]."""
        return np.broadcast_to(self.deviation**2 * np.eye(3), (len(points), 3, 3))


@dataclass(frozen=True)
class LaserTracker(Instrument):
    """A laser tracker: good along its beam, worse across it, both growing with the range.

    A deflection is the difference of two readings of nearly the same point, so its covariance
    is twice that of a reading. All numbers are standard deviations, not maximum permissible
    errors.

    Attributes:
        position: (3,) centre of the tracker head in the base frame [m].
        along: Standard deviation along the beam [m].
        along_per_metre: What the range adds to it, per metre.
        across: Standard deviation across the beam [m].
        across_per_metre: What the range adds to it, per metre.
        typical_range: Range for which `sigma` is quoted [m].
    """

    position: Array
    along: float
    along_per_metre: float
    across: float
    across_per_metre: float
    typical_range: float = 3.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "position", frozen(np.reshape(self.position, 3)))
        for name in ("along", "along_per_metre", "across", "across_per_metre"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"laser tracker: {name} must not be negative, found {value}")
        if not (self.along > 0.0 and self.across > 0.0):
            raise InputError("laser tracker: the noise along and across the beam must be positive")

    def deviations(self, ranges: Array) -> tuple[Array, Array]:
        """Standard deviations along and across the beam of one reading at `ranges` [m]."""
        return (
            self.along + self.along_per_metre * ranges,
            self.across + self.across_per_metre * ranges,
        )

    @property
    def sigma(self) -> float:
        """Root mean square over the three axes of a deflection at the typical range [m]."""
        along, across = self.deviations(np.array(self.typical_range))
        return float(np.sqrt(2.0 * (along**2 + 2.0 * across**2) / 3.0))

    def covariance(self, points: Array) -> Array:
        """(N, 3, 3) 2 (s∥² u uᵀ + s⊥² (I - u uᵀ)) with u along the beam [m²].

        Source: ours; the two-component model is the usual one for trackers (ISO 10360-10).
        """
        beam = points - self.position
        ranges = np.linalg.norm(beam, axis=-1)
        unit = beam / np.maximum(ranges, 1e-9)[:, None]
        along, across = self.deviations(ranges)
        projector = unit[:, :, None] * unit[:, None, :]
        return np.asarray(
            2.0
            * (
                across[:, None, None] ** 2 * np.eye(3)
                + (along**2 - across**2)[:, None, None] * projector
            )
        )
