"""Continuous designs: the best weights on a finite set of design points.

Primal-dual interior point for max log φ(B + Σ w_i M_i) over the simplex, with the Hessian from
differences of the analytic gradient, so that every smooth criterion is served by one code. An
active set grows by the points that violate optimality most and loses those of no weight.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.criterion import InformationFunction


class Weights(NamedTuple):
    """A continuous design on a finite set."""

    support: IntArray  # indices of the points with weight
    weights: Array  # their weights, sum 1


def optimal_weights(
    criterion: InformationFunction,
    informations: Array,
    base: Array,
    *,
    start: IntArray | None = None,
    tolerance: float = 1e-6,
) -> Weights:
    """Best design on the points with `informations`, (N, p, p).

    Args:
        criterion: What to maximise; its smooth stand-in is used.
        informations: Information matrix of every point.
        base: (p, p) information there is anyway, per unit of weight.
        start: Points to begin with; a spread of all points if None.
        tolerance: Largest relative violation of the equivalence theorem on the N points.
    """
    smooth = criterion.smooth
    count, p = informations.shape[:2]
    active = np.unique(
        np.linspace(0, count - 1, min(count, 8 * p)).astype(int) if start is None else start
    )
    flat = informations.reshape(count, -1)
    for _ in range(_SWEEPS):
        weights = interior_point(smooth, informations[active], base, tolerance)
        keep = weights > 1e-7
        active, weights = active[keep], weights[keep] / weights[keep].sum()
        total = base + np.einsum("i,ijk->jk", weights, informations[active])
        gradient = smooth.gradient(total[None])[0]
        sensitivity = flat @ gradient.ravel()
        level = weights @ sensitivity[active]
        worst = np.argsort(-sensitivity)[: 2 * p]
        worst = worst[sensitivity[worst] > level * (1.0 + tolerance)]
        worst = np.setdiff1d(worst, active)
        if not len(worst):
            break
        active = np.concatenate([active, worst])
        weights = np.append(weights, np.zeros(len(worst)))
    return Weights(active, weights)


_SWEEPS = 60


def interior_point(
    criterion: InformationFunction, informations: Array, base: Array, tolerance: float
) -> Array:
    """Best weights on a few points, (n,), by a primal-dual interior-point method.

    Minimises f(w) = −log φ(B + Σ w_i M_i) with Σ w = 1, w ≥ 0; at the optimum
    −∂f/∂w_i = s_i/φ ≤ −multiplier, with equality on the support. Where the points identify too
    little for φ, there is no direction to go in: the weights are returned as they are, equal.
    """
    count = len(informations)
    weights = np.full(count, 1.0 / count)
    slack = np.full(count, 1.0)
    for _ in range(60):
        slope, curvature = _derivatives(criterion, informations, base, weights)
        multiplier = -float(weights @ (slope - slack))
        gap = float(weights @ slack)
        residual = slope - slack + multiplier
        if gap < 0.1 * tolerance and np.abs(residual).max() < tolerance:
            break
        target = 0.1 * gap / count
        matrix = np.zeros((count + 1, count + 1))
        matrix[:count, :count] = curvature + np.diag(slack / weights + 1e-12)
        matrix[:count, count] = matrix[count, :count] = 1.0
        right = np.append(-residual - slack + target / weights, 1.0 - weights.sum())
        try:
            solution = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            break
        if not np.isfinite(solution).all():
            break
        step = solution[:count]
        slack_step = (target - slack * step) / weights - slack
        length = _fraction(weights, step)
        length *= _descent(criterion, informations, base, weights, length * step, target)
        weights = weights + length * step
        slack = slack + _fraction(slack, slack_step) * slack_step
    return weights / weights.sum()


def _derivatives(
    criterion: InformationFunction, informations: Array, base: Array, weights: Array
) -> tuple[Array, Array]:
    """Gradient (n,) and Hessian (n, n) of −log φ in the weights; not finite where φ is 0."""
    count = len(weights)
    total = base + np.einsum("i,ijk->jk", weights, informations)
    reach = 1e-5 * np.trace(total) / np.trace(informations, axis1=1, axis2=2)
    nearby = np.concatenate(
        [
            total[None],
            total + reach[:, None, None] * informations,
            total - reach[:, None, None] * informations,
        ]
    )
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        gradients = criterion.gradient(nearby) / criterion.value(nearby)[:, None, None]
        slopes = -gradients.reshape(2 * count + 1, -1) @ informations.reshape(count, -1).T
        curvature = (slopes[1 : count + 1] - slopes[count + 1 :]) / (2.0 * reach[:, None])
    return slopes[0], (curvature + curvature.T) / 2.0


def _descent(
    criterion: InformationFunction,
    informations: Array,
    base: Array,
    weights: Array,
    step: Array,
    target: float,
) -> float:
    """Share of `step` that lowers the barrier function; matters for nearly kinked criteria."""
    shares = 0.5 ** np.arange(12.0)
    trials = np.vstack([weights, weights + shares[:, None] * step])
    totals = base + np.einsum("ti,ijk->tjk", trials, informations)
    with np.errstate(divide="ignore"):
        barrier = -np.log(criterion.value(totals)) - target * np.log(trials).sum(axis=1)
    lower = np.flatnonzero(barrier[1:] <= barrier[0] + 1e-9 * abs(barrier[0]))
    return float(shares[lower[0]]) if len(lower) else float(shares[-1])


def _fraction(values: Array, step: Array) -> float:
    """Largest step length that keeps `values` positive, with a little room."""
    falling = step < 0.0
    if not falling.any():
        return 1.0
    return min(1.0, 0.995 * float(np.min(-values[falling] / step[falling])))
