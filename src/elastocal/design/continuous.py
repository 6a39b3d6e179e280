"""The best continuous design over the whole design space, by column generation.

Weights on the points found so far (approximate.py) → gradient of the criterion → new points where
the sensitivity is largest (oracle.py) → again, until no point is more sensitive than the
equivalence theorem allows. Local ascent is worth more than a thousandfold of candidates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.approximate import Weights, optimal_weights
from elastocal.design.criterion import InformationFunction
from elastocal.design.dual_bound import DualBound, dual_bound
from elastocal.design.narrow_parts import narrow_parts
from elastocal.design.oracle import climb, square_root
from elastocal.design.space import DesignSpace, information
from elastocal.matrices import NEARLY_SINGULAR, rank_of

Progress = Callable[[str, float], None]
"""(what is going on, current value) -> None."""


@dataclass(frozen=True)
class ContinuousDesign:
    """A design measure.

    Attributes:
        x: (S, d) support points.
        weights: (S,) weights, sum 1.
        informations: (S, p, p) information matrix of each support point.
        total: (p, p) information per unit of weight, base included.
        certificate: What it proves for every other design.
        gap: Bound over value, less 1. Large where the optimum is singular, so that the search
            gives up: use `power_mean.floored` then.
    """

    x: Array
    weights: Array
    informations: Array
    total: Array
    certificate: DualBound
    gap: float


TOLERANCE = 5e-6
"""Relative gap between value and bound at which the search stops."""
_SPREAD = 20  # random points that make a design, to see which members of a criterion decide there
_ALIKE = 0.03  # relative distance of information matrices that are taken for one
_WEIGHTY = 0.01  # weight from which on a point counts in what the starts of a bound should find
_CANDIDATES = 2000  # random feasible points to begin with
_STARTS = 30  # ascents per round
_ROUNDS = 60  # most rounds; the gap is what it is after that
_ITERATIONS = (30, 50, 80, 150)  # of the ascents, round by round
_HOPELESS = 1e3  # gap beyond which the optimum is singular
_PATIENCE = 15  # rounds without a smaller gap after which to give up


def continuous_design(
    space: DesignSpace,
    criterion: InformationFunction,
    rng: np.random.Generator,
    *,
    certified: InformationFunction | None = None,
    base: Array | None = None,
    known: Array | None = None,
    progress: Progress | None = None,
) -> ContinuousDesign:
    """Best continuous design and an upper bound for every design of unit weight.

    Args:
        space: Where experiments can be chosen from.
        criterion: What to maximise.
        rng: Source of the candidates and of the fresh starts.
        certified: Criterion to bound, if not `criterion` itself.
        base: (p, p) information there is anyway, per unit of weight.
        known: (K, d) feasible points worth having among the candidates.
        progress: Told the gap as it closes.
    """
    base = np.zeros((space.parameters,) * 2) if base is None else base
    tell = progress or (lambda what, gap: None)
    tell("feasible load cases", np.inf)
    pool = space.sample(_CANDIDATES, rng)
    if known is not None:
        pool = np.concatenate([known, pool])
    pool_informations = information(space.evaluate(pool).blocks)
    flat_pool = pool_informations.reshape(len(pool), -1)
    # Of very many members those that decide at some design or other, and later where it leads.
    size = min(_SPREAD, len(pool))
    spread = base + pool_informations[: len(pool) // size * size].reshape(
        -1, size, *base.shape
    ).mean(axis=1)
    seen = [spread]
    criterion, chosen = _weighed(
        criterion.near(spread), pool_informations, base, seen, tolerance=1e-2
    )
    x, weights = pool[chosen.support], chosen.weights
    informations = pool_informations[chosen.support]
    smooth = criterion.smooth
    narrow = narrow_parts(space, rng.spawn(1)[0])
    bound: DualBound | None = None
    gaps: list[float] = []
    for count in range(_ROUNDS):
        total = base + np.einsum("i,ijk->jk", weights, informations)
        if rank_of(total, tolerance=NEARLY_SINGULAR) < space.parameters:
            break
        gradient = smooth.gradient(total[None])[0]
        level = float(np.einsum("i,ijk,jk->", weights, informations, gradient))
        order = np.argsort(-(flat_pool @ gradient.ravel()))
        begin = np.concatenate([x, pool[order[:_STARTS]]])
        stages = ((_ITERATIONS[min(count, 3)], len(begin)),)
        found, s, _ = climb(space, begin, gradient, stages)
        if s.max() <= level * (1.0 + TOLERANCE):
            tell("trying the bound", gaps[-1] if gaps else np.inf)
            points, sums = taken_together(informations, weights)
            bound = dual_bound(
                space,
                smooth,
                total,
                base,
                found,
                rng,
                support=x[points[sums > _WEIGHTY]],
                narrow=narrow,
                level=level * (1.0 + TOLERANCE),
            )
            if bound.largest <= level * (1.0 + TOLERANCE):
                break
            found = np.concatenate([found, bound.x_found])
            s = np.concatenate([s, bound.s_found])
        gap = float(s.max()) / level - 1.0
        gaps.append(gap)
        bound = None
        if gap > _HOPELESS or min(gaps[:-_PATIENCE], default=np.inf) <= min(gaps[-_PATIENCE:]):
            break
        new = _distinct(space, found, s, level * (1.0 + 0.2 * TOLERANCE), 2 * _STARTS, gradient)
        x = np.concatenate([x, new])
        informations = information(space.evaluate(x).blocks)
        every = np.arange(len(x))
        wider, chosen = _weighed(
            criterion, informations, base, seen, start=every, tolerance=0.1 * TOLERANCE
        )
        if wider is not criterion:
            criterion, smooth = wider, wider.smooth
        x, weights = x[chosen.support], chosen.weights
        informations = informations[chosen.support]
        tell("continuous design", gap)
    target = criterion if certified is None else certified.near(np.concatenate(seen))
    total = base + np.einsum("i,ijk->jk", weights, informations)
    if bound is None or target is not smooth:
        bound = dual_bound(space, target, total, base, x, rng, narrow=narrow)
    value = float(target.value(total[None])[0])
    gap = bound.upper / value - 1.0 if value > 0.0 else np.inf
    return ContinuousDesign(x, weights, informations, total, bound, gap)


def taken_together(informations: Array, weights: Array) -> tuple[IntArray, Array]:
    """Points of nearly the same information as one: which points (K,), and their weights (K,).

    The heaviest first, without those of next to no weight.

    Args:
        informations: (S, p, p) information matrices of the points.
        weights: (S,) their weights.
    """
    flat = informations.reshape(len(weights), -1)
    kept: list[int] = []
    sums: list[float] = []
    for i in np.argsort(-weights, kind="stable"):
        distance = np.linalg.norm(flat[kept] - flat[i], axis=1) / np.linalg.norm(flat[i])
        near = np.flatnonzero(distance < _ALIKE)
        if len(near):
            sums[near[0]] += float(weights[i])
        else:
            kept.append(int(i))
            sums.append(float(weights[i]))
    order = [i for i in np.argsort(sums)[::-1] if sums[i] > 1e-3 * max(sums)]
    return np.array(kept)[order], np.array(sums)[order]


def _weighed(
    criterion: InformationFunction,
    informations: Array,
    base: Array,
    seen: list[Array],
    *,
    start: IntArray | None = None,
    tolerance: float,
) -> tuple[InformationFunction, Weights]:
    """Best weights, and the criterion with every member that decides there.

    The information matrices it was asked about are added to `seen`.
    """
    while True:
        chosen = optimal_weights(criterion, informations, base, start=start, tolerance=tolerance)
        total = base + np.einsum("i,ijk->jk", chosen.weights, informations[chosen.support])
        seen.append(total[None])
        wider = criterion.near(total[None])
        if wider is criterion:
            return criterion, chosen
        criterion = wider


def _distinct(
    space: DesignSpace, x: Array, s: Array, level: float, most: int, gradient: Array
) -> Array:
    """The best points above `level`, without those of nearly the same information."""
    order = np.argsort(-s)
    order = order[s[order] > level]
    if not len(order):
        return x[:0]
    order = order[: 4 * most]
    root = square_root(gradient)
    features = information(space.evaluate(x[order]).blocks) @ root
    features = features.reshape(len(order), -1)
    kept: list[int] = []
    for i in range(len(order)):
        near = [
            j
            for j in kept
            if np.linalg.norm(features[i] - features[j]) < 1e-3 * np.linalg.norm(features[j])
        ]
        if not near:
            kept.append(i)
        if len(kept) == most:
            break
    return x[order[kept]]
