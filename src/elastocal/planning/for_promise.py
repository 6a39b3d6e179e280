"""For its promise: a plan that counts springs is moved to where errors of load cases cost least.

In: a plan that is good for ρ0. Out: one that promises more: load cases are exchanged for random
feasible ones, repeats for other load cases, then all are stirred at smaller and smaller scales.
Repeats share friction and discrepancy, so their information is concave: every move is judged with
the covariances that its counts have.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.exact import ExactDesign
from elastocal.design.refinement import Goal
from elastocal.errors import InfeasibleError
from elastocal.planning.with_errors import WithErrors
from elastocal.stopping import Stop
from elastocal.study.criteria import RHO0
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import Study

_POOL = 1500  # random load cases
_STIRRED = 40  # of each load case
_SCALES = (0.1, 0.03, 0.01)  # shares of the ranges by which load cases are stirred
_GAIN = 1e-6  # share of the square that a move must gain
_SWEEPS = 20


def is_for_promise(study: Study) -> bool:
    """Whether plans are made for their promise: load cases have errors, and ρ0 is asked for."""
    known = study.nuisance is not None and study.nuisance.errors.any
    return known and study.criterion == RHO0.name


def for_promise(
    study: Study,
    space: LoadCaseSpace,
    goal: Goal,
    design: ExactDesign,
    seed: int,
    stop: Stop | None = None,
) -> ExactDesign:
    """The design after the moves; no bound is known of what it promises but that on ρ0.

    Args:
        study: A study of which `is_for_promise` holds.
        space: Where load cases may be.
        goal: What the search optimised, for the value of the design.
        design: The plan to begin with.
        seed: Of random load cases.
        stop: Asked between rounds whether to end.
    """
    assert study.nuisance is not None
    rng, told = np.random.default_rng([seed, 3]), WithErrors(study, study.nuisance)
    m = study.experiments.count
    distinct = min(m, study.experiments.max_configurations or m)
    x, counts = design.x, design.counts
    for scale in (None, *_SCALES):
        if stop is not None and stop():
            break
        more = _anywhere(space, rng) if scale is None else _stirred(space, x, scale, rng)
        x, counts = _exchanged(told, space, np.concatenate([x, more]), counts, distinct)
    order = np.argsort(-counts, kind="stable")
    x, counts = x[order], frozen(counts[order], np.int64)
    value = float(goal.values(x[None], counts[None])[0])
    return replace(design, x=x, counts=counts, value=value)


def _anywhere(space: LoadCaseSpace, rng: np.random.Generator) -> Array:
    """Random feasible design points; none where none are found."""
    try:
        return space.sample(_POOL, rng)
    except InfeasibleError:
        return np.zeros((0, len(space.lower)))


def _stirred(space: LoadCaseSpace, x: Array, scale: float, rng: np.random.Generator) -> Array:
    """Feasible design points near those of x."""
    step = scale * (space.upper - space.lower)
    near = np.repeat(x, _STIRRED, axis=0)
    near = np.clip(near + step * rng.normal(size=near.shape), space.lower, space.upper)
    return near[space.feasible(near)]


def _exchanged(
    told: WithErrors, space: LoadCaseSpace, pool: Array, counts: IntArray, distinct: int
) -> tuple[Array, IntArray]:
    """The best choice that exchanges lead to: points (S, d) of the pool, (S,) repeats.

    The first points of the pool have `counts` repeats, the others none.
    """
    search = _Exchange(told, space, pool)
    chosen = np.zeros(len(pool), dtype=np.int64)
    chosen[: len(counts)] = counts
    for _ in range(_SWEEPS):
        moved = [search.move(chosen, i, distinct) for i in np.flatnonzero(chosen).tolist()]
        if not any(moved):
            break
    return pool[chosen > 0], chosen[chosen > 0]


class _Exchange:
    """A pool of load cases, and what choices of them promise."""

    def __init__(self, told: WithErrors, space: LoadCaseSpace, pool: Array) -> None:
        self._told, self._cases = told, space.load_cases(pool)
        self._known: dict[int, Array] = {}
        once = told.informations(self._cases, np.ones(len(pool), dtype=np.int64))
        self._scale = 1.0 / np.sqrt(np.diagonal(told.base + once.mean(axis=0)))
        self._known[1] = self._scaled(once)
        self._base = self._scaled(told.base[None])[0]
        study = told.study
        rows = [
            np.sqrt(share / len(pose.regressors)) * told.blocks(pose).reshape(-1, len(self._scale))
            for share, pose in zip(study.shares, study.test_poses, strict=True)
            if share > 0.0
        ]
        few = np.asarray(np.linalg.qr(np.concatenate(rows) * self._scale, mode="r"))
        self._columns = few.T

    def _scaled(self, informations: Array) -> Array:
        return np.asarray(informations * np.outer(self._scale, self._scale))

    def _of(self, count: int) -> Array:
        """(N, q, q) informations of all, each measured so often."""
        if count not in self._known:
            repeats = np.full(len(self._cases), count)
            found = self._told.informations(self._cases, repeats)
            self._known[count] = self._scaled(found)
        return self._known[count]

    def _squares(self, totals: Array) -> Array:
        """(K,) mean squares that totals (K, q, q) leave at the test poses."""
        columns = np.broadcast_to(self._columns, (len(totals), *self._columns.shape))
        solved = np.linalg.solve(totals, columns)
        return np.asarray((self._columns * solved).sum(axis=(1, 2)))

    def move(self, chosen: IntArray, i: int, distinct: int) -> bool:
        """Whether all repeats of point i, or one of them, are better elsewhere: they are moved."""
        count = int(chosen[i])
        if not count:
            return False
        taken = np.flatnonzero(chosen)
        total = self._base + sum(self._of(int(chosen[k]))[k] for k in taken)
        now = float(self._squares(total[None])[0])
        rest = total - self._of(count)[i]
        new = np.flatnonzero(chosen == 0)
        moves = [(count, j) for j in new.tolist()]
        totals = [rest + self._of(count)[new]]
        less = rest + (self._of(count - 1)[i] if count > 1 else 0.0)
        others = [k for k in taken.tolist() if k != i]
        for k in others:
            had = int(chosen[k])
            moves.append((1, k))
            totals.append((less + self._of(had + 1)[k] - self._of(had)[k])[None])
        if count > 1 and len(taken) < distinct:
            moves += [(1, j) for j in new.tolist()]
            totals.append(less + self._of(1)[new])
        squares = self._squares(np.concatenate(totals))
        best = int(squares.argmin())
        if not squares[best] < now * (1.0 - _GAIN):
            return False
        size, to = moves[best]
        chosen[i] -= size
        chosen[to] += size
        return True
