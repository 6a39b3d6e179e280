"""Continuous designs: the best weights on a finite set of design points.

Primal-dual interior point for max log φ(B + Σ w_i M_i) over the simplex. An active set grows by
the points that violate optimality most, and loses those of no weight; a point that was lost and
is taken back stays, so that nothing goes round in circles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.design.criterion import InformationFunction


class Weights(NamedTuple):
    """A continuous design on a finite set."""

    support: IntArray  # indices of the points with weight
    weights: Array  # their weights, sum 1


_SWEEPS = 60
_STEPS = 20  # of weights that are good enough to be rounded
_LIGHT = 0.1  # weight that may be lost in all, as a share of the tolerance


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
        tolerance: Largest relative violation of the equivalence theorem on the N points; where
            that cannot be had, the design that violates it least is returned.
    """
    smooth = criterion.smooth
    count, p = informations.shape[:2]
    active = np.unique(
        np.linspace(0, count - 1, min(count, 8 * p)).astype(int) if start is None else start
    )
    flat = informations.reshape(count, -1)
    stays = np.zeros(count, dtype=bool)
    least, best = np.inf, Weights(active, np.full(len(active), 1.0 / len(active)))
    for _ in range(_SWEEPS):
        weights = interior_point(smooth, informations[active], base, tolerance)
        heavy = _heavy(weights, _LIGHT * tolerance)
        found = Weights(active[heavy], weights[heavy] / weights[heavy].sum())
        total = base + _sum(found.weights, informations[found.support])
        sensitivity = flat @ smooth.gradient(total[None])[0].ravel()
        level = found.weights @ sensitivity[found.support]
        excess = float(sensitivity.max() / level) - 1.0
        if excess < least:
            least, best = excess, found
        worst = np.argsort(-sensitivity)[: 2 * p]
        worst = np.setdiff1d(worst[sensitivity[worst] > level * (1.0 + tolerance)], active)
        if not len(worst):
            break
        active = np.concatenate([active[heavy | stays[active]], worst])
        stays[worst] = True
    return best


def _heavy(weights: Array, light: float) -> BoolArray:
    """Which of (n,) weights to keep, so that the others are no more than `light` together."""
    order = np.argsort(weights)
    keep = np.ones(len(weights), dtype=bool)
    keep[order[np.cumsum(weights[order]) <= light]] = False
    return keep


def few_points(informations: Array, weights: Array) -> Weights:
    """The same information from no more than p(p + 1)/2 + 1 points.

    Args:
        informations: (S, p, p) information matrices.
        weights: (S,) their weights, sum 1.

    Source: Carathéodory; along a null vector of the columns (M_i, 1) until a weight is zero.
    """
    upper = np.triu_indices(informations.shape[1])
    columns = np.column_stack([informations[:, *upper], np.ones(len(weights))])
    if len(columns) <= columns.shape[1]:
        support = np.flatnonzero(weights > 0.0)
        return Weights(support, weights[support] / weights[support].sum())
    columns = columns / np.maximum(np.abs(columns).max(axis=0), np.finfo(float).tiny)
    weights = weights.copy()
    null = np.linalg.svd(columns.T)[2][min(columns.shape) :]
    while len(null):
        falling = np.flatnonzero(null[0] > 0.0)
        first = falling[np.argmin(weights[falling] / null[0, falling])]
        weights -= weights[first] / null[0, first] * null[0]
        weights[first] = 0.0
        # A reflection after which only one of the null vectors involves that point; it goes.
        mirror = null[:, first].copy()
        mirror[0] += np.copysign(np.linalg.norm(mirror), mirror[0])
        null -= np.outer(2.0 * mirror / (mirror @ mirror), mirror @ null)
        null = null[1:]
        null[:, first] = 0.0
    weights = np.maximum(weights, 0.0)
    support = np.flatnonzero(weights)
    return Weights(support, weights[support] / weights.sum())


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
        slope, curvature = criterion.bends(base + _sum(weights, informations), informations)
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
    totals = base + _sum(trials, informations)
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


def nearly_best(
    criterion: InformationFunction, informations: Array, parts: IntArray, base: Array
) -> Array:
    """Good weights for many small sets of points at once, (B, n); good enough to be rounded.

    Args:
        criterion: What to maximise; its smooth stand-in is used.
        informations: (N, p, p) information matrices.
        parts: (B, n) which of them make a set.
        base: (p, p) information there is anyway, per unit of weight.

    Source: multiplicative algorithm, w_i ← w_i √s_i over their sum; Silvey, Titterington, Torsney
    (1978). Where the points identify too little, the weights stay equal.
    """
    smooth, weights = criterion.smooth, np.full(parts.shape, 1.0 / parts.shape[1])
    each = informations.reshape(len(informations), -1)[parts]
    for _ in range(_STEPS):
        totals = base + np.einsum("bn,bnk->bk", weights, each).reshape(-1, *base.shape)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            gradients = smooth.gradient(totals).reshape(len(parts), -1)
            sensitivities = np.einsum("bk,bnk->bn", gradients, each)
            better = weights * np.sqrt(np.maximum(sensitivities, 0.0))
            better = better / better.sum(axis=1, keepdims=True)
        weights = np.where(np.isfinite(better).all(axis=1, keepdims=True), better, weights)
    return weights


def _sum(weights: Array, informations: Array) -> Array:
    """Σ w_i M_i for weights (…, n)."""
    flat = informations.reshape(len(informations), -1)
    return (weights @ flat).reshape(*weights.shape[:-1], *informations.shape[1:])
