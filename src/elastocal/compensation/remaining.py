"""What remains along a corrected path: as expected, and as a true model judges it.

In: a compensation, and errors of a robot whose compliances are known. Out: sizes and doubts.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.compensation.compensate import Compensation
from elastocal.errors import Code, Doubt

_WIDE = 2.0  # times the expected error that is still as expected


def rms(error: Array) -> float:
    """Root mean square length of errors (N, 3), or of lengths (N,) [m]; NaN is left out."""
    size = error if error.ndim == 1 else np.linalg.norm(error, axis=1)
    size = size[np.isfinite(size)]
    return float(np.sqrt(np.mean(size**2))) if len(size) else float("nan")


def as_expected(compensation: Compensation, judged: Array) -> tuple[int, int]:
    """Points whose error (N, 3) is at most twice what is expected [m], and points that have one."""
    size = np.linalg.norm(judged, axis=1)
    known = np.isfinite(size)
    inside = size[known] <= _WIDE * compensation.expected[known]
    return int(inside.sum()), int(known.sum())


def alarms(compensation: Compensation) -> tuple[Doubt, ...]:
    """What forbids to run the corrected path."""
    lost = int((~compensation.converged).sum())
    beyond = int(compensation.beyond_limits.any(axis=1).sum())
    counts: dict[Code, int] = {"points-lost": lost, "points-beyond-limits": beyond}
    return tuple(
        Doubt(code, numbers={"points": count, "all": len(compensation)})
        for code, count in counts.items()
        if count
    )


def doubts_of_path(compensation: Compensation, judged: Array | None = None) -> tuple[Doubt, ...]:
    """What is weak in the whole path; `judged`, (N, 3), remains by a true model [m]."""
    doubts = list(compensation.notes)
    near = int((compensation.damped & compensation.converged).sum())
    if near:
        doubts.append(Doubt("points-nearly-singular", numbers={"points": near}))
    if judged is not None:
        left, expected = rms(judged), rms(compensation.expected)
        if left > _WIDE * expected:
            numbers = {"remaining": left, "expected": expected}
            doubts.append(Doubt("more-than-expected", numbers=numbers))
    return tuple(doubts)
