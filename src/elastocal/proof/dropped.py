"""Variables that change nothing: found by structure or by chance, and proved.

A joint before which nothing bends turns the whole arm: where load and constraints do not mind, it
changes no sensitivity. Other variables do not change the rows at all: sliding joints that carry
everything, the last joint if all that counts lies on its axis. What is not proved is kept.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.proof.reference import margins, sensitivity, size_of_rows
from elastocal.proof.series import FiniteSeries, constraint_series
from elastocal.proof.statement import AnyDirection, InCone, Statement, SteadyLoad

_ALIGNED = 1e-12  # sine of an angle, or share of a length, that is rounding
_TRIED = 1000  # points by chance
_SAME = 1e-11  # share of the size of d by which images may differ


def base_joint(statement: Statement) -> int | None:
    """The joint that turns the whole arm and changes nothing; None if there is none.

    It is the first that turns. Every spring of V is beyond it, or on its axis; the load is along
    its axis, or has no direction of its own; the constraints do not depend on it; and d is the
    same at 1000 points by chance and where it is turned.

    Args:
        statement: With the joints' own coordinates, whole ranges.
    """
    s = statement
    turning = np.flatnonzero(~s.joints.slides)
    if not len(turning) or s.joints.lower[turning[0]] == s.joints.upper[turning[0]]:
        return None
    first = int(turning[0])
    if not (_carries_all(s, first) and _spares_load(s, s.joints.axis[first])):
        return None
    depends = [one for one in constraint_series(s) if first in dependent(one)]
    return None if depends or not _same_if_turned(s, first) else first


def _carries_all(s: Statement, joint: int) -> bool:
    """Whether all springs with a row of V are beyond a joint, or on its axis."""
    axis, point = s.joints.axis[joint], s.joints.point[joint]
    for j in np.flatnonzero(s.seen.any(axis=1) & (s.springs.body <= joint)).tolist():
        if not _parallel(s.springs.axis[j], axis):
            return False
        if s.springs.slides[j]:
            continue  # along the axis it moves all alike, wherever it is
        away = np.cross(axis, s.springs.point[j] - point)
        if s.springs.body[j] != joint or np.linalg.norm(away) > _ALIGNED * (1.0 + _length(point)):
            return False
    return True


def _spares_load(s: Statement, axis: Array) -> bool:
    """Whether turning about an axis takes allowed loads to allowed ones."""
    load = s.load
    if isinstance(load, SteadyLoad):
        return all(_parallel(one, axis) for one in (load.force, load.moment) if one.any())
    if isinstance(load, InCone):
        return _parallel(load.axis, axis)
    if load.basis.shape[1] == 3:
        return True
    return _parallel(np.cross(*load.basis.T), axis)


def _parallel(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(np.cross(a, b)) <= _ALIGNED * _length(a) * _length(b))


def _length(a: Array) -> float:
    return float(np.linalg.norm(a))


def _same_if_turned(s: Statement, joint: int) -> bool:
    """Whether d is the same at points by chance and where one joint has other values."""
    rng = np.random.default_rng(0)
    x = s.root[0] + (s.root[1] - s.root[0]) * rng.uniform(size=(_TRIED, len(s.joints)))
    other = x.copy()
    other[:, joint] += rng.uniform(-np.pi, np.pi, _TRIED)
    return same_at(s, x, other, None)


def same_at(s: Statement, x: Array, other: Array, of: IntArray | None) -> bool:
    """Whether d is the same at points x, (N, n), and at others, and constraints are.

    Args:
        s: The statement.
        x: Points.
        other: Their images.
        of: (C,) which constraint each becomes; None: they are not looked at.
    """
    allowed = _SAME * size_of_rows(s) ** 2 * _load_rank(s)
    if np.abs(sensitivity(s, x) - sensitivity(s, other)).max() > allowed:
        return False
    if of is None or not len(of):
        return True
    here, there = margins(s, x), margins(s, other)
    return bool(np.abs(there[:, of] - here).max() <= 1e-9 * (1.0 + np.abs(here).max()))


def _load_rank(s: Statement) -> float:
    """Forces that are summed up at most in a sensitivity."""
    return 3.0 if isinstance(s.load, AnyDirection | InCone) else 1.0


def dependent(series: FiniteSeries) -> set[int]:
    """The variables that a function depends on: those of which not all coefficients are rounding.

    Its coefficients come from as many points as its degree needs, so this is a proof.
    """
    pairs = zip(series.variables.tolist(), series.degrees, strict=True)
    return {variable for variable, degree in pairs if degree}
