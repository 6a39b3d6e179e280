"""Least squares of unknowns that cannot be negative.

Ours, for a few dozen unknowns: SciPy's takes half a second to load with all of its optimisers.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray

_ROUNDING = 10.0 * float(np.finfo(np.float64).eps)
_MOST = 10  # rounds for each unknown


def nonnegative(rows: Array, values: Array) -> Array:
    """(p,) the x >= 0 with the least |rows x - values|; what is held is exactly zero.

    Args:
        rows: (r, p).
        values: (r,).

    Source: Lawson & Hanson, Solving Least Squares Problems, ch. 23, from the support of the fit
    without bounds, less what is negative there.
    """
    count, norms = rows.shape[1], np.linalg.norm(rows, axis=0)
    norms = np.where(norms > 0.0, norms, 1.0)
    rows = rows / norms
    nothing = _ROUNDING * max(rows.shape) * float(np.linalg.norm(values))
    free = np.ones(count, dtype=bool)
    x = np.zeros(count)
    if count <= len(rows):
        while free.any():
            x[free] = _fit(rows[:, free], values)
            if (x[free] > 0.0).all():
                break
            free &= x > 0.0
    else:
        free[:] = False
    x[~free] = 0.0
    for _ in range(_MOST * count):
        slope = rows.T @ (values - rows @ x)
        slope[free] = -np.inf
        entered = _entered(rows, values, free, slope, nothing)
        if entered is None:
            break
        free, trial = entered
        while not (trial[free] > 0.0).all():
            falling = np.flatnonzero(free & (trial <= 0.0))
            share = x[falling] / (x[falling] - trial[falling])
            x = x + share.min() * (trial - x)
            free[falling[share <= share.min()]] = False
            free &= x > 0.0
            x[~free] = 0.0
            trial = np.zeros(count)
            trial[free] = _fit(rows[:, free], values)
        x = trial
    return np.asarray(x / norms)


def _entered(
    rows: Array, values: Array, free: BoolArray, slope: Array, nothing: float
) -> tuple[BoolArray, Array] | None:
    """What is free with the unknown that gains most, and the fit then; None if none gains."""
    for best in np.argsort(-slope).tolist():
        if not slope[best] > nothing:
            return None
        wider = free.copy()
        wider[best] = True
        trial = np.zeros(len(free))
        trial[wider] = _fit(rows[:, wider], values)
        if trial[best] > 0.0:  # but for rounding it always is
            return wider, trial
    return None


def _fit(rows: Array, values: Array) -> Array:
    return np.asarray(np.linalg.lstsq(rows, values, rcond=None)[0])
