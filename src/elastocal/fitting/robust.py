"""Robust losses: readings that lie far out count less.

A reading is judged by the norm ρ of its residual vector over the noise, which for sound readings
is χ-distributed with three degrees of freedom. The thresholds keep 95 % of the efficiency of least
squares for normal noise in three dimensions. Source: Huber & Ronchetti, Robust Statistics, ch. 7-8;
the thresholds for vectors are ours (tests recompute them).
"""

from __future__ import annotations

import abc
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array

EFFICIENCY = 0.95
"""Of robust losses against least squares where the noise is normal."""

_MEDIAN = 2.365974  # median of χ² with three degrees of freedom


class Loss(abc.ABC):
    """How much a reading counts.

    Attributes:
        tamer: The loss from whose fit this one starts, for not all losses are convex; None: the
            fit needs no start, every reading counts in full.
    """

    tamer: Loss | None

    @abc.abstractmethod
    def weight(self, size: Array) -> Array:
        """(R,) weights of residuals of these sizes ρ, 1 at zero."""

    @abc.abstractmethod
    def slope(self, size: Array) -> Array:
        """(R,) derivative of the weight in ρ."""


@dataclass(frozen=True)
class Squares(Loss):
    """Least squares: every reading counts as much as its noise says."""

    tamer = None

    def weight(self, size: Array) -> Array:
        return np.ones_like(size)

    def slope(self, size: Array) -> Array:
        return np.zeros_like(size)


@dataclass(frozen=True)
class Huber(Loss):
    """Beyond the threshold a reading pulls with constant force."""

    threshold: float = 1.62799
    tamer = Squares()

    def weight(self, size: Array) -> Array:
        return np.minimum(1.0, self.threshold / np.maximum(size, 1e-300))

    def slope(self, size: Array) -> Array:
        return np.where(size > self.threshold, -self.threshold / np.maximum(size, 1e-9) ** 2, 0.0)


@dataclass(frozen=True)
class Bisquare(Loss):
    """Beyond the threshold a reading does not count at all (Tukey)."""

    threshold: float = 5.49025
    tamer = Huber()

    def weight(self, size: Array) -> Array:
        return np.asarray(np.maximum(0.0, 1.0 - (size / self.threshold) ** 2) ** 2)

    def slope(self, size: Array) -> Array:
        inside = np.maximum(0.0, 1.0 - (size / self.threshold) ** 2)
        return np.asarray(-4.0 * size / self.threshold**2 * inside)


LOSSES: dict[str, Loss] = {"squares": Squares(), "huber": Huber(), "bisquare": Bisquare()}


def robust_scale(size: Array, dof: int) -> float:
    """Noise over what was promised, from the median size of residuals with `dof` freedoms.

    A fit makes residuals smaller than the noise: by the root of dof / 3R.
    """
    shrunk = min(max(dof, 1) / (3.0 * len(size)), 1.0)
    return max(float(np.sqrt(np.median(size**2) / _MEDIAN / shrunk)), 1e-12)


def inflation(loss: Loss, size: Array, scale: float, dof: int) -> float:
    """Variance of a robust estimate over that of least squares with unit noise.

    Args:
        loss: The loss.
        size: (R,) sizes of the residuals.
        scale: Noise over what was promised.
        dof: Degrees of freedom.

    Source: Huber & Ronchetti, Robust Statistics, eq. (7.81), for residual vectors.
    """
    relative = size / scale
    weight = loss.weight(relative)
    spread = scale**2 * float(np.sum((weight * relative) ** 2)) / dof
    bend = float(np.mean(weight + loss.slope(relative) * relative / 3.0))
    return spread / bend**2
