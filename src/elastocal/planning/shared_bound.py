"""What plans of few load cases can tell at most, where repeats share errors.

n readings of one load case tell h(n) = tr(G n M_x(n)), concave in n: the more there are, the less
each of them adds. A plan of m readings in c load cases tells at most what the best split of m into
c parts tells, each part at its best place.

In: the gradient of a criterion. Out: the factor to m times the largest sensitivity.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from elastocal.arrays import Array

_KNOWN = 1.0 + 1e-12  # of equal splits the one that is known


def largest_sum(most: Callable[[int], float], count: int, distinct: int) -> float:
    """Largest Σ h(n_i) over plans of `count` readings at no more than `distinct` load cases.

    Args:
        most: h(n) at its best place; asked for as few n as it takes.
        count: m.
        distinct: c.

    Source: ours. h is concave with h(0) = 0, so what is not asked is at most h(k) for n below k and
    h(k) n / k for n above; the best split by these is asked until all its parts are known.
    """
    known: dict[int, float] = {}
    ask = {max(count // distinct, 1)}
    while ask:
        known.update({n: most(n) for n in sorted(ask)})
        limits = np.array([_limit(known, n) for n in range(count + 1)])
        best, parts = _best_split(limits, count, distinct)
        ask = set(parts) - set(known)
    return best


def _limit(known: dict[int, float], n: int) -> float:
    """What h(n) cannot be above, by the values that are known."""
    if n == 0:
        return 0.0
    if n in known:
        return known[n] * _KNOWN
    return min(value * max(n / k, 1.0) for k, value in known.items())


def _best_split(limits: Array, count: int, distinct: int) -> tuple[float, list[int]]:
    """Largest sum of limits (m + 1,) over splits of m into so many parts, and the parts."""
    best = np.full(count + 1, -np.inf)
    best[0] = 0.0
    chosen = np.zeros((distinct, count + 1), dtype=np.int64)
    for part in range(distinct):
        sums = np.array(
            [
                [best[m - n] + limits[n] if n <= m else -np.inf for n in range(count + 1)]
                for m in range(count + 1)
            ]
        )
        chosen[part] = sums.argmax(axis=1)
        best = sums.max(axis=1)
    left, parts = count, []
    for part in reversed(range(distinct)):
        parts.append(int(chosen[part, left]))
        left -= parts[-1]
    return float(best[count]), [n for n in parts if n]
