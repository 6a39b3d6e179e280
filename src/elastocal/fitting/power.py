"""Power: how probably a test of fit sees what a model lacks, by its non-centrality.

Something of size x moves readings by x b; with Q the precision of the residuals the sum of squares
is non-central by λ x², λ = bᵀ Q b.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from elastocal.fitting.chances import chi_square_above, ratio_above

LEVEL = 0.05
"""Probability that a test refuses a right model."""
_SMALL = 1e-14  # of a probability


def power(noncentrality: float, dof: float, other: float = math.inf) -> float:
    """Probability that a test of level 5 % refuses a sum of squares that is so non-central.

    Args:
        noncentrality: λ x²; zero for a right model.
        dof: Degrees of freedom of the sum of squares.
        other: Degrees of freedom of the noise that it is held against; infinite if that is known.

    Source: non-central χ² and F as mixtures by Poisson weights, Johnson, Kotz & Balakrishnan,
    ch. 29 and 30.
    """
    if not dof > 0.0:
        return LEVEL
    return _power(noncentrality, dof, other, _critical(dof, other))


def seen_half(dof: float, other: float = math.inf) -> float:
    """Non-centrality that a test of level 5 % sees half of the time; infinite if there is no test.

    Args as those of `power`.
    """
    if not (dof > 0.0 and other > 0.0):
        return math.inf
    critical = _critical(dof, other)
    return _where(lambda size: 0.5 - _power(size, dof, other, critical))


def critical_chi_square(dof: float) -> float:
    """What χ² with `dof` degrees of freedom exceeds once in twenty times."""
    return dof * _critical(dof, math.inf)


def _power(noncentrality: float, dof: float, other: float, critical: float) -> float:
    half = 0.5 * noncentrality
    if half > 350.0:  # beyond any doubt, and beyond what the weights can hold
        return 1.0
    weight, total, left, j = math.exp(-half), 0.0, 1.0, 0
    while left > _SMALL and j < 2000:
        total += weight * _above(critical, dof + 2 * j, dof, other)
        left -= weight
        j += 1
        weight *= half / j
    return min(total + max(left, 0.0), 1.0)


def _above(critical: float, dof: float, first: float, other: float) -> float:
    """Chance that a sum of `dof` squares, over `first` and the noise, is above a critical value."""
    if math.isinf(other):
        return chi_square_above(critical * first, dof)
    return ratio_above(critical * first / dof, dof, other)


def _critical(dof: float, other: float) -> float:
    return _where(lambda value: _above(value, dof, dof, other) - LEVEL)


def _where(falling: Callable[[float], float]) -> float:
    """Where a falling function of positive numbers is zero."""
    low, high = 0.0, 1.0
    while falling(high) > 0.0:
        low, high = high, 2.0 * high
    while low < (middle := 0.5 * (low + high)) < high and high - low > 1e-12 * high:
        if falling(middle) > 0.0:
            low = middle
        else:
            high = middle
    return high
