"""Robust: a plan of which no single configuration carries the result.

In: a plan that is as good as can be, a limit. Out: one that leaves no more than the limit without
any of its configurations, and as little as possible with all of them: load cases are exchanged for
random ones, repeats for other load cases, then all are stirred at smaller and smaller scales.
Configurations stay apart, for one that is split in two could be lost as a whole.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.exact import ExactDesign
from elastocal.design.refinement import Goal
from elastocal.design.space import information
from elastocal.errors import Doubt, InfeasibleError, InputError
from elastocal.planning.aim import Aim
from elastocal.planning.assessment import Assessment
from elastocal.planning.certificate import Certificate
from elastocal.planning.near import NEAR, apart, near_configurations
from elastocal.planning.plain_values import simplify
from elastocal.study.criteria import RHO0
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import Study

_POOL = 1000  # random load cases
_STIRRED = 60  # of each load case
_SCALES = (0.1, 0.03, 0.01)  # shares of the ranges by which load cases are stirred
_FEW = 8  # unknowns up to which so many are tried
_SWEEPS = 12
_GAIN = 1e-5  # share of what is to fall that a move must gain
_NEARLY = 1.0 + 1e-3  # a limit that is passed by less is held
_DEAR = 10.0  # how much dearer it is to leave more than the limit


def least_loss(distinct: int) -> float:
    """How many times the best ρ0 a plan of so many configurations leaves at least without one.

    Source: ours; a concave φ of the mean over what is left is at least the mean of φ. It holds
    where nothing is known before.
    """
    return float(np.sqrt(distinct / (distinct - 1.0))) if distinct > 1 else float("inf")


def refuse_other_criterion(study: Study) -> None:
    """Raises:
    InputError: a robust plan is asked for by another criterion than ρ0.
    """
    if study.experiments.robust is not None and study.criterion != RHO0.name:
        raise InputError(
            f"robust speaks of ρ0: the criterion must be {RHO0.name}, found {study.criterion!r}"
        )


def loss_above(study: Study, worth: Assessment, proof: Certificate) -> Iterator[Doubt]:
    """That a plan leaves more without one configuration than the study allows."""
    share, loss, least = study.experiments.robust, worth.loss, proof.rho0_bound
    if share is None or loss is None or least is None or loss.rho0 <= share * least * _NEARLY:
        return
    distinct = study.experiments.distinct
    numbers = {"times": loss.rho0 / least, "asked": share, "configurations": distinct}
    if not study.prior.any():
        numbers["least"] = least_loss(distinct)
    yield Doubt("loss-above", numbers=numbers)


def robust(
    aim: Aim,
    space: LoadCaseSpace,
    goal: Goal,
    design: ExactDesign,
    limit: float,
    rng: np.random.Generator,
) -> ExactDesign:
    """The design after the moves.

    Args:
        aim: What plans are to be good for.
        space: The part of its space that is searched.
        goal: What the search optimised, for the value of the design.
        design: The plan to begin with.
        limit: The most that may be left at the test poses without any configuration [m].
        rng: Of random load cases.
    """
    x, counts = design.x, design.counts
    for scale in (None, *_SCALES):
        share = min(1.0, (_FEW / space.parameters) ** 2)  # of many unknowns fewer are tried
        if scale is None:
            more = _anywhere(space, round(share * _POOL), rng)
        else:
            more = _stirred(space, x, max(round(share * _STIRRED), 10), scale, rng)
        search = _Exchange(aim, np.concatenate([x, more]), limit)
        x, counts = search.exchanged(counts)
    order = np.argsort(-counts, kind="stable")
    x, counts = x[order], frozen(counts[order], np.int64)
    return replace(design, x=x, counts=counts, value=float(goal.values(x[None], counts[None])[0]))


def _anywhere(space: LoadCaseSpace, count: int, rng: np.random.Generator) -> Array:
    """Random feasible design points; none where none are found."""
    try:
        return space.sample(count, rng)
    except InfeasibleError:
        return np.zeros((0, len(space.lower)))


def _stirred(
    space: LoadCaseSpace, x: Array, count: int, scale: float, rng: np.random.Generator
) -> Array:
    """Feasible design points near those of x, so many of each."""
    step = scale * (space.upper - space.lower)
    near = np.repeat(x, count, axis=0)
    near = np.clip(near + step * rng.normal(size=near.shape), space.lower, space.upper)
    return near[space.feasible(near)]


class _Exchange:
    """A pool of load cases, and what choices of them leave."""

    def __init__(self, aim: Aim, pool: Array, limit: float) -> None:
        plain = simplify(aim.space, aim.space.load_cases(pool)).cases
        self._aim, self._limit, self._robot = aim, limit, aim.space.arm.robot
        self._pool, self._q = aim.space.points(plain), plain.q
        self._known: dict[int, Array] = {}  # what each adds, by how often it is measured
        once = self._of(1)
        self._scale = 1.0 / np.sqrt(np.diagonal(aim.base + once.mean(axis=0)) + 1e-300)
        losses = aim.criterion.losses
        assert losses is not None
        self._columns = self._scale[:, None] * np.hstack(losses.roots)

    def exchanged(self, counts: IntArray) -> tuple[Array, IntArray]:
        """The best choice: points (S, d), (S,) repeats; the first of the pool have `counts`."""
        chosen = np.zeros(len(self._pool), dtype=np.int64)
        chosen[: len(counts)] = counts
        for _ in range(_SWEEPS):
            if not any([self._move(chosen, i) for i in np.flatnonzero(chosen).tolist()]):
                break
        return self._pool[chosen > 0], chosen[chosen > 0]

    def _of(self, count: int) -> Array:
        """(N, p, p) what each of the pool adds, measured so often."""
        if count not in self._known:
            often = np.full(len(self._pool), float(count))
            blocks = self._aim.space.evaluate(self._pool, often).blocks
            self._known[count] = count * information(blocks)
        return self._known[count]

    def _left(self, totals: Array) -> Array:
        """(K,) mean squares that totals (K, p, p) leave; infinite where they tell too little."""
        scaled = totals * np.outer(self._scale, self._scale)
        scaled = scaled + 1e-12 * np.eye(len(self._scale))
        columns = np.broadcast_to(self._columns, (len(scaled), *self._columns.shape))
        solved = np.linalg.solve(scaled, columns)
        return np.asarray((self._columns * solved).sum(axis=(1, 2)) + self._aim.beyond)

    def _costs(self, totals: Array, groups: Array, new: Array | None) -> Array:
        """(K,) what is to fall: the mean square, dearer where a loss leaves more than the limit.

        Args:
            totals: (K, p, p) of all load cases.
            groups: (G, p, p) of the configurations that stay.
            new: (p, p) what all tell without the configuration that is new; None if there is none.
        """
        worst = np.zeros(len(totals))
        for group in groups:
            worst = np.maximum(worst, self._left(totals - group))
        if new is not None:
            worst = np.maximum(worst, self._left(new[None])[0])
        over = np.maximum(worst / self._limit**2 - 1.0, 0.0)
        return np.asarray(self._left(totals) * (1.0 + _DEAR * over))

    def _move(self, chosen: IntArray, i: int) -> bool:
        """Whether all repeats of point i, or one of them, are better elsewhere: they are moved."""
        count = int(chosen[i])
        if not count:
            return False
        now = self._cost_of(chosen)
        others = np.flatnonzero((chosen > 0) & (np.arange(len(chosen)) != i))
        far = apart(self._robot, self._q, self._q[others]).min(axis=1, initial=np.inf) > NEAR
        new = np.flatnonzero((chosen == 0) & far)
        total, groups = self._groups(chosen, others)
        moves = [(count, int(j)) for j in new]
        costs = [self._costs(total + self._of(count)[new], groups, total)]
        for k in others.tolist() if count > 1 else []:
            tried = chosen.copy()
            tried[i] -= 1
            tried[k] += 1
            moves.append((1, k))
            costs.append(np.array([self._cost_of(tried)]))
        if count > 1 and len(others) + 1 < self._aim.distinct:
            tried = chosen.copy()
            tried[i] -= 1
            total, groups = self._groups(tried, np.flatnonzero(tried))
            new = new[apart(self._robot, self._q[new], self._q[[i]])[:, 0] > NEAR]
            moves += [(1, int(j)) for j in new]
            costs.append(self._costs(total + self._of(1)[new], groups, total))
        found = np.concatenate(costs)
        if not len(found) or not found.min() < now * (1.0 - _GAIN):
            return False
        size, to = moves[int(found.argmin())]
        chosen[i] -= size
        chosen[to] += size
        return True

    def _cost_of(self, chosen: IntArray) -> float:
        """What is to fall, of a choice."""
        total, groups = self._groups(chosen, np.flatnonzero(chosen))
        return float(self._costs(total[None], groups, None)[0])

    def _groups(self, chosen: IntArray, points: IntArray) -> tuple[Array, Array]:
        """(p, p) what points tell together, and (G, p, p) by near configurations."""
        each = np.array([self._of(int(chosen[k]))[k] for k in points.tolist()])
        each = each.reshape(len(points), *self._aim.base.shape)
        group = near_configurations(self._robot, self._q[points])
        sums = np.zeros((int(group.max(initial=-1)) + 1, *self._aim.base.shape))
        np.add.at(sums, group, each)
        return self._aim.base + sums.sum(axis=0), sums
