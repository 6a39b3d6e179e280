"""Chances of the usual statistics, in plain floating point.

The same as in `scipy.special`, which takes longer to load than a campaign takes to fit.
"""

from __future__ import annotations

import math

_EPS = 2.0**-53
_TINY = 1e-300


def normal_quantile(probability: float) -> float:
    """Quantile of the standard normal distribution."""
    if not 0.0 < probability < 1.0:
        return math.copysign(math.inf, probability - 0.5) if probability in (0.0, 1.0) else math.nan
    if probability > 0.5:
        return -normal_quantile(1.0 - probability)
    low, high = -40.0, 0.0
    while low < (middle := 0.5 * (low + high)) < high:
        if 0.5 * math.erfc(-middle / math.sqrt(2.0)) < probability:
            low = middle
        else:
            high = middle
    return high


def chi_square_above(value: float, dof: float) -> float:
    """Probability that χ² with `dof` degrees of freedom is larger.

    Source: DLMF 8.7.1 below the mean, the continued fraction 8.9.2 above.
    """
    a, x = 0.5 * dof, 0.5 * value
    if not x > 0.0 or math.isinf(x):
        return math.nan if math.isnan(x) else float(x <= 0.0)
    front = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x < a + 1.0:
        total = term = 1.0 / a
        while term > _EPS * total:
            a += 1.0
            term *= x / a
            total += term
        return max(1.0 - front * total, 0.0)
    b = x + 1.0 - a
    fraction, d, c, step, i = 1.0 / b, 1.0 / b, 1.0 / _TINY, 0.0, 0
    while abs(step - 1.0) > 2.0 * _EPS:
        i += 1
        even, b = -i * (i - a), b + 2.0
        d, c = 1.0 / _not_zero(even * d + b), _not_zero(b + even / c)
        step = c * d
        fraction *= step
    return front * fraction


def ratio_above(value: float, dof: float, other: float) -> float:
    """Probability that the ratio F of two variances with these degrees of freedom is larger."""
    if not value > 0.0 or math.isinf(value):
        return math.nan if math.isnan(value) else float(value <= 0.0)
    share = other / (other + dof * value)
    rest = dof * value / (other + dof * value)
    if share == 0.0 or rest == 0.0:  # beyond what floating point holds
        return share
    return _beta(0.5 * other, 0.5 * dof, share, rest)


def _beta(a: float, b: float, x: float, y: float) -> float:
    """The regularised incomplete beta function of x = 1 - y, from the side that converges fast."""
    swapped = x > (a + 1.0) / (a + b + 2.0)
    return 1.0 - _fraction(b, a, y, x) if swapped else _fraction(a, b, x, y)


def _fraction(a: float, b: float, x: float, y: float) -> float:
    """The same as a continued fraction.

    Source: DLMF 8.17.22, by the method of Lentz.
    """
    front = math.exp(
        math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log(y)
    )
    d = 1.0 / _not_zero(1.0 - (a + b) * x / (a + 1.0))
    fraction, c, step, m = d, 1.0, 0.0, 0
    while abs(step - 1.0) > 2.0 * _EPS:
        m += 1
        step = 1.0
        for term in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d, c = 1.0 / _not_zero(1.0 + term * d), _not_zero(1.0 + term / c)
            step *= d * c
        fraction *= step
    return front * fraction / a


def _not_zero(value: float) -> float:
    return value if abs(value) > _TINY else _TINY
