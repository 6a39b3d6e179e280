"""Relieved: a plan of which no compliance rests on one configuration, for as little ρ0 as can be.

In: a plan on one configuration of which compliances rest. Out: one whose load cases are given for
random ones, then for near ones, as long as that pays. What a choice is worth without each of its
configurations is found from few rows each, by Woodbury's identity.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.exact import ExactDesign
from elastocal.design.refinement import Goal
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt
from elastocal.matrices import scaled_inverse
from elastocal.motion.schedule import fastest
from elastocal.planning.aim import Aim, accuracy
from elastocal.planning.near import NEAR, apart, near_configurations
from elastocal.planning.plain_values import Plain
from elastocal.planning.pool import anywhere, stirred
from elastocal.planning.resting import RESTS, resting, root, soft, together, without_each
from elastocal.planning.robust import in_plain_values
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import Study

_POOL, _STIRRED = 500, 10  # random load cases, and near ones of each of the plan
_SCALES = (0.1, 0.03, 0.01)  # shares of the ranges by which they are stirred
_SWEEPS = 4
_MOST = 30  # load cases that join and go
_GAIN = 1e-4  # share of what is to fall that a move must gain
_DEAR = 10.0  # how much dearer it is to let a compliance rest
_LITTLE = 1.05  # times ρ0 that it may cost that none does
_LONGER = 1.1  # times the minutes at the cell that it may take
_TIMES = 0.9 * RESTS  # standard errors without a configuration over those of the plan before


def relieved(
    study: Study,
    aim: Aim,
    space: LoadCaseSpace,
    goal: Goal,
    design: ExactDesign,
    plain: Plain,
    rng: np.random.Generator,
) -> tuple[ExactDesign, Plain] | None:
    """A design of which no compliance rests on one configuration; None where that is not needed.

    None, too, where it would cost much, or none was found.

    Args:
        study: The study.
        aim: What plans are to be good for; without errors that load cases share.
        space: The part of its space that is searched.
        goal: What the search optimised.
        design: The plan to begin with.
        plain: Its load cases.
        rng: Of random load cases.
    """
    before = plain.cases, design.counts
    if not study.experiments.weighs or resting(study, *before) is None:
        return None
    x, counts = _moved(study, aim, space, design, rng)
    made = in_plain_values(aim.space, x, None)
    after = made.cases, counts
    (now, long), (then, longer) = (_worth(study, aim, *each) for each in (before, after))
    paid = then <= _LITTLE * now and longer <= _LONGER * long
    if not paid or resting(study, *after) is not None:
        return None
    value = float(goal.values(x[None], counts[None])[0])
    return replace(design, x=x, counts=counts, value=value), made


def rests_on_one(study: Study, cases: LoadCases, repeats: IntArray) -> Iterator[Doubt]:
    """That compliances rest on one configuration, and what one more experiment is worth.

    Args:
        study: The study; nothing is said if its readings are not absolute.
        cases: S load cases.
        repeats: (S,) repeats.
    """
    rest = resting(study, cases, repeats) if study.experiments.weighs else None
    if rest is None:
        return
    aim = accuracy(study)
    more, often = cases.followed_by(_one_more(study, aim, cases, repeats)), np.append(repeats, 1)
    other = resting(study, more, often)
    (now, long), (then, longer) = (
        _worth(study, aim, *each) for each in ((cases, repeats), (more, often))
    )
    numbers = {
        "configuration": rest.load_case,
        "more": 0.0 if other is None else max(other.times.values()),
        "rho0": now,
        "more_rho0": then,
        "minutes": (longer - long) / 60.0,
    }
    yield Doubt("rests-on-one", tuple(rest.times), numbers=numbers | rest.times)


def _moved(
    study: Study, aim: Aim, space: LoadCaseSpace, design: ExactDesign, rng: np.random.Generator
) -> tuple[Array, IntArray]:
    """The load cases (S, d) of a design after the moves, and (S,) their repeats.

    Source: ours; Fedorov's exchange (1972) under a penalty.
    """
    search = _Relief(study, aim, design)
    x, counts = np.array(design.x), np.array(design.counts)
    pool = [anywhere(space, _POOL, rng)]
    pool += [stirred(space, x, _STIRRED, scale, rng) for scale in _SCALES]
    x, counts = search.given(x, counts, np.concatenate(pool))
    for scale in _SCALES:
        x, counts = search.exchanged(x, counts, stirred(space, x, _STIRRED, scale, rng))
    order = np.argsort(-counts, kind="stable")
    return x[order], frozen(counts[order], np.int64)


def _worth(study: Study, aim: Aim, cases: LoadCases, repeats: IntArray) -> tuple[float, float]:
    """ρ0 [m], and how long it takes at the cell in the best order [s]."""
    found = aim.loss(float(aim.criterion.value(aim.total(cases, repeats)[None])[0]))
    return found, fastest(cases, repeats, study.pace).total


def _one_more(study: Study, aim: Aim, cases: LoadCases, repeats: IntArray) -> LoadCases:
    """The load case that, measured besides, lets compliances rest least on one configuration."""
    rng = np.random.default_rng(0)
    design = ExactDesign(aim.space.points(cases), repeats, 0.0)
    pool = [anywhere(aim.space, _POOL, rng)]
    pool += [stirred(aim.space, design.x, _STIRRED, scale, rng) for scale in _SCALES]
    found = _Relief(study, aim, design).added(design.x, design.counts, np.concatenate(pool))
    return aim.space.load_cases(found[None])


class _Relief:
    """What choices of load cases cost."""

    def __init__(self, study: Study, aim: Aim, design: ExactDesign) -> None:
        self._space, self._robot, self._base = aim.space, study.robot, aim.base
        self._joints = len(study.robot.joints)
        self._distinct = aim.distinct
        self._which = soft(study)
        losses = aim.criterion.losses
        assert losses is not None
        self._task = np.hstack(losses.roots)
        rows = self._rows(design.x) * root(design.counts)
        covariance = scaled_inverse(self._total(rows)[None])[0]
        self._limits = _TIMES**2 * np.diagonal(covariance)[self._which]

    def given(self, x: Array, counts: IntArray, pool: Array) -> tuple[Array, IntArray]:
        """The load cases (S, d) with repeats (S,), some given for those of a pool (K, d).

        One more joins, and the one that is missed least goes, as long as that pays.
        """
        cost = self._cost(self._rows(x) * root(counts), self._groups(x))
        for _ in range(_MOST):
            more = np.concatenate([x, self.added(x, counts, pool)[None]])
            rows, group, often = self._rows(more), self._groups(more), np.append(counts, 1)
            left = np.tile(often, (len(often), 1)) - np.eye(len(often), dtype=np.int64)
            fits = (left > 0).sum(axis=1) <= self._distinct
            costs = [
                self._cost(rows[own > 0] * root(own[own > 0]), group[own > 0]) if fit else np.inf
                for own, fit in zip(left, fits, strict=True)
            ]
            i = int(np.argmin(costs))
            if not costs[i] < cost * (1.0 - _GAIN):
                break
            cost, stay = costs[i], left[i] > 0
            x, counts = more[stay], left[i][stay]
        return x, counts

    def exchanged(self, x: Array, counts: IntArray, pool: Array) -> tuple[Array, IntArray]:
        """The load cases (S, d) with repeats (S,) after moves to those of a pool (K, d)."""
        for _ in range(_SWEEPS):
            moved = False
            for i in range(len(x)):
                here, often, gained = self._moved(x, counts, i, pool)
                if gained:
                    x, counts, moved = here, often, True
            if not moved:
                break
        return x, counts

    def added(self, x: Array, counts: IntArray, pool: Array) -> Array:
        """(d,) the one of a pool (K, d) that is worth most besides load cases (S, d)."""
        far = pool[self._far(pool, x)]
        rest = self._rows(x) * root(counts)
        costs = self._costs(rest, self._groups(x), self._rows(far if len(far) else pool))
        return np.asarray((far if len(far) else pool)[int(costs.argmin())])

    def _moved(
        self, x: Array, counts: IntArray, i: int, pool: Array
    ) -> tuple[Array, IntArray, bool]:
        """All repeats of load case i, or one of them, are given for one of the pool if it pays."""
        rows, group = self._rows(x), self._groups(x)
        now = self._cost(rows * root(counts), group)
        several = counts[i] > 1 and len(x) < self._distinct
        best, found = now * (1.0 - _GAIN), (x, counts, False)
        for some in sorted({1, int(counts[i])} if several else {int(counts[i])}):
            left = counts.copy()
            left[i] -= some
            stay = left > 0
            far = pool[self._far(pool, x[stay])]
            if not len(far):
                continue
            rest = rows[stay] * root(left[stay])
            costs = self._costs(rest, group[stay], self._rows(far) * np.sqrt(some))
            k = int(costs.argmin())
            if costs[k] < best:
                best = float(costs[k])
                there = np.concatenate([x[stay], far[k : k + 1]])
                found = (there, np.append(left[stay], some), True)
        return found

    def _rows(self, x: Array) -> Array:
        """(N, r, p) rows over the noise."""
        return np.asarray(self._space.evaluate(x).blocks)

    def _groups(self, x: Array) -> IntArray:
        """(S,) which configurations go together."""
        return near_configurations(self._robot, x[:, : self._joints])

    def _far(self, pool: Array, x: Array) -> Array:
        """(K,) which of the pool are near to none of load cases (S, d)."""
        between = apart(self._robot, pool[:, : self._joints], x[:, : self._joints])
        return np.asarray(between.min(axis=1, initial=np.inf) > NEAR)

    def _total(self, rows: Array) -> Array:
        """(p, p) information of rows (S, r, p), and what is known."""
        flat = rows.reshape(-1, rows.shape[2])
        return np.asarray(self._base + flat.T @ flat)

    def _cost(self, rows: Array, group: IntArray) -> float:
        """Mean square at the test poses, dearer where compliances rest on one configuration."""
        number = np.unique(group, return_inverse=True)[1]
        covariance = scaled_inverse(self._total(rows)[None])[0]
        left = without_each(covariance, together(rows, number), self._which)
        return float(self._dear(self._mean_square(covariance), left.max(axis=0)))

    def _costs(self, rest: Array, group: IntArray, more: Array) -> Array:
        """(K,) the same of rows (S, r, p) with those of each of K load cases, (K, r, p), besides.

        These are near to none of the others.
        """
        number = np.unique(group, return_inverse=True)[1]
        own, which = together(rest, number), self._which
        covariance = scaled_inverse(self._total(rest)[None])[0]
        moved = more @ covariance
        seen = np.linalg.cholesky(np.eye(more.shape[1]) + moved @ more.transpose(0, 2, 1))
        gain = np.linalg.solve(seen, moved)  # K times (r, p): the covariance falls by its square
        square = self._mean_square(covariance) - ((gain @ self._task) ** 2).sum(axis=(1, 2))
        before = np.diagonal(covariance)[which]
        now = before - (gain[:, :, which] ** 2).sum(axis=1)
        # Without a group, by Woodbury's identity from the covariance with the load case besides.
        group_moved = own @ covariance
        inner = np.eye(own.shape[1]) * (1.0 + 1e-9) - group_moved @ own.transpose(0, 2, 1)
        cross = np.einsum("gap,kbp->kgab", own, gain)
        some = group_moved[None, :, :, which] - cross @ gain[:, None, :, which]
        inner = inner[None] + cross @ cross.swapaxes(2, 3)
        lost = now[:, None] + np.maximum((some * np.linalg.solve(inner, some)).sum(axis=2), 0.0)
        return self._dear(square, np.maximum(lost.max(axis=1), before))

    def _mean_square(self, covariance: Array) -> float:
        """Mean square at the test poses [m²]."""
        return float((self._task * (covariance @ self._task)).sum())

    def _dear(self, square: Array | float, lost: Array) -> Array:
        """(K,) mean squares, dearer by how much variances (K, k) are above their limits."""
        over = (lost / self._limits).max(axis=-1)
        return np.asarray(square * (1.0 + _DEAR * np.maximum(over - 1.0, 0.0)))
