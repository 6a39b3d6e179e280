"""Goodness of fit: does the noise explain the residuals, and do repeats contradict the model?

In: whitened readings with their groups. Out: χ², and the test of lack of fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.fitting.chances import chi_square_above, normal_quantile, ratio_above
from elastocal.fitting.mixed import Rows, squares_and_shares

SURE = 1e-3
"""Probability below which chance is ruled out."""


@dataclass(frozen=True)
class LackOfFit:
    """What repeats say of the model.

    Attributes:
        pure_scale: Noise found among repeats over the promised one.
        pure_dof: Degrees of freedom of that.
        fit_scale: Scatter of the means of repeats about the model, over the promised noise.
        fit_dof: Degrees of freedom of that; zero if the model has as many unknowns.
        p_value: Probability of so large a scatter of the means if the model is right; NaN without
            freedom.
    """

    pure_scale: float
    pure_dof: int
    fit_scale: float
    fit_dof: int
    p_value: float

    @property
    def beyond_chance(self) -> bool:
        """Whether repeats contradict the model."""
        return self.p_value < SURE


def p_value_chi_square(chi_square: float, dof: int) -> float:
    """Probability that χ² with `dof` degrees of freedom is larger."""
    return chi_square_above(chi_square, dof) if dof > 0 else float("nan")


def quantiles(probability: float, dof: Array) -> Array:
    """(K,) the same for as many degrees of freedom (K,)."""
    return np.array([quantile(probability, each) for each in dof.tolist()])


def quantile(probability: float, dof: float) -> float:
    """Quantile of the normal distribution, or of Student's t."""
    if np.isinf(dof):
        return normal_quantile(probability)
    from scipy.special import stdtrit

    return float(stdtrit(dof, probability))


def p_value_ratio(scale: float, dof: float, other: float, other_dof: float) -> float:
    """Probability of two estimates of one noise so far apart, in either direction."""
    if not (dof > 0.0 and other_dof > 0.0 and np.isfinite(scale) and np.isfinite(other)):
        return float("nan")
    ratio = scale**2 / max(other**2, 1e-300)
    above = ratio_above(ratio, dof, other_dof)
    return 2.0 * min(above, 1.0 - above)


def lack_of_fit(
    residual: Array,
    noise: Array,
    group: IntArray,
    parameters: int,
    misfit: float = 0.0,
    *,
    known: bool = False,
    beside: Rows | None = None,
) -> LackOfFit | None:
    """Whether repeats contradict the model; None without repeats.

    Where the noise is known, the means are judged by it. Else it is the repeats that tell it: an
    F test, whose degrees of freedom are more where some of the scatter of the means is expected in
    absolute size.

    Args:
        residual: (R, 3) residuals over the noise.
        noise: (R, 3, 3) factors of the covariances that divided them [m].
        group: (R,) readings of the same marker under the same load case share a number, from 0.
        parameters: Number of unknowns p, less the rows of a prior.
        misfit: Squared residuals of these rows.
        known: Whether the promised noise is true.
        beside: The whole fit as rows, if there is anything in it of absolute size.

    Source: Draper & Smith, Applied Regression Analysis, ch. 2, for vectors of known covariance;
    what is absolute is ours: ν₂ = ν (ν₁ / Σ w)², w the shares of the noise in the means.
    """
    size = np.bincount(group)
    there = size > 0
    index, groups = (np.cumsum(there) - 1)[group], int(np.count_nonzero(there))
    pure_dof = 3 * (len(residual) - groups)
    if pure_dof == 0:
        return None
    # The best common value of a group weighs its readings by their own noise.
    whitener = np.linalg.inv(noise)
    precision = np.einsum("rij,rik->rjk", whitener, whitener)
    pulled = np.einsum("rij,ri->rj", whitener, residual)
    total = np.zeros((groups, 3, 3))
    right = np.zeros((groups, 3))
    np.add.at(total, index, precision)
    np.add.at(right, index, pulled)
    mean = np.linalg.solve(total, right[..., None])[..., 0]
    within = residual - np.einsum("rij,rj->ri", whitener, mean[index])
    pure = float(np.sum(within**2))
    about = max(float(np.sum(residual**2)) - pure, 0.0) + misfit
    fit_dof = 3 * groups - parameters
    if fit_dof <= 0:
        return LackOfFit(float(np.sqrt(pure / pure_dof)), pure_dof, 0.0, 0, float("nan"))
    found = max(pure / pure_dof, 1e-300)
    if known:
        p_value = p_value_chi_square(about, fit_dof)
    elif beside is None:
        p_value = ratio_above(about / fit_dof / found, fit_dof, pure_dof)
    else:
        squares, shares = squares_and_shares(beside, found)
        above = max(squares - pure_dof, 0.0) / fit_dof
        share = min(max(shares - pure_dof, 1e-9) / fit_dof, 1.0)
        p_value = ratio_above(above, fit_dof, pure_dof / share**2)
    return LackOfFit(
        pure_scale=float(np.sqrt(pure / pure_dof)),
        pure_dof=pure_dof,
        fit_scale=float(np.sqrt(about / fit_dof)),
        fit_dof=fit_dof,
        p_value=p_value,
    )
