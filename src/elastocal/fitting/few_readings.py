"""Mixed estimation from one or two pure degrees of freedom: all sizes of the noise that may be.

In: rows as those of `mixed`. Out: the noise, and intervals that average over it. The likelihood
alone has its maximum at no noise at all in many campaigns as small as these.

Source: ours; the density is the restricted likelihood, flat in s, on a grid of log s.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.fitting.goodness import quantile
from elastocal.fitting.least_squares import column_norms, inverse_root
from elastocal.fitting.mixed import Rows, Spread, condensed, estimate

FEW = 3
"""Pure degrees of freedom from which on the likelihood alone serves; those of s², if none is."""

_POINTS = 351
_SPAN = 9.0  # of log s on either side of the scatter of the readings
_INSIDE = 0.95
_MOST_DOF = 1e6


def median_variance(rows: Rows) -> float:
    """The middle of what s² may be, over the promised one."""
    scales, share, *_ = _sizes(condensed(rows))
    return float(np.interp(0.5, np.cumsum(share), scales) ** 2)


def spread_of_few(rows: Rows) -> Spread:
    """Covariance at the middle of s², with degrees of freedom that make 95 % intervals hold.

    Each unknown is a mixture of normal distributions; its interval is between its quantiles.
    """
    rows = condensed(rows)
    scales, share, means, errors = _sizes(rows)
    variance = float(np.interp(0.5, np.cumsum(share), scales) ** 2)
    middle, covariance = estimate(rows, variance)
    size = np.sqrt(np.diagonal(covariance))
    dof = np.array([_dof(m, e, share, c, s) for m, e, c, s in zip(
        means.T, errors.T, middle, size, strict=True)])  # fmt: skip
    least = float(dof.min())
    part = np.where(dof < _MOST_DOF, (least / dof) ** 0.25, 0.0)
    by_noise = covariance * np.outer(part, part)
    return Spread(frozen(covariance), frozen(by_noise), least, variance)


def _sizes(rows: Rows) -> tuple[Array, Array, Array, Array]:
    """Sizes s (K,), their shares, and estimates and standard errors (K, p) at each."""
    found, _ = estimate(rows, 1.0)
    left = rows.own * (rows.values - rows.rows @ found) ** 2
    count = max(int((rows.own > 0.0).sum()) + rows.rest_dof, 1)
    middle = 0.5 * np.log(max((float(left.sum()) + rows.rest) / count, 1e-12))
    scales = np.exp(middle + np.linspace(-_SPAN, _SPAN, _POINTS))
    p = rows.rows.shape[1]
    weight = 1.0 / (scales[:, None] ** 2 * rows.own + rows.absolute)  # (K, R)
    root = np.sqrt(weight)[..., None]
    norms = column_norms(rows.rows * root)
    both = np.concatenate(
        [
            rows.rows * root / norms[:, None],
            np.broadcast_to(rows.values[:, None], root.shape) * root,
        ],
        axis=2,
    )
    triangle = np.asarray(np.linalg.qr(both, mode="r"))
    inverse = inverse_root(triangle[:, :p, :p]) / norms[..., None]
    means = np.einsum("kij,kj->ki", inverse, triangle[:, :p, p])
    errors = np.sqrt(np.einsum("kij,kij->ki", inverse, inverse))
    residual = rows.values - means @ rows.rows.T
    square = np.sum(weight * residual**2, axis=1) + rows.rest / scales**2
    volume = 2.0 * np.log(np.abs(np.einsum("kii->ki", inverse))).sum(axis=1)
    flat = np.log(weight).sum(axis=1) - 2.0 * rows.rest_dof * np.log(scales)
    chance = 0.5 * (flat + volume - square) + np.log(scales)
    share = np.exp(chance - chance.max())
    return scales, share / share.sum(), means, errors


def _dof(means: Array, errors: Array, share: Array, middle: float, size: float) -> float:
    """Degrees of freedom with which `size` gives the interval of one unknown's mixture."""
    from scipy.special import ndtr

    def beyond(half: float) -> float:
        above = ndtr((middle + half - means) / errors) - ndtr((middle - half - means) / errors)
        return float(share @ above) - _INSIDE

    low, high = 0.0, size
    while beyond(high) < 0.0 and high < 1e6 * size:
        high *= 2.0
    for _ in range(60):
        half = 0.5 * (low + high)
        low, high = (low, half) if beyond(half) > 0.0 else (half, high)
    ratio = half / size
    if ratio <= quantile(0.5 + 0.5 * _INSIDE, _MOST_DOF):
        return _MOST_DOF
    few, many = 0.2, _MOST_DOF
    for _ in range(100):
        dof = float(np.sqrt(few * many))
        few, many = (dof, many) if quantile(0.5 + 0.5 * _INSIDE, dof) > ratio else (few, dof)
    return dof
