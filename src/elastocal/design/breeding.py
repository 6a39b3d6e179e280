"""Plans bred from plans: an elite, and how its children are made.

Made afresh: the best of many random plans. Rounded: small parts of the continuous design. Mutated:
an elite plan with one point replaced, or a repeat moved to another point.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.approximate import nearly_best
from elastocal.design.continuous import ContinuousDesign
from elastocal.design.criterion import InformationFunction
from elastocal.design.refinement import Goal, Plans, refine
from elastocal.design.rounding import apportion
from elastocal.design.space import information

ELITE = 24
"""Plans that are kept."""
APART = 3e-5
"""Plans with values closer than this (relative) are taken for the same plan."""
_TOGETHER = 2_000_000  # numbers in information matrices of plans valued at once
_TRIES = 2  # random points of which the best replaces one of an elite plan


class Breeder:
    """Makes plans to refine: afresh, from the continuous design, or from an elite.

    Attributes:
        goal: What plans are worth; of very many members those that decide, more as it goes on.
    """

    def __init__(
        self,
        goal: Goal,
        count: int,
        distinct: int,
        rng: np.random.Generator,
        continuous: ContinuousDesign | None,
    ) -> None:
        """As of a search."""
        self.rng, self.count, self.distinct = rng, count, distinct
        self.continuous = continuous
        self.goal = goal if continuous is None else goal.near(continuous.total[None])
        self.rounding = (
            continuous is not None
            and isinstance(goal.criterion, InformationFunction)
            and (count > distinct or distinct > goal.space.parameters)
        )

    def draw(self, x: Array) -> None:
        """Points to make plans of: random ones (N, d), and those of the continuous design."""
        self.random, self.pool = len(x), x
        if self.continuous is not None:
            self.pool = np.concatenate([x, self.continuous.x])
        informations = information(self.goal.space.evaluate(self.pool).blocks)
        self.flat = informations.reshape(len(self.pool), -1)

    def first(self, batch: int) -> Plans:
        """Plans from nothing: rounded, where that helps, and made afresh."""
        if not self.rounding:
            return self.afresh(batch)
        return self.rounded(2 * batch // 3).join(self.afresh(batch - 2 * batch // 3))

    def children(self, elite: Plans, batch: int) -> Plans:
        """Plans from an elite, and a quarter from nothing."""
        quarter = batch // 4
        new = self.first(quarter)
        return new.join(self.mutated(elite, batch - quarter))

    def evolve(self, plans: Plans, shares: Sequence[tuple[int, float]]) -> Plans:
        """Refine in stages, keeping the better share of the batch after each."""
        stages = []
        left = len(plans)
        for evaluations, share in shares:
            left = max(4, int(share * left))
            stages.append((evaluations, left))
        refined = refine(self.goal, plans, stages=stages)
        return refined.best(ELITE, apart=APART)

    def checked(self, plans: Plans) -> Plans:
        """Plans valued by all that decides at any of them, of a criterion with very many members.

        What was missing counts from now on.
        """
        wider = self.goal.near(self.goal.totals(plans.x, plans.counts)[0])
        if wider is self.goal:
            return plans
        self.goal = wider
        return self.valued(plans)

    def valued(self, plans: Plans) -> Plans:
        """Plans from elsewhere by the goal of this search, the best first."""
        value = self.goal.values(plans.x, plans.counts)
        return Plans(plans.x, plans.counts, value).best(len(plans))

    def cannot_improve(self, value: float) -> bool:
        """Whether the certificate leaves less than 1e-5 to gain."""
        if self.continuous is None:
            return False
        return bool(value >= self.continuous.certificate.upper * self.count * (1.0 - 1e-5))

    def afresh(self, batch: int) -> Plans:
        """The best of many random plans from the pool, `batch` times.

        Of fewer with many unknowns, where looking at them costs as much as it saves.
        """
        tries = min(50, max(4, 16_200 // self.goal.space.parameters**2))
        size = (batch, tries, self.distinct)
        index = self.rng.integers(0, self.random, size)
        counts = self._random_counts(batch * tries).reshape(size)
        value = np.empty((batch, tries))
        at_once = max(1, _TOGETHER // (tries * self.goal.base.size))
        for start in range(0, batch, at_once):
            part = slice(start, start + at_once)
            total = np.einsum("bts,btsk->btk", counts[part], self.flat[index[part]])
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
        often = counts.ravel().astype(float)
        each = information(self.goal.space.evaluate(x.reshape(-1, x.shape[2]), often).blocks)
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
            value = self._values(rest[:, None] + repeats[:, :, None] * self.flat[tries])
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
