"""Residuals in units of the noise: whether noise alone explains how they are spread.

In: an identification. Out: values to judge and to draw.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.identification.result import Identification

_FEWEST = 8  # degrees of freedom below which a distribution tells nothing
_MOST = 500  # coordinates of which quantiles are given


@dataclass(frozen=True)
class Quantiles:
    """Sorted residuals of K coordinates against normal noise, all in its standard deviations.

    Attributes:
        found: (K,) residuals, standardised by the degrees of freedom left to them.
        expected: (K,) quantiles they should be at.
        low: (K,) lower ends of the bands that hold each of them with 95 %.
        high: (K,) upper ends.
    """

    found: Array
    expected: Array
    low: Array
    high: Array


def twice_the_noise(identification: Identification) -> Array:
    """(R, 3) two standard deviations of the readings, as promised or as estimated [m]."""
    return 2.0 * identification.noise_factor * identification.measurements.deviation


def share_inside(identification: Identification) -> float:
    """Share of the residuals within twice the noise; 95 % of normal noise are."""
    return float((np.abs(identification.residual) <= twice_the_noise(identification)).mean())


def left_out_rms(identification: Identification) -> Array:
    """(N,) root mean square of the residuals when their experiment is left out, over the noise."""
    noise = identification.noise_factor * identification.measurements.deviation
    return identification.measurements.by_experiment(identification.left_out / noise) / np.sqrt(3.0)


def residual_quantiles(identification: Identification) -> Quantiles | None:
    """Quantiles of the residuals: both tails in full, the middle thinned; None if they are few."""
    if identification.dof < _FEWEST or not np.isfinite(identification.scale):
        return None
    residual = identification.residual
    noise = identification.noise_factor * identification.measurements.deviation
    freedom = np.sqrt(identification.dof / residual.size)
    return _quantiles((residual / noise).ravel() / freedom)


def _quantiles(values: Array) -> Quantiles:
    """`values`, (K,), against the standard normal distribution.

    Source: order statistics of K uniform numbers have beta distributions.
    """
    from scipy.special import betaincinv, ndtri

    count = len(values)
    rank = np.arange(1, count + 1)
    if count > _MOST:
        tail = np.arange(_MOST // 4)
        middle = np.linspace(0, count - 1, _MOST // 2).astype(np.int64)
        rank = 1 + np.unique(np.concatenate([tail, middle, count - 1 - tail]))
    low, high = (ndtri(betaincinv(rank, count - rank + 1, share)) for share in (0.025, 0.975))
    return Quantiles(
        found=np.sort(values)[rank - 1],
        expected=ndtri((rank - 0.5) / count),
        low=np.asarray(low, dtype=np.float64),
        high=np.asarray(high, dtype=np.float64),
    )
