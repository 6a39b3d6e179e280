"""Uncertainty of a fit: noise and covariance.

In: how it was fitted, where it came to rest. Out: covariance of all springs and its freedom.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import Doubt, IdentifiabilityError
from elastocal.fitting.least_squares import inverse_root
from elastocal.fitting.robust import EFFICIENCY, inflation, robust_scale
from elastocal.identification.fit import Fit
from elastocal.identification.gauss_newton import Problem, Solution
from elastocal.wording import worded


def noise(how: Fit, found: Solution, chi_square: float, dof: int) -> tuple[float, float, float]:
    """Noise over the promised one, variance factor of the estimate, degrees of freedom."""
    scale = float(np.sqrt(chi_square / dof)) if dof > 0 else float("nan")
    if how.robust:
        size = np.linalg.norm(found.residual, axis=1)
        scale = robust_scale(size, dof)
        used = scale if how.estimates_sigma else 1.0
        variance = inflation(how.weigher, size, used, max(dof, 1))
        if not how.estimates_sigma:  # no robust fit beats least squares by luck
            variance = max(variance, 1.0 / EFFICIENCY)
        return scale, variance, float(dof) if how.estimates_sigma else np.inf
    if not how.estimates_sigma:
        return scale, 1.0, np.inf
    if dof < 1:
        doubt = Doubt("no-freedom", numbers={"readings": len(found.residual)})
        raise IdentifiabilityError(worded(doubt)).with_doubts(doubt)
    return scale, scale**2, float(dof)


def covariance_of(problem: Problem, found: Solution, variance: float, known: int) -> Array:
    """Covariance of all springs; zero for those that are held.

    The last `known` of the further rows say what another campaign found. Their noise is what that
    campaign says, whatever the `variance` of this one is.
    """
    count, free = len(problem.start), problem.free
    held = found.fit.held
    moving = free[~held]
    triangle = found.fit.triangle
    # R of the springs that are not held: those held at zero are taken as exact.
    kept: Array = np.asarray(np.linalg.qr(triangle[:, ~held], mode="r"))
    inverse = inverse_root(kept)
    covariance = np.zeros((count, count))
    covariance[np.ix_(moving, moving)] = variance * inverse @ inverse.T
    rows = problem.extra_rows[len(problem.extra_rows) - known :, ~held]
    moved = inverse @ (inverse.T @ rows.T)
    covariance[np.ix_(moving, moving)] += (1.0 - variance) * moved @ moved.T
    return covariance
