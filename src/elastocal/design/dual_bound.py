"""The bound of concave duality: how far any design can be from the best of all designs.

For an information function φ and G = ∇φ(M) at any M whatever, concavity and homogeneity give

    φ(B + Σ_i M_i) ≤ tr(G B) + m max_x tr(G M_x)     for every design of m experiments.

So M need not be optimal, rounding errors in it cost tightness and never validity, and the only
thing to be believed is the maximum. It is searched from many fresh random starts: the certificate
is numerical, and says how many starts stand behind it.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.design.criterion import InformationFunction
from elastocal.design.lockstep import Stages
from elastocal.design.oracle import climb, restore
from elastocal.design.space import DesignSpace, information


@dataclass(frozen=True)
class DualBound:
    """An upper bound on a criterion, for every design.

    Attributes:
        gradient: (p, p) the G of the bound.
        offset: tr(G B), what is there anyway, per unit of weight.
        largest: Largest sensitivity found, max_x tr(G M_x).
        x_largest: (d,) where it was found.
        starts: Distinct fresh random starts of the search.
        attained: How many of them reached `largest` within 1e-4.
        narrow_starts: Further starts, in narrow parts of the feasible set.
        narrow_attained: How many of them reached `largest` within 1e-4.
        rarest: How many of all these reached that point of the support which fewest reached, of
            all if there is no support. A maximum as hard to find is missed with a chance of
            e^-rarest.
        x_found: (K, d) the local maxima found.
        s_found: (K,) their sensitivities.
    """

    gradient: Array
    offset: float
    largest: float
    x_largest: Array
    starts: int
    attained: int
    narrow_starts: int
    narrow_attained: int
    rarest: int
    x_found: Array
    s_found: Array

    @property
    def upper(self) -> float:
        """No design of unit weight has a larger φ."""
        return self.offset + self.largest


ROUNDING = 1e-9
"""What climbs to the same summit differ by, relative."""

# Bounds confirmed by the starts of the search alone are often false.
_FRESH = 600  # fresh random starts that must fail to refute the bound; more are made if too few ...
_ENOUGH = 12  # ... reach the highest summit,
_EACH = 6  # or that point of the support which fewest reach,
_MOST = 8  # up to so many times as many
_NEAR = 30  # highest summits whose neighbourhood is searched again ...
_STIR = 0.03  # ... from points this share of the ranges away
_AT_TOP = 1e-4  # below the highest summit, where a climb has reached it
_NONE = sys.maxsize


def dual_bound(
    space: DesignSpace,
    criterion: InformationFunction,
    total: Array,
    base: Array,
    known: Array,
    rng: np.random.Generator,
    *,
    support: Array | None = None,
    narrow: Array | None = None,
    level: float = np.inf,
    fresh: int = _FRESH,
) -> DualBound:
    """Bound from the gradient of `criterion` at `total`.

    Args:
        space: Where experiments can be chosen from.
        criterion: What is bounded.
        total: (p, p) information matrix at which the gradient is taken.
        base: (p, p) information there is anyway, per unit of weight.
        known: (K, d) points worth starting from.
        rng: Source of the fresh starts.
        support: (S, d) points of a design, each of which fresh starts should find, too.
        narrow: (K, d) points in narrow parts of the feasible set.
        level: Sensitivity above which the bound is refuted, so that the search may end.
        fresh: Number of fresh random starts; more are made if few of them reach the maximum.
    """
    gradient = criterion.gradient(total[None])[0]
    offset = float(np.sum(gradient * base))
    return dual_bound_of(
        space,
        gradient,
        offset,
        known,
        rng,
        support=support,
        narrow=narrow,
        level=level,
        fresh=fresh,
    )


def dual_bound_of(
    space: DesignSpace,
    gradient: Array,
    offset: float,
    known: Array,
    rng: np.random.Generator,
    *,
    support: Array | None = None,
    narrow: Array | None = None,
    level: float = np.inf,
    fresh: int = _FRESH,
) -> DualBound:
    """The same from a gradient (p, p) and what it says of the information there is anyway."""
    summits = _Summits(space, gradient)
    batch = fresh
    while True:
        drawn = summits.climb_afresh(batch, rng, known)
        known = known[:0]
        # A summit that few starts reach may not be the highest: look on.
        enough = np.sum(summits.at_top & summits.fresh) >= _ENOUGH or summits.s.max() > level
        if enough or summits.starts >= _MOST * fresh or drawn < batch:
            break
        batch = summits.starts
    # A higher summit may stand beside the highest one found, cut off by a constraint.
    near = summits.x[np.argsort(-summits.s)[:_NEAR]]
    near = near + _STIR * (space.upper - space.lower) * rng.normal(size=near.shape)
    summits.climb(restore(space, near), ((150, len(near)),))
    first = len(summits.s)
    # What follows has random numbers of its own: where it finds nothing, nothing else changes.
    stream = rng.spawn(1)[0]
    narrow = known if narrow is None or summits.s.max() > level else narrow
    summits.climb(narrow, ((100, len(narrow)), (150, _NEAR)), narrow=0)
    while True:
        rarest = summits.rarest(support)
        refuted = summits.s.max() > level
        if refuted or rarest >= _EACH or summits.starts >= _MOST * fresh or drawn < batch:
            break
        batch = min(summits.starts, _MOST * fresh - summits.starts)
        drawn = summits.climb_afresh(batch, stream, known)
    best = int(np.argmax(summits.s))
    if summits.s[best] <= summits.s[:first].max() * (1.0 + ROUNDING):
        best = int(np.argmax(summits.s[:first]))
    return DualBound(
        gradient=gradient,
        offset=offset,
        largest=float(summits.s[best]),
        x_largest=summits.x[best],
        starts=summits.starts,
        attained=int(np.sum(summits.at_top & summits.fresh)),
        narrow_starts=len(narrow),
        narrow_attained=int(np.sum(summits.at_top & summits.narrow)),
        rarest=rarest,
        x_found=summits.x,
        s_found=summits.s,
    )


class _Summits:
    """Local maxima of the sensitivity, as they are found."""

    def __init__(self, space: DesignSpace, gradient: Array) -> None:
        self.space, self.gradient = space, gradient
        self.x: Array = np.zeros((0, len(space.lower)))
        self.s: Array = np.zeros(0)
        self.fresh: BoolArray = np.zeros(0, dtype=bool)  # which are found from fresh random starts
        self.narrow: BoolArray = np.zeros(0, dtype=bool)  # and from starts in narrow parts
        self.starts = 0  # fresh random ones

    def climb(self, begin: Array, stages: Stages, fresh: int = _NONE, narrow: int = _NONE) -> None:
        """Climb from (N, d) points, from `fresh` on fresh random ones, from `narrow` on narrow."""
        if not len(begin):
            return
        x, s, origin = climb(self.space, begin, self.gradient, stages)
        self.x, self.s = np.concatenate([self.x, x]), np.concatenate([self.s, s])
        self.fresh = np.append(self.fresh, origin >= fresh)
        self.narrow = np.append(self.narrow, origin >= narrow)

    def climb_afresh(self, count: int, rng: np.random.Generator, known: Array) -> int:
        """Climb from `known` (K, d) and from `count` random points; how many there were."""
        drawn = self.space.sample(count, rng)
        begin = np.concatenate([known, drawn])
        self.climb(begin, _patient(len(begin)), len(known))
        self.starts += len(drawn)
        return len(drawn)

    @property
    def at_top(self) -> BoolArray:
        """(K,) which of them are as high as the highest."""
        return np.asarray(self.s > self.s.max() * (1.0 - _AT_TOP))

    def rarest(self, support: Array | None) -> int:
        """How many starts found that one of (S, d) points at the top which fewest found."""
        reached = self.x[self.at_top & (self.fresh | self.narrow)]
        if support is None or not len(support) or not len(reached):
            return len(reached)
        first, second = (
            information(self.space.evaluate(x).blocks).reshape(len(x), -1)
            for x in (support, reached)
        )
        # |b - a|² but for what is common to all a; differences of all pairs take gigabytes.
        distance = 0.5 * np.einsum("si,si->s", first, first) - second @ first.T
        return int(np.bincount(distance.argmin(axis=1), minlength=len(first)).min())


def _patient(starts: int) -> Stages:
    """Stages of a climb whose best must have arrived: long for those that may be the highest."""
    return (100, starts), (100, 100), (300, 30)
