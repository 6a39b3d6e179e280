"""Errors that all readings of one pose share, as those of a tracker's station or of a probe.

In: an instrument, how far off its readings of a pose are together. Out: an instrument whose
readings of one pose are correlated; of different poses they are as independent as ever.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.measuring.instrument import Instrument, WhitePull


@dataclass(frozen=True)
class CommonErrors(Instrument):
    """An instrument with a translation and a rotation besides, one of each for a whole deflection.

    The rotation is about the centroid of the markers. Where rotations are measured, it is in
    these, too. Both are noise of the instrument: what is found of one is found of all.

    Attributes:
        own: What each reading errs by itself.
        translation: Standard deviation of a coordinate of the translation [m].
        rotation: Of a component of the rotation, axis times angle [rad].

    Source: ours; covariance H diag(u_t² 1, u_r² 1) Hᵀ, H = [1, -[r]ₓ].
    """

    own: Instrument
    translation: float = 0.0
    rotation: float = 0.0
    sigma_rotation: float | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        for size in (self.translation, self.rotation):
            if not (np.isfinite(size) and size >= 0.0):
                raise InputError(f"a common error must be zero or more and finite, found {size}")
        single = self.own.sigma_rotation
        if single is not None:
            object.__setattr__(self, "sigma_rotation", float(np.hypot(single, self.rotation)))

    @property
    def single(self) -> Instrument:
        """What each reading errs by itself."""
        return self.own

    @property
    def sigma(self) -> float:
        """Standard deviation of one coordinate of a marker at the centroid [m]."""
        return float(np.hypot(self.own.sigma, self.translation))

    @property
    def alike_everywhere(self) -> bool:
        """Whether the covariance of a position is the same wherever markers are."""
        return self.own.alike_everywhere and self.rotation == 0.0

    def covariance(self, points: Array) -> Array:
        """(N, 3, 3) covariance of markers each of which is the only one [m²]."""
        return np.asarray(self.own.covariance(points) + self.translation**2 * np.eye(3))

    def covariances(self, points: Array) -> Array:
        """(N, T, 3, 3) of all that an experiment reads, what is common included [m², rad²]."""
        common = self.common(points)
        return self.own.covariances(points) + common @ common.transpose(0, 1, 3, 2)

    def common(self, points: Array) -> Array:
        """(N, T, 3, 6) what a unit of each common error moves."""
        moved = self._columns(np.moveaxis(points, 0, -1))  # (3T, 6, N)
        return np.asarray(np.moveaxis(moved.reshape(-1, 3, 6, len(points)), -1, 0))

    def whiten(self, rows: Array, points: Sequence[Array]) -> tuple[Array, WhitePull]:
        """L⁻¹ of rows over the noise of each reading, LLᵀ = 1 + H Hᵀ, H the columns over it too.

        Source: textbook; the gradient is that of Cholesky's factor, Murray 2016.
        """
        p = rows.shape[1]
        both = np.concatenate([rows, self._columns(np.stack(points))], axis=1)
        white, unwhiten = self.own.whiten(both, points)
        first = np.moveaxis(white, -1, 0)  # (N, 3T, p + 6)
        columns = first[:, :, p:]
        lower = np.linalg.cholesky(
            np.eye(len(rows)) + columns @ np.ascontiguousarray(columns.transpose(0, 2, 1))
        )
        inverse = np.linalg.inv(lower)
        found = inverse @ first[:, :, :p]

        def pull(cotangent: Array) -> tuple[Array, list[Array] | None]:
            own = inverse.transpose(0, 2, 1) @ np.moveaxis(cotangent, -1, 0)
            part = -np.tril(own @ found.transpose(0, 2, 1))
            part = np.tril(lower.transpose(0, 2, 1) @ part)
            part -= 0.5 * part * np.eye(len(rows))
            part = inverse.transpose(0, 2, 1) @ part @ inverse
            of_columns = (part + part.transpose(0, 2, 1)) @ columns
            back, moved = unwhiten(np.moveaxis(np.concatenate([own, of_columns], axis=2), 0, -1))
            turned = self._pulled(back[:, p:], len(points))
            if moved is not None:
                turned = [a + b for a, b in zip(turned, moved, strict=True)]
            return back[:, :p], turned

        return np.moveaxis(found, 0, -1), pull

    def _columns(self, points: Array) -> Array:
        """(3T, 6, N) columns at points (K, 3, N): translations, then rotations."""
        arm = points - points.mean(axis=0)
        count, n = points.shape[::2]
        targets = count + (self.own.sigma_rotation is not None)
        found = np.zeros((targets, 3, 6, n))
        for j, axis in enumerate(np.eye(3)):
            found[:count, j, j] = self.translation
            found[:count, :, 3 + j] = self.rotation * np.cross(axis, arm, axisb=1, axisc=1)
            found[count:, j, 3 + j] = self.rotation
        return found.reshape(3 * targets, 6, n)

    def _pulled(self, bars: Array, count: int) -> list[Array]:
        """Gradients (3, N) in the points, of those in the columns (3T, 6, N)."""
        own = bars.reshape(-1, 3, 6, bars.shape[-1])[:count]
        moved = np.zeros((count, 3, bars.shape[-1]))
        for j, axis in enumerate(np.eye(3)):
            moved += self.rotation * np.cross(own[:, :, 3 + j], axis, axisa=1, axisc=1)
        return list(moved - moved.mean(axis=0))
