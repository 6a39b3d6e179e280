"""Projection: a parallel view from the front, the right and a little above, fitted to its points.

In: points in the base frame [m]. Out: pixels, and how near a point is.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array

_AZIMUTH, _ELEVATION = np.radians(-52.0), np.radians(17.0)


class Projection:
    """A parallel view.

    Attributes:
        width: Width of the picture [px].
        height: Height of the picture [px].
        scale: Pixels for a metre across the view.
        toward: (3,) unit direction from the robot to the eye.
    """

    def __init__(
        self,
        points: Array,
        width: float,
        *,
        margins: tuple[float, float, float] = (32.0, 18.0, 22.0),
        scale: float | None = None,
    ) -> None:
        """Fit `points` (K, 3) [m] into `width` pixels, or show them at a `scale` in the middle.

        `margins` [px] are those at the sides, above and below.
        """
        c, s = np.cos(_AZIMUTH), np.sin(_AZIMUTH)
        lift = np.array([-c * np.sin(_ELEVATION), -s * np.sin(_ELEVATION), np.cos(_ELEVATION)])
        self._axes = np.array([[-s, c, 0.0], -lift])
        self.toward = np.cross([-s, c, 0.0], lift)
        seen = points @ self._axes.T
        lowest, highest = seen.min(axis=0), seen.max(axis=0)
        wide, high = (float(v) for v in highest - lowest)
        side, top, low = margins
        self.scale = (width - 2.0 * side) / wide if scale is None else scale
        self._shift = [0.5 * (width - self.scale * wide), top] - self.scale * lowest
        self.width, self.height = width, top + low + self.scale * high

    def __call__(self, points: Array) -> Array:
        """(K, 2) pixels of points (K, 3) [m]."""
        return np.asarray(points @ self._axes.T * self.scale + self._shift)

    def nearness(self, points: Array) -> Array:
        """(K,) how far points (K, 3) are toward the eye [m]."""
        return np.asarray(points @ self.toward)
