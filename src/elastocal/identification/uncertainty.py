"""Uncertainty of a fit: noise and covariance.

In: how it was fitted, where it came to rest. Out: the noise of the readings, and the covariance of
what was fitted with the degrees of freedom behind it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.errors import Doubt, IdentifiabilityError
from elastocal.fitting.mixed import Rows, Spread, noise_variance, spread_found, spread_known
from elastocal.fitting.robust import EFFICIENCY, inflation, robust_scale
from elastocal.identification.fit import Fit
from elastocal.identification.gauss_newton import Problem, Solution, free_rows
from elastocal.wording import worded


def noise(how: Fit, problem: Problem, found: Solution, chi_square: float) -> tuple[float, float]:
    """Noise over the promised one, and what variances of readings are to be multiplied by.

    Raises:
        IdentifiabilityError: the noise is to be estimated and nothing shows it.
    """
    dof = problem.dof
    scale = float(np.sqrt(chi_square / dof)) if dof > 0 else float("nan")
    if how.robust:
        size = np.linalg.norm(found.residual, axis=1)
        scale = robust_scale(size, dof)
        used = scale if how.estimates_sigma else 1.0
        variance = inflation(how.weigher, size, used, max(dof, 1))
        if not how.estimates_sigma:  # no robust fit beats least squares by luck
            variance = max(variance, 1.0 / EFFICIENCY)
        return scale, variance
    if not how.estimates_sigma:
        return scale, 1.0
    variance = scale**2 if dof > 0 else 0.0
    if len(problem.extra_rows):
        rows = rows_at(problem, found)
        shown = rows.pure_dof > 0
        variance = noise_variance(rows, problem.variance) if shown else 0.0
    if not variance > 0.0 and (dof < 1 or len(problem.extra_rows)):
        doubt = Doubt("no-freedom", numbers={"readings": len(found.residual)})
        raise IdentifiabilityError(worded(doubt)).with_doubts(doubt)
    return float(np.sqrt(variance)), variance


def rows_at(problem: Problem, found: Solution) -> Rows:
    """The whole fit as rows, linearised where it came to rest."""
    root = np.sqrt(found.weight)[:, None]
    rows = (free_rows(problem, found) * root[..., None]).reshape(-1, found.compliance.shape[-1])
    values = (found.residual * root).ravel() + rows @ found.compliance
    extra = len(problem.extra_rows)
    return Rows(
        rows=np.concatenate([rows, problem.extra_rows]),
        values=np.append(values, problem.extra_values[0]),
        own=np.append(np.ones(len(rows)), np.zeros(extra)),
        absolute=np.append(np.zeros(len(rows)), np.ones(extra)),
    )


def spread_of(how: Fit, problem: Problem, found: Solution, variance: float) -> Spread:
    """Covariance of what was fitted, the bounds left out: what is held is as uncertain as ever."""
    dof = float(problem.dof) if how.estimates_sigma else np.inf
    if not len(problem.extra_rows):
        covariance = frozen(variance * found.fit.covariance)
        return Spread(covariance, covariance, dof, variance)
    rows = rows_at(problem, found)
    if not how.estimates_sigma:
        return spread_known(rows, variance)
    spread = spread_found(rows, variance)
    return replace(spread, dof=dof) if how.robust else spread


def triangle_of(problem: Problem, found: Solution, variance: float) -> Array:
    """(f, f) upper triangular R with RᵀR the information, the variances of readings multiplied."""
    triangle = found.fit.triangle
    if problem.variance == variance:
        return triangle
    if not len(problem.extra_rows):
        return frozen(triangle * np.sqrt(problem.variance / variance))
    rows = rows_at(problem, found)
    weighed = rows.rows * np.sqrt(rows.weight(variance))[:, None]
    return frozen(np.linalg.qr(weighed, mode="r"))


def over_all(problem: Problem, of_fitted: Array) -> Array:
    """(c, c) covariance of all springs of one of the fitted ones (f, f); zero for the others."""
    whole = np.zeros((len(problem.start), len(problem.start)))
    whole[np.ix_(problem.free, problem.free)] = of_fitted
    return whole
