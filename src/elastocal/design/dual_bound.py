"""The bound of concave duality: how far any design can be from the best of all designs.

For an information function φ and G = ∇φ(M) at any M whatever, concavity and homogeneity give

    φ(B + Σ_i M_i) ≤ tr(G B) + m max_x tr(G M_x)     for every design of m experiments.

So M need not be optimal, rounding errors in it cost tightness and never validity, and the only
thing to be believed is the maximum. It is searched from many fresh random starts: the certificate
is numerical, and says how many starts stand behind it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import InformationFunction
from elastocal.design.oracle import climb, restore
from elastocal.design.space import DesignSpace


def _patient(starts: int) -> tuple[tuple[int, int], ...]:
    """Stages of a climb whose best must have arrived: long for those that may be the highest."""
    return (100, starts), (100, 100), (300, 30)


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
        x_found: (K, d) the local maxima found.
        s_found: (K,) their sensitivities.
    """

    gradient: Array
    offset: float
    largest: float
    x_largest: Array
    starts: int
    attained: int
    x_found: Array
    s_found: Array

    @property
    def upper(self) -> float:
        """No design of unit weight has a larger φ."""
        return self.offset + self.largest


# Bounds confirmed by the starts of the search alone are often false.
_FRESH = 600  # fresh random starts that must fail to refute the bound; more are made if too few ...
_ENOUGH = 12  # ... reach the highest summit,
_MOST = 8  # up to so many times as many
_NEAR = 30  # highest summits whose neighbourhood is searched again ...
_STIR = 0.03  # ... from points this share of the ranges away


def dual_bound(
    space: DesignSpace,
    criterion: InformationFunction,
    total: Array,
    base: Array,
    known: Array,
    rng: np.random.Generator,
    *,
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
        fresh: Number of fresh random starts; more are made if few of them reach the maximum.
    """
    gradient = criterion.gradient(total[None])[0]
    found, s, fresh_found = np.zeros((0, known.shape[1])), np.zeros(0), np.zeros(0, dtype=bool)
    starts, batch = 0, fresh
    while True:
        drawn = space.sample(batch, rng)
        begin = np.concatenate([known, drawn])
        more, s_more, origin = climb(space, begin, gradient, _patient(len(begin)))
        found, s = np.concatenate([found, more]), np.concatenate([s, s_more])
        fresh_found = np.append(fresh_found, origin >= len(known))
        known = known[:0]
        starts += len(drawn)
        attained = int((s[fresh_found] > s.max() * (1.0 - 1e-4)).sum())
        # A summit that few starts reach may not be the highest: look on.
        if attained >= _ENOUGH or starts >= _MOST * fresh or len(drawn) < batch:
            break
        batch = starts
    # A higher summit may stand beside the highest one found, cut off by a constraint.
    near = found[np.argsort(-s)[:_NEAR]]
    near = near + _STIR * (space.upper - space.lower) * rng.normal(size=near.shape)
    beside, s_beside, _ = climb(space, restore(space, near), gradient, ((150, len(near)),))
    found, s = np.concatenate([found, beside]), np.concatenate([s, s_beside])
    best = int(np.argmax(s))
    return DualBound(
        gradient=gradient,
        offset=float(np.sum(gradient * base)),
        largest=float(s[best]),
        x_largest=found[best],
        starts=starts,
        attained=int((s[: len(fresh_found)][fresh_found] > s[best] * (1.0 - 1e-4)).sum()),
        x_found=found,
        s_found=s,
    )
