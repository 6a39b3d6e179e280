"""The best continuous design over the whole design space, by column generation.

Weights on the points found so far (approximate.py) → gradient of the criterion → new points where
the sensitivity is largest (oracle.py) → again, until no point is more sensitive than the
equivalence theorem allows. Local ascent is worth more than a thousandfold of candidates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.approximate import Weights, few_points, optimal_weights
from elastocal.design.criterion import InformationFunction
from elastocal.design.dual_bound import DualBound, dual_bound
from elastocal.design.narrow_parts import narrow_parts
from elastocal.design.oracle import climb
from elastocal.design.space import DesignSpace, information
from elastocal.matrices import NEARLY_SINGULAR, rank_of, square_root

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
        singular: Whether it sees some combination of unknowns next to not at all, compared with
            random experiments.
    """

    x: Array
    weights: Array
    informations: Array
    total: Array
    certificate: DualBound
    gap: float
    singular: bool = False


_SPREAD = 20  # random points that make a design, to see which members of a criterion decide there
_ALIKE = 0.03  # relative distance of information matrices that are taken for one
_WEIGHTY = 0.01  # weight from which on a point counts in what the starts of a bound should find
_CANDIDATES = 2000  # random feasible points to begin with
_STARTS = 30  # ascents per round
_ROUNDS = 60  # most rounds; the gap is what it is after that
_ITERATIONS = (30, 50, 80, 150)  # of the ascents, round by round
_HOPELESS = 1e3  # gap beyond which the optimum is singular
_PATIENCE = 15  # rounds without a smaller gap after which to give up
_CLOSED = 5e-6  # relative gap between value and bound at which the search stops, ...
_CLOSED_MANY = 1e-4  # ... with many unknowns: half of it in ρ0, and a tenth of the time
MANY = 8
"""Unknowns beyond which they are many."""
_WEIGHED = 5e-7  # tolerance of the weights: a looser one would hide that an optimum is singular


def tolerance_of(parameters: int) -> float:
    """Relative gap between value and bound at which a search for that many unknowns stops."""
    return _CLOSED if parameters <= MANY else _CLOSED_MANY


def continuous_design(
    space: DesignSpace,
    criterion: InformationFunction,
    rng: np.random.Generator,
    *,
    certified: InformationFunction | None = None,
    base: Array | None = None,
    known: Array | None = None,
    tolerance: float | None = None,
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
        tolerance: Relative gap between value and bound at which to stop; that of so many unknowns
            if None.
        progress: Told the gap as it closes.
    """
    base = np.zeros((space.parameters,) * 2) if base is None else base
    tolerance = tolerance_of(space.parameters) if tolerance is None else tolerance
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
    seen, usual = [spread], spread.mean(axis=0)
    criterion, chosen = _weighed(
        criterion.near(spread), pool_informations, base, seen, tolerance=1e-2
    )
    here = _Measure(pool[chosen.support], chosen.weights, pool_informations[chosen.support])
    best = closest = here  # by value, by gap: neither need be the last
    highest = least = None
    smooth = criterion.smooth
    narrow = narrow_parts(space, rng.spawn(1)[0])
    bound: DualBound | None = None
    gaps: list[float] = []
    for count in range(_ROUNDS):
        total = here.total(base)
        if _is_singular(total, usual):
            best = closest = here
            break
        gradient = smooth.gradient(total[None])[0]
        level = float(np.sum((total - base) * gradient))
        order = np.argsort(-(flat_pool @ gradient.ravel()))
        begin = np.concatenate([here.x, pool[order[:_STARTS]]])
        stages = ((_ITERATIONS[min(count, 3)], len(begin)),)
        found, s, _ = climb(space, begin, gradient, stages)
        if s.max() <= level * (1.0 + tolerance):
            tell("trying the bound", gaps[-1] if gaps else np.inf)
            points, sums = taken_together(here.informations, here.weights)
            bound = dual_bound(
                space,
                smooth,
                total,
                base,
                found,
                rng,
                support=here.x[points[sums > _WEIGHTY]],
                narrow=narrow,
                level=level * (1.0 + tolerance),
            )
            if bound.largest <= level * (1.0 + tolerance):
                best = closest = here
                break
            found = np.concatenate([found, bound.x_found])
            s = np.concatenate([s, bound.s_found])
            gaps.clear()  # those before knew nothing of what was found now
        gap = float(s.max()) / level - 1.0
        gaps.append(gap)
        bound = None
        value = float(smooth.value(total[None])[0])
        if highest is None or value > highest:
            best, highest = here, value
        if least is None or gap < least:
            closest, least = here, gap
        if gap > _HOPELESS or min(gaps[:-_PATIENCE], default=np.inf) <= min(gaps[-_PATIENCE:]):
            break
        new = _distinct(space, found, s, level * (1.0 + 0.2 * tolerance), 2 * _STARTS, gradient)
        x = np.concatenate([here.x, new])
        informations = information(space.evaluate(x).blocks)
        wider, chosen = _weighed(
            criterion,
            informations,
            base,
            seen,
            start=np.arange(len(x)),
            tolerance=_WEIGHED,
        )
        if wider is not criterion:
            criterion, smooth = wider, wider.smooth
            highest = least = None
        here = _Measure(x[chosen.support], chosen.weights, informations[chosen.support]).thinned()
        tell("continuous design", gap)
    target = criterion if certified is None else certified.near(np.concatenate(seen))
    if bound is None or target is not smooth:
        if highest is None:
            best = closest = here
        bound = dual_bound(space, target, closest.total(base), base, closest.x, rng, narrow=narrow)
    total = best.total(base)
    value = float(target.value(total[None])[0])
    gap = bound.upper / value - 1.0 if value > 0.0 else np.inf
    return ContinuousDesign(*best, total, bound, gap, _is_singular(total, usual))


def _is_singular(total: Array, usual: Array) -> bool:
    """Whether information sees less than there are unknowns, on the scale of usual information."""
    return bool(rank_of(total, scale=usual, tolerance=NEARLY_SINGULAR) < len(total))


class _Measure(NamedTuple):
    """Points with weights, on the way."""

    x: Array  # (S, d)
    weights: Array  # (S,) sum 1
    informations: Array  # (S, p, p)

    def total(self, base: Array) -> Array:
        """(p, p) information per unit of weight."""
        return base + np.einsum("i,ijk->jk", self.weights, self.informations)

    def thinned(self) -> _Measure:
        """The same information from no more points than it takes."""
        few = few_points(self.informations, self.weights)
        return _Measure(self.x[few.support], few.weights, self.informations[few.support])


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
    size = np.linalg.norm(features, axis=1)
    kept: list[int] = []
    for i in range(len(order)):
        apart = np.linalg.norm(features[kept] - features[i], axis=1)
        if not (apart < 1e-3 * size[kept]).any():
            kept.append(i)
        if len(kept) == most:
            break
    return x[order[kept]]
