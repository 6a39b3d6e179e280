"""Rounding: from weights to repeats."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, IntArray

# Of equals the first gets one more and the last gives one up: with more experiments nothing falls.
_EQUAL = 1e-12


def apportion(weights: Array, count: int) -> IntArray:
    """Integer repeats of sum `count` for weights (S,), by efficient apportionment.

    Every positive weight gets at least one repeat if `count` allows; among all roundings this
    one keeps the largest efficiency that can be promised from the weights alone.

    Source: Pukelsheim & Rieder (1992), Biometrika 79, 763.
    """
    weights = np.where(weights > 1e-9, weights, 0.0)
    weights = weights / weights.sum()
    support = np.flatnonzero(weights)
    if len(support) > count:
        support = support[np.argsort(-weights[support], kind="stable")[:count]]
    share = weights[support]
    repeats = np.maximum(np.ceil((count - 0.5 * len(support)) * share), 1).astype(np.int64)
    while repeats.sum() < count:
        ratio = repeats / share
        repeats[np.flatnonzero(ratio <= ratio.min() * (1.0 + _EQUAL))[0]] += 1
    while repeats.sum() > count:
        reducible = np.where(repeats > 1, (repeats - 1) / share, -1.0)
        repeats[np.flatnonzero(reducible >= reducible.max() * (1.0 - _EQUAL))[-1]] -= 1
    result = np.zeros(len(weights), dtype=np.int64)
    result[support] = repeats
    return result
