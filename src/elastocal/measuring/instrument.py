"""Instruments: what is measured, and how well: a covariance of every deflection that is read.

In: points in the base frame. Out: (…, 3, 3) covariances of one measured deflection [m²], of one
measured rotation [rad²], and rows of the linear model in units of that noise, with their gradient
through the measured points.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.errors import InputError
from elastocal.robot.posture import dot

WhitePull = Callable[[Array], tuple[Array, list[Array] | None]]
"""Gradient in whitened rows -> gradient in the rows, and in the K points (3, N)."""


class Instrument(abc.ABC):
    """What measures deflections.

    Attributes:
        sigma_rotation: Standard deviation of one component of a measured rotation of the flange
            [rad]; None if only positions are measured.
    """

    sigma_rotation: float | None = None

    @property
    def alike_everywhere(self) -> bool:
        """Whether the covariance of a position is the same wherever the point is."""
        return False

    @abc.abstractmethod
    def covariance(self, points: Array) -> Array:
        """(N, 3, 3) covariance of a deflection measured at `points`, (N, 3) [m²], base frame."""

    @abc.abstractmethod
    def whiten(self, rows: Array, points: Sequence[Array]) -> tuple[Array, WhitePull]:
        """Rows of K markers in units of their noise, and the gradient of that.

        Args:
            rows: (3K, p, N) rows, three for each marker; batch axis last.
            points: K arrays (3, N): where the markers are, base frame [m].

        Returns:
            (3K, p, N) rows W A with W covariance Wᵀ = I, and a function that takes a gradient in
            these to one in `rows` and one in each of `points`, None if they do not matter.
            If rotations are measured, `rows` end with the three of the rotation.
        """

    @property
    @abc.abstractmethod
    def sigma(self) -> float:
        """Standard deviation of one coordinate [m], typical where it depends on the point."""

    @property
    def single(self) -> Instrument:
        """What each reading errs by itself: without what those of one pose share."""
        return self

    def common(self, points: Array) -> Array:
        """(N, T, 3, e) what a unit of each error moves that readings of one pose share [m, rad].

        Args:
            points: (N, K, 3) markers, base frame [m]; T is as in `covariances`.
        """
        targets = points.shape[1] + (self.sigma_rotation is not None)
        return np.zeros((len(points), targets, 3, 0))

    def pose_covariance(self, points: Array) -> Array:
        """(N, 3T, 3T) of all that an experiment reads together; see `covariances`."""
        common = self.common(points)
        size = 3 * common.shape[1]
        whole = np.einsum("ntie,nsje->ntisj", common, common).reshape(len(points), size, size)
        for t, part in enumerate(np.moveaxis(self.covariances(points), 1, 0)):
            whole[:, 3 * t : 3 * t + 3, 3 * t : 3 * t + 3] = part
        return np.asarray(whole)

    def covariances(self, points: Array) -> Array:
        """(N, T, 3, 3) of all that an experiment reads with K markers at `points`, (N, K, 3).

        T is K, or K + 1 if the rotation is measured: [m²], the last then [rad²].
        """
        positions = self.covariance(points.reshape(-1, 3)).reshape(*points.shape, 3)
        if self.sigma_rotation is None:
            return positions
        rotation = np.broadcast_to(self.sigma_rotation**2 * np.eye(3), (len(points), 1, 3, 3))
        return np.concatenate([positions, rotation], axis=1)


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

    @property
    def alike_everywhere(self) -> bool:
        """Yes."""
        return True

    def covariance(self, points: Array) -> Array:
        """(N, 3, 3) σ² I₃ [m²]."""
        return np.broadcast_to(self.deviation**2 * np.eye(3), (len(points), 3, 3))

    def whiten(self, rows: Array, points: Sequence[Array]) -> tuple[Array, WhitePull]:
        """Rows over σ."""
        return rows / self.deviation, lambda cotangent: (cotangent / self.deviation, None)


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
        freeze(self, position=np.reshape(self.position, 3))
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

    def whiten(self, rows: Array, points: Sequence[Array]) -> tuple[Array, WhitePull]:
        """W A with W = ((I - u uᵀ) / s⊥ + u uᵀ / s∥) / √2, the inverse root of the covariance.

        Source: ours.
        """
        parts = [_Beam(self, point) for point in points]
        triples = [rows[3 * k : 3 * k + 3] for k in range(len(parts))]

        def pull(cotangent: Array) -> tuple[Array, list[Array] | None]:
            bars = [cotangent[3 * k : 3 * k + 3] for k in range(len(parts))]
            back = [part.apply(bar) for part, bar in zip(parts, bars, strict=True)]
            moved = [p.pull(r, bar) for p, r, bar in zip(parts, triples, bars, strict=True)]
            return np.concatenate(back), moved

        white = [part.apply(triple) for part, triple in zip(parts, triples, strict=True)]
        return np.concatenate(white), pull


@dataclass(frozen=True)
class PoseProbe(Instrument):
    """A probe that reads positions and the rotation of the flange, as 6-D probes of trackers do.

    Attributes:
        points: What measures the positions.
        sigma_rotation: Standard deviation of one component of one measured rotation, from
            unloaded to loaded, axis times angle [rad]; alike and independent about all axes.

    Source: paper eqs. (5) to (8), whose Δt has all six components; the noise of a rotation is ours.
    """

    points: Instrument
    sigma_rotation: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sigma_rotation) and self.sigma_rotation > 0.0):
            raise InputError(
                f"sigma_rotation must be a positive angle, found {self.sigma_rotation}"
            )
        if self.points.sigma_rotation is not None:
            raise InputError("a pose probe needs an instrument that measures positions only")

    @property
    def sigma(self) -> float:
        """Standard deviation of one coordinate of a position [m]."""
        return self.points.sigma

    @property
    def alike_everywhere(self) -> bool:
        """Whether the positions have the same covariance wherever the point is."""
        return self.points.alike_everywhere

    def covariance(self, points: Array) -> Array:
        """(N, 3, 3) covariance of the positions [m²]."""
        return self.points.covariance(points)

    def whiten(self, rows: Array, points: Sequence[Array]) -> tuple[Array, WhitePull]:
        """Rows of the positions as their instrument has them, those of the rotation over its σ."""
        white, unwhiten = self.points.whiten(rows[:-3], points)

        def pull(cotangent: Array) -> tuple[Array, list[Array] | None]:
            back, moved = unwhiten(cotangent[:-3])
            return np.concatenate([back, cotangent[-3:] / self.sigma_rotation]), moved

        return np.concatenate([white, rows[-3:] / self.sigma_rotation]), pull


def positions_of(instrument: Instrument) -> Instrument:
    """What measures the positions: of a pose probe its part, else the instrument itself."""
    return instrument.points if isinstance(instrument, PoseProbe) else instrument


def tracker_of(instrument: Instrument) -> LaserTracker | None:
    """The laser tracker that measures the positions, None if there is none."""
    points = positions_of(instrument.single)
    return points if isinstance(points, LaserTracker) else None


@dataclass(frozen=True)
class TrackerNoise:
    """What is known of the noise of one make of tracker, wherever it stands.

    Attributes: as those of `LaserTracker`, standard deviations of one reading [m, m per metre].
    """

    along: float
    along_per_metre: float
    across: float
    across_per_metre: float

    def at(self, position: Array) -> LaserTracker:
        """Such a tracker with its head at `position`, (3,), base frame [m]."""
        return LaserTracker(
            position, self.along, self.along_per_metre, self.across, self.across_per_metre
        )


def from_permissible(
    along: float, along_per_metre: float, across: float, across_per_metre: float
) -> TrackerNoise:
    """Noise from maximum permissible errors [m]: half of each is one standard deviation.

    Source: the maker of the AT500 calls half of the permissible error the typical result; that
    this is one standard deviation is ours, see docs/decisions.
    """
    return TrackerNoise(along / 2.0, along_per_metre / 2.0, across / 2.0, across_per_metre / 2.0)


PRESETS = {"leica-at500": from_permissible(10e-6, 0.3e-6, 15e-6, 6e-6)}
"""Trackers by name.

Source: Leica AT500 user manual, p. 39 (errors after ISO 10360-10:2021, annex D: ADM and
transverse). Its parameter R0, a constant of the range, cancels in a deflection.
"""


class _Beam:
    """The beam to one marker in N configurations: W v = a v + (b - a) u (u·v)."""

    def __init__(self, tracker: LaserTracker, point: Array) -> None:
        beam = point - tracker.position[:, None]
        self.range = np.maximum(np.sqrt(dot(beam, beam)), 1e-9)
        self.unit = beam / self.range
        along, across = tracker.deviations(self.range)
        self.a, self.b = np.sqrt(0.5) / across, np.sqrt(0.5) / along
        self.a_slope = -self.a * tracker.across_per_metre / across
        self.b_slope = -self.b * tracker.along_per_metre / along

    def apply(self, vectors: Array) -> Array:
        """(3, p, N) W times `vectors`; W is symmetric, so this is its transpose too."""
        along = dot(self.unit[:, None], vectors)
        return np.asarray(self.a * vectors + ((self.b - self.a) * self.unit)[:, None] * along)

    def pull(self, rows: Array, cotangent: Array) -> Array:
        """(3, N) gradient in the point, from the gradient in W `rows`, both (3, p, N)."""
        unit = self.unit[:, None]
        rows_along, bar_along = dot(unit, rows), dot(unit, cotangent)
        lengthwise = (rows_along * bar_along).sum(axis=0)
        crosswise = dot(rows, cotangent).sum(axis=0) - lengthwise
        turn = (cotangent * rows_along + rows * bar_along).sum(axis=1)
        turn *= (self.b - self.a) / self.range
        turn -= self.unit * dot(self.unit, turn)
        return np.asarray(turn + self.unit * (crosswise * self.a_slope + lengthwise * self.b_slope))
