"""Uncertainty of a fit: noise and covariance.

In: how it was fitted, where it came to rest. Out: the noise of the readings, and the covariance of
what was fitted with the degrees of freedom behind it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.errors import Doubt, IdentifiabilityError
from elastocal.fitting.few_readings import FEW, median_variance, spread_of_few
from elastocal.fitting.mixed import Rows, Spread, noise_variance, spread_found, spread_known
from elastocal.fitting.robust import EFFICIENCY, inflation, robust_scale
from elastocal.identification.fit import Fit
from elastocal.identification.problem import Problem, Solution, free_rows
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
    if problem.shared is not None or (how.estimates_sigma and len(problem.extra_rows)):
        rows = rows_at(problem, found)
        shown = _variance(rows, problem.variance)
        scale = float(np.sqrt(shown)) if shown > 0.0 else float("nan")
    if not how.estimates_sigma:
        return scale, 1.0
    if not np.isfinite(scale) or dof < 1:
        numbers = {"readings": len(found.residual)}
        if dof > 0 and problem.absolute:
            numbers["among_errors"] = 1
        doubt = Doubt("no-freedom", numbers=numbers)
        raise IdentifiabilityError(worded(doubt)).with_doubts(doubt)
    return scale, scale**2


def pure_dof_of(how: Fit, problem: Problem, found: Solution) -> int:
    """Degrees of freedom that show the noise alone, where it is to be found in the readings."""
    if how.estimates_sigma and problem.absolute:
        return rows_at(problem, found).pure_dof
    return problem.dof


def _variance(rows: Rows, start: float) -> float:
    """s² as far as the readings show it; 0 if they do not.

    Where no coordinate shows the noise alone, it is what they scatter more than is known in
    absolute size: told if that is enough of it. In simulated campaigns 95 % intervals then held
    the truth in 94.5 to 98 %, with errors of a hundredth to ten times the noise's variance.
    """
    pure = rows.pure_dof
    if 0 < pure < FEW:
        return median_variance(rows)
    variance = noise_variance(rows, start)
    told = pure > 0 or (variance > 0.0 and spread_found(rows, variance).dof >= FEW)
    return variance if told else 0.0


def over_noise(problem: Problem, found: Solution, variance: float) -> tuple[Array, Array]:
    """(3R, u) rows and (3R,) residuals of unit noise, errors of absolute size counted in."""
    root = np.sqrt(found.weight)[:, None]
    rows = (free_rows(problem, found) * root[..., None]).reshape(-1, problem.unknowns)
    residual = (found.residual * root).ravel()
    scale = np.full(len(residual), variance)
    if problem.shared is not None:
        rows = problem.shared.turned(rows)
        residual = problem.shared.turned(residual[:, None])[:, 0]
        scale = scale + problem.shared.absolute
    over = 1.0 / np.sqrt(scale)
    return rows * over[:, None], residual * over


def prior_misfit(problem: Problem, found: Solution) -> float:
    """Squares of what the estimate is off what was known before, over its doubt."""
    off = problem.extra_values[0] - problem.extra_rows @ found.compliance
    return float(np.sum(off**2))


def squares(problem: Problem, found: Solution) -> float:
    """Squared residuals over what was promised, those of what was known before included."""
    if problem.shared is None:
        return float(np.sum(found.residual**2)) + prior_misfit(problem, found)
    _, residual = over_noise(problem, replace(found, weight=np.ones_like(found.weight)), 1.0)
    return float(np.sum(residual**2)) + prior_misfit(problem, found)


def rows_at(problem: Problem, found: Solution) -> Rows:
    """The whole fit as rows, linearised where it came to rest."""
    root = np.sqrt(found.weight)[:, None]
    rows = (free_rows(problem, found) * root[..., None]).reshape(-1, problem.unknowns)
    values = (found.residual * root).ravel() + rows @ found.compliance
    absolute, extra = np.zeros(len(rows)), len(problem.extra_rows)
    if problem.shared is not None:
        absolute = problem.shared.absolute
        rows = problem.shared.turned(rows)
        values = problem.shared.turned(values[:, None])[:, 0]
    return Rows(
        rows=np.concatenate([rows, problem.extra_rows]),
        values=np.append(values, problem.extra_values[0]),
        own=np.append(np.ones(len(rows)), np.zeros(extra)),
        absolute=np.append(absolute, np.ones(extra)),
    )


def spread_of(how: Fit, problem: Problem, found: Solution, variance: float) -> Spread:
    """Covariance of what was fitted, the bounds left out: what is held is as uncertain as ever."""
    dof = float(problem.dof) if how.estimates_sigma else np.inf
    if not problem.absolute:
        covariance = frozen(variance * found.fit.covariance)
        return Spread(covariance, covariance, dof, variance)
    rows = rows_at(problem, found)
    if not how.estimates_sigma:
        return spread_known(rows, variance)
    if how.robust:
        return replace(spread_found(rows, variance), dof=dof)
    return spread_of_few(rows) if 0 < rows.pure_dof < FEW else spread_found(rows, variance)


def triangle_of(problem: Problem, found: Solution, variance: float) -> Array:
    """(f, f) upper triangular R with RᵀR the information, the variances of readings multiplied."""
    triangle = found.fit.triangle
    if problem.variance == variance:
        return triangle
    if not problem.absolute:
        return frozen(triangle * np.sqrt(problem.variance / variance))
    rows = rows_at(problem, found)
    weighed = rows.rows * np.sqrt(rows.weight(variance))[:, None]
    return frozen(np.linalg.qr(weighed, mode="r"))


def over_all(problem: Problem, of_unknowns: Array) -> Array:
    """(c, c) covariance of all springs of one of the unknowns (u, u); zero for what is exact."""
    if problem.make.size:
        made = problem.make.shape[1]
        return np.asarray(problem.make @ of_unknowns[:made, :made] @ problem.make.T)
    whole = np.zeros((len(problem.start), len(problem.start)))
    whole[np.ix_(problem.free, problem.free)] = of_unknowns
    return whole
