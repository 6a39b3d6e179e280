"""Spread: a plan whose load cases are not near to each other, where repeats share errors.

The search counts the errors of two load cases as independent however close they are, so it may put
two side by side that are one in truth. In: its plan. Out: the plan in which such are moved to where
they tell more, if it is worth more when near ones count as one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, frozen
from elastocal.design.exact import ExactDesign
from elastocal.design.refinement import Goal, Plans, refine
from elastocal.design.space import information
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.aim import Aim
from elastocal.planning.plain_values import simplify
from elastocal.study.experiment_space import LoadCaseSpace

_POOL = 2000  # random load cases, some of which take the place of crowded ones
_ROUNDS = 3
_NOTHING = 1e-3  # share of φ that is next to nothing


def spread(
    aim: Aim, space: LoadCaseSpace, goal: Goal, design: ExactDesign, rng: np.random.Generator
) -> ExactDesign:
    """The design, or one that is worth more when near load cases count as one.

    Args:
        aim: What plans are to be good for.
        space: The part of its space that is searched.
        goal: What the search optimised.
        design: The plan to begin with.
        rng: Source of load cases to put in place of crowded ones.
    """
    best, most = design, _worth(aim, design.x, design.counts)
    x, counts = design.x, design.counts
    for _ in range(_ROUNDS):
        extra = _crowded(aim, x, counts)
        if not len(extra):
            break
        pool = space.sample(_POOL, rng)
        alone = pool[~_near_before(aim, pool)]
        x = _replaced(goal, x, counts, extra, alone if len(alone) else pool)
        refined = refine(goal, Plans(x[None], counts[None]), stages=((300, 1),), tolerance=1e-12)
        for tried in (x, refined.x[0]):
            worth = _worth(aim, tried, counts)
            if worth > most and space.feasible(tried).all():
                value = float(goal.values(tried[None], counts[None])[0])
                best, most = replace(design, x=tried, counts=counts, value=value), worth
        x = refined.x[0]
    return _joined(aim, goal, best, most)


def _joined(aim: Aim, goal: Goal, design: ExactDesign, worth: float) -> ExactDesign:
    """The design with groups that share errors made one load case, where next to nothing is lost.

    Every configuration costs time.
    """
    x, counts = design.x, design.counts
    group = _groups(aim, x)
    for g in np.flatnonzero(np.bincount(group) > 1).tolist():
        own = group == g
        options = []
        for i in np.flatnonzero(own).tolist():
            kept = ~own
            kept[i] = True
            repeats = np.where(np.arange(len(x)) == i, counts[own].sum(), counts)[kept]
            options.append((_worth(aim, x[kept], repeats), x[kept], repeats))
        best = max(options, key=lambda option: option[0])
        if best[0] >= worth * (1.0 - _NOTHING):
            value = float(goal.values(best[1][None], best[2][None])[0])
            joined = replace(design, x=best[1], counts=frozen(best[2], np.int64), value=value)
            return _joined(aim, goal, joined, worth)
    return design


def _worth(aim: Aim, x: Array, counts: IntArray) -> float:
    """φ of a plan whose near load cases count as one."""
    return float(aim.criterion.value(aim.total(_plain(aim, x), counts)[None])[0])


def _plain(aim: Aim, x: Array) -> LoadCases:
    """Load cases of design points, as plans have them: joints that do not matter are at rest."""
    return simplify(aim.space, aim.space.load_cases(x)).cases


def _groups(aim: Aim, x: Array) -> IntArray:
    """(S,) which of the points (S, d) share errors."""
    assert aim.told is not None
    return aim.told.groups(_plain(aim, x))[0]


def _crowded(aim: Aim, x: Array, counts: IntArray) -> IntArray:
    """Numbers of load cases that are near another one which is measured as often or more.

    Or near one that was measured before.
    """
    group = _groups(aim, x)
    order = np.argsort(-counts, kind="stable")
    kept = order[np.unique(group[order], return_index=True)[1]]
    return np.setdiff1d(np.arange(len(x)), kept[~_near_before(aim, x)[kept]])


def _near_before(aim: Aim, x: Array) -> BoolArray:
    """(S,) which of the points (S, d) share errors with what was read before."""
    assert aim.told is not None
    if aim.told.before is None:
        return np.zeros(len(x), dtype=bool)
    return np.asarray(aim.told.near_before(_plain(aim, x))[0].any(axis=1))


def _replaced(goal: Goal, x: Array, counts: IntArray, extra: IntArray, pool: Array) -> Array:
    """The points (S, d) with those of `extra` replaced, one by one, by the best of the pool."""
    x = x.copy()
    for i in extra.tolist():
        often = np.full(len(pool), float(counts[i]))
        gained = counts[i] * information(goal.space.evaluate(pool, often).blocks)
        rest = np.delete(counts, i)
        total, _ = goal.totals(np.delete(x, i, axis=0)[None], rest[None])
        x[i] = pool[int(goal.criterion.value(total + gained).argmax())]
    return x
