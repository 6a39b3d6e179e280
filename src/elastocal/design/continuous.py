"""The best continuous design over the whole design space, by column generation.

Weights on the points found so far (approximate.py) → gradient of the criterion → new points where
the sensitivity is largest (oracle.py) → again, until no point is more sensitive than the
equivalence theorem allows. Local ascent is worth more than a thousandfold of candidates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.design.approximate import optimal_weights
from elastocal.design.criterion import InformationFunction
from elastocal.design.oracle import climb, square_root
from elastocal.design.space import DesignSpace, information

Progress = Callable[[str, float], None]
"""(what is going on, current value) -> None."""


@dataclass(frozen=True)
class ContinuousDesign:
    """A design measure and what it proves.

    Attributes:
        x: (S, d) support points.
        weights: (S,) weights, sum 1.
        informations: (S, p, p) information matrix of each support point.
        total: (p, p) information per unit of weight, base included.
        gradient: (p, p) gradient G of the criterion at `total`.
        value: φ(total).
        largest: Largest sensitivity found anywhere, s(x*).
        x_largest: (d,) where it was found.
        upper: tr(G base) + largest: no design of unit weight has a larger φ.
        starts: Fresh random starts that did not find a larger sensitivity.
        attained: How many of them reached `largest` within 1e-4.
    """

    x: Array
    weights: Array
    informations: Array
    total: Array
    gradient: Array
    value: float
    largest: float
    x_largest: Array
    upper: float
    starts: int
    attained: int


def continuous_design(
    space: DesignSpace,
    criterion: InformationFunction,
    rng: np.random.Generator,
    *,
    base: Array | None = None,
    candidates: int = 2000,
    starts: int = 30,
    fresh: int = 300,
    tolerance: float = 5e-6,
    rounds: int = 60,
    progress: Progress | None = None,
) -> ContinuousDesign:
    """Best continuous design and an upper bound for every design of unit weight.

    Args:
        space: Where experiments can be chosen from.
        criterion: What to maximise.
        rng: Source of the candidates and of the fresh starts.
        base: (p, p) information there is anyway, per unit of weight.
        candidates: Random feasible points to begin with.
        starts: Ascents per round.
        fresh: Random starts that must fail to refute the bound before it is issued: bounds
            confirmed by the working starts alone are often false.
        tolerance: Relative gap between value and bound at which to stop.
        rounds: Most rounds; the gap is what it is after that.
        progress: Told the bound as it falls.
    """
    base = np.zeros((space.parameters,) * 2) if base is None else base
    pool = space.sample(candidates, rng)
    pool_informations = information(space.evaluate(pool).blocks)
    chosen = optimal_weights(criterion, pool_informations, base, tolerance=1e-2)
    x, weights = pool[chosen.support], chosen.weights
    informations = pool_informations[chosen.support]
    flat_pool = pool_informations.reshape(len(pool), -1)
    confirmed = attained = 0
    for count in range(rounds):
        total = base + np.einsum("i,ijk->jk", weights, informations)
        gradient = criterion.smooth.gradient(total[None])[0]
        level = float(np.einsum("i,ijk,jk->", weights, informations, gradient))
        order = np.argsort(-(flat_pool @ gradient.ravel()))
        begin = np.concatenate([x, pool[order[:starts]]])
        found, s = climb(space, begin, gradient, iterations=_ITERATIONS[min(count, 3)])
        if s.max() <= level * (1.0 + tolerance):
            begin = space.sample(fresh, rng)
            found, s = climb(space, begin, gradient, iterations=_ITERATIONS[-1])
            if s.max() <= level * (1.0 + tolerance):
                confirmed, attained = fresh, int((s > level * (1.0 - 1e-4)).sum())
                break
        new = _distinct(space, found, s, level * (1.0 + 0.2 * tolerance), 2 * starts, gradient)
        x = np.concatenate([x, new])
        informations = information(space.evaluate(x).blocks)
        chosen = optimal_weights(
            criterion, informations, base, start=np.arange(len(x)), tolerance=0.1 * tolerance
        )
        x, weights = x[chosen.support], chosen.weights
        informations = informations[chosen.support]
        if progress is not None:
            progress("continuous design", s.max() / level - 1.0)
    return _finish(space, criterion, base, x, weights, informations, (found, s), confirmed, attained)


_ITERATIONS = (30, 50, 80, 150)


def _finish(
    space: DesignSpace,
    criterion: InformationFunction,
    base: Array,
    x: Array,
    weights: Array,
    informations: Array,
    found: tuple[Array, Array],
    confirmed: int,
    attained: int,
) -> ContinuousDesign:
    """Bound from the sound gradient of the criterion itself, maximum climbed once more."""
    total = base + np.einsum("i,ijk->jk", weights, informations)
    gradient = criterion.gradient(total[None])[0]
    begin = np.concatenate([x, found[0][np.argsort(-found[1])[:20]]])
    points, s = climb(space, begin, gradient, iterations=_ITERATIONS[-1])
    best = int(np.argmax(s))
    return ContinuousDesign(
        x=x,
        weights=weights,
        informations=informations,
        total=total,
        gradient=gradient,
        value=float(criterion.value(total[None])[0]),
        largest=float(s[best]),
        x_largest=points[best],
        upper=float(np.sum(gradient * base)) + float(s[best]),
        starts=confirmed,
        attained=attained,
    )


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
            j for j in kept
            if np.linalg.norm(features[i] - features[j]) < 1e-3 * np.linalg.norm(features[j])
        ]
        if not near:
            kept.append(i)
        if len(kept) == most:
            break
    return x[order[kept]]


