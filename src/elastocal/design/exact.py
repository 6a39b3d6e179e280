"""Exact designs: m experiments at no more than s distinct points, found by search.

The search keeps an elite of plans and breeds from it: replace a point by a random one, move a
repeat from one point to another, start afresh from the best of many random plans, or round the
continuous design. For small m replacing points of elite plans finds the best known plans most
often; for large m rounding does.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.approximate import nearly_best
from elastocal.design.continuous import MANY, ContinuousDesign
from elastocal.design.criterion import InformationFunction
from elastocal.design.refinement import TINY, Goal, Plans, refine
from elastocal.design.rounding import apportion
from elastocal.design.space import information
from elastocal.errors import InfeasibleError


@dataclass(frozen=True)
class ExactDesign:
    """Design points with integer repeats.

    Attributes:
        x: (S, d) distinct design points.
        counts: (S,) repeats, all positive.
        value: φ of base plus the sum of the informations.
        searches: Independent evolutions that were made.
        apart: Share of φ by which the best of the worst of them is below the best of all.
    """

    x: Array
    counts: IntArray
    value: float
    searches: int = 1
    apart: float = 0.0


@dataclass(frozen=True)
class Effort:
    """How long to search.

    Attributes:
        batch: Plans per generation.
        generations: Most generations.
        patience: Generations without gain after which to stop.
        islands: Independent evolutions; near-equal optima make one alone miss the best at times.
        stages: (evaluations, share kept) of the refinement inside a generation.
    """

    batch: int = 96
    generations: int = 12
    patience: int = 4
    islands: int = 2
    stages: tuple[tuple[int, float], ...] = ((30, 0.33), (40, 0.4), (60, 1.0))


def exact_design(
    goal: Goal,
    count: int,
    distinct: int,
    rng: np.random.Generator,
    *,
    continuous: ContinuousDesign | None = None,
    effort: Effort | None = None,
    progress: Callable[[float, float], None] | None = None,
) -> ExactDesign:
    """A plan of `count` experiments at no more than `distinct` points.

    Args:
        goal: What plans are worth.
        count: Number of experiments m.
        distinct: Most distinct points s ≤ m.
        rng: Source of all randomness.
        continuous: Best continuous design, to round and to know when to stop.
        effort: How long to search.
        progress: Told the share that is done, and φ of the best plan so far.
    """
    if effort is None:
        effort = _effort_for(goal.space.parameters, distinct, rounding=continuous is not None)
    smooth = goal.smooth
    if continuous is not None:
        smooth = smooth.near(continuous.total[None])
    breeder = _Breeder(smooth, count, distinct, rng, continuous)
    elites: list[Plans] = []
    for island in range(effort.islands):
        before = max((float(elite.value[0]) for elite in elites), default=0.0)

        def tell(share: float, value: float, done: int = island, best: float = before) -> None:
            if progress is not None:
                progress((done + share) / effort.islands, max(value, best))

        elites.append(_island(breeder, effort, tell))
        if breeder.cannot_improve(elites[-1].value[0]):
            break
    ends = [float(elite.value[0]) for elite in elites]
    apart = 1.0 - min(ends) / max(*ends, TINY) if len(ends) > 1 else 0.0
    elite = reduce(Plans.join, elites).best(_ELITE, apart=_APART)
    while True:
        final = refine(breeder.goal, elite.best(6), stages=((300, 6),), tolerance=1e-13)
        last = elite.join(final)
        if not last.value.max() > 0.0:
            raise InfeasibleError(
                f"no feasible plan of {count} experiments at {distinct} points was found; "
                "the constraints may leave too little room"
            )
        known, elite = breeder.goal, breeder.checked(last)
        if breeder.goal is known:
            break
    last.value = goal.values(last.x, last.counts)
    best = _tidy(_by_what_decides(goal, last.best(1)))
    return replace(best, searches=len(elites), apart=apart)


def _effort_for(parameters: int, distinct: int, *, rounding: bool) -> Effort:
    """How long to search a plan at so many distinct points for so many unknowns."""
    # With many unknowns gains come late: of ten seeds, five ended .07 % or more above the best.
    late = Effort(generations=30, patience=8) if parameters > MANY else Effort()
    # Rounding the continuous design does most of the work where there is room for its support.
    if rounding and distinct > parameters:
        return replace(late, islands=1)
    # Seven axes at four points: one search of two ends .13 % above the best, in ρ0.
    return replace(late, islands=4 if _SEVERAL <= parameters <= MANY else 2)


_SEVERAL = 6  # unknowns from which on searches end in different places


def _by_what_decides(goal: Goal, plan: Plans) -> Plans:
    """A plan refined by those alone, of very many members, that decide at it.

    The search has taken up others on its way, and what is smooth mixes them in.
    """
    whole = goal.smooth
    narrow, wider = whole, whole.near(goal.totals(plan.x, plan.counts)[0])
    while wider is not narrow:
        narrow = wider
        finer = refine(narrow, plan, stages=((300, 1),), tolerance=1e-13)
        both = plan.join(finer)
        both.value = goal.values(both.x, both.counts)
        plan = both.best(1)
        wider = narrow.near(goal.totals(finer.x, finer.counts)[0])
    return plan


def _island(
    breeder: _Breeder,
    effort: Effort,
    tell: Callable[[float, float], None],
) -> Plans:
    """The elite of one evolution from nothing."""
    elite = breeder.evolve(breeder.first(effort.batch), effort)
    idle = 0
    for generation in range(1, effort.generations):
        children = breeder.evolve(breeder.children(elite, effort.batch), effort)
        merged = breeder.checked(elite.join(children).best(_ELITE, apart=_APART))
        gain = merged.value[0] / max(elite.value[0], TINY) - 1.0
        elite, idle = merged, idle + 1 if gain < 1e-5 else 0
        tell(generation / effort.generations, float(elite.value[0]))
        if idle >= effort.patience or breeder.cannot_improve(elite.value[0]):
            break
    return elite


_ELITE = 24
_APART = 3e-5  # plans with values closer than this (relative) are taken for the same plan
_TOGETHER = 2_000_000  # numbers in information matrices of plans valued at once
_TRIES = 2  # random points of which the best replaces one of an elite plan


class _Breeder:
    """Makes plans to refine: afresh, from the continuous design, or from an elite."""

    def __init__(
        self,
        goal: Goal,
        count: int,
        distinct: int,
        rng: np.random.Generator,
        continuous: ContinuousDesign | None,
    ) -> None:
        self.goal, self.rng, self.count, self.distinct = goal, rng, count, distinct
        self.continuous, space = continuous, goal.space
        self.pool = space.sample(2000, rng)
        self.random = len(self.pool)
        if continuous is not None:
            self.pool = np.concatenate([self.pool, continuous.x])
        informations = information(space.evaluate(self.pool).blocks)
        self._flat = informations.reshape(len(self.pool), -1)
        self.rounding = (
            continuous is not None
            and isinstance(goal.criterion, InformationFunction)
            and (count > distinct or distinct > space.parameters)
        )

    def first(self, batch: int) -> Plans:
        if not self.rounding:
            return self.afresh(batch)
        return self.rounded(2 * batch // 3).join(self.afresh(batch - 2 * batch // 3))

    def children(self, elite: Plans, batch: int) -> Plans:
        quarter = batch // 4
        new = self.first(quarter)
        return new.join(self.mutated(elite, batch - quarter))

    def evolve(self, plans: Plans, effort: Effort) -> Plans:
        """Refine in stages, keeping the better share of the batch after each."""
        stages = []
        left = len(plans)
        for evaluations, share in effort.stages:
            left = max(4, int(share * left))
            stages.append((evaluations, left))
        refined = refine(self.goal, plans, stages=stages)
        return refined.best(_ELITE, apart=_APART)

    def checked(self, plans: Plans) -> Plans:
        """Plans valued by all that decides at any of them, of a criterion with very many members.

        What was missing counts from now on.
        """
        wider = self.goal.near(self.goal.totals(plans.x, plans.counts)[0])
        if wider is self.goal:
            return plans
        self.goal = wider
        return Plans(plans.x, plans.counts, wider.values(plans.x, plans.counts)).best(len(plans))

    def cannot_improve(self, value: float) -> bool:
        """Whether the certificate leaves less than 1e-5 to gain."""
        if self.continuous is None:
            return False
        return bool(value >= self.continuous.certificate.upper * self.count * (1.0 - 1e-5))

    def afresh(self, batch: int) -> Plans:
        """The best of many random plans from the pool, `batch` times.

        Of fewer with many unknowns, where looking at them costs as much as it saves.
        """
        tries = min(50, max(4, 3200 // self.goal.space.parameters**2))
        size = (batch, tries, self.distinct)
        index = self.rng.integers(0, self.random, size)
        counts = self._random_counts(batch * tries).reshape(size)
        value = np.empty((batch, tries))
        at_once = max(1, _TOGETHER // (tries * self.goal.base.size))
        for start in range(0, batch, at_once):
            part = slice(start, start + at_once)
            total = np.einsum("bts,btsk->btk", counts[part], self._flat[index[part]])
            value[part] = self._values(total)
        best = value.argmax(axis=1)
        rows = np.arange(batch)
        return Plans(self.pool[index[rows, best]], counts[rows, best])

    def rounded(self, batch: int) -> Plans:
        """Random small parts of the support with their best weights, apportioned."""
        assert self.continuous is not None
        assert isinstance(self.goal.criterion, InformationFunction)
        design = self.continuous
        x = np.empty((batch, self.distinct, design.x.shape[1]))
        counts = np.zeros((batch, self.distinct), dtype=np.int64)
        size = min(self.distinct, len(design.x))
        # The largest of chances with Gumbel's noise: drawn in turn, none of them twice.
        chance = np.log(design.weights + 1e-9) + self.rng.gumbel(size=(batch, len(design.x)))
        parts = np.argsort(-chance, axis=1)[:, :size]
        weights = nearly_best(
            self.goal.criterion, design.informations, parts, self.goal.base / self.count
        )
        for b, part in enumerate(parts):
            counts[b, :size] = apportion(weights[b], self.count)
            x[b] = design.x[part[np.arange(self.distinct) % size]]
        return Plans(x, counts)

    def mutated(self, elite: Plans, batch: int) -> Plans:
        """Elite plans with one point replaced, or a repeat moved to another point."""
        parents = self.rng.integers(0, len(elite), batch)
        x, counts = elite.x[parents].copy(), elite.counts[parents].copy()
        each = information(self.goal.space.evaluate(x.reshape(-1, x.shape[2])).blocks)
        each = each.reshape(*x.shape[:2], -1)
        replaced: list[tuple[int, int]] = []
        newcomers: list[IntArray] = []
        for b in range(batch):
            used = np.flatnonzero(counts[b])
            source = used[self.rng.integers(len(used))]
            if self.count > self.distinct and self.rng.random() < 0.5:
                target = self.rng.integers(self.distinct)
                if counts[b, target] == 0:
                    x[b, target] = x[b, source]
                counts[b, source] -= 1
                counts[b, target] += 1
            else:
                replaced.append((b, source))
                newcomers.append(self._newcomers())
        if replaced:
            who, out = np.array(replaced).T
            tries, repeats = np.array(newcomers), counts[who, out][:, None]
            rest = np.einsum("bs,bsk->bk", counts[who], each[who]) - repeats * each[who, out]
            value = self._values(rest[:, None] + repeats[:, :, None] * self._flat[tries])
            x[who, out] = self.pool[tries[np.arange(len(who)), value.argmax(axis=1)]]
        return Plans(x, counts)

    def _values(self, total: Array) -> Array:
        """(A, T) criterion of what (A, T, p²) informations add to what there is anyway."""
        base = self.goal.base
        matrices = base + total.reshape(-1, *base.shape)
        return self.goal.criterion.value(matrices).reshape(total.shape[:2])

    def _newcomers(self) -> IntArray:
        """A few points of the pool: random ones, or of the support of the continuous design."""
        support = len(self.pool) - self.random
        if support and self.rng.random() < 0.4:
            return self.random + self.rng.integers(0, support, _TRIES)
        return self.rng.integers(0, self.random, _TRIES)

    def _random_counts(self, batch: int) -> IntArray:
        counts = np.ones((batch, self.distinct), dtype=np.int64)
        extra = self.count - self.distinct
        if extra:
            share = np.full(self.distinct, 1.0 / self.distinct)
            counts += self.rng.multinomial(extra, share, size=batch)
        return counts


def _tidy(plan: Plans) -> ExactDesign:
    """Drop unused points, take equal ones together; most repeated first."""
    x: list[Array] = []
    counts: list[int] = []
    for point, count in zip(plan.x[0], plan.counts[0], strict=True):
        same = [i for i, known in enumerate(x) if np.allclose(known, point, rtol=0, atol=1e-6)]
        if count and same:
            counts[same[0]] += int(count)
        elif count:
            x.append(point)
            counts.append(int(count))
    order = np.argsort(-np.array(counts), kind="stable")
    return ExactDesign(np.array(x)[order], np.array(counts)[order], float(plan.value[0]))
