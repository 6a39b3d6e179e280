"""Refinement: batches of plans, what they are worth, and the local optima that they lead to.

In: plans: design points with repeats. Out: plans whose points were moved in lockstep under the
constraints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.design.criterion import Criterion, InformationFunction
from elastocal.design.lockstep import Stages, Trial, minimise
from elastocal.design.oracle import restore
from elastocal.design.space import DesignSpace, information

TINY = 1e-200
"""Criterion of a plan that identifies nothing."""


@dataclass(frozen=True)
class Goal:
    """What plans are worth.

    Attributes:
        space: Where experiments can be chosen from.
        criterion: What to maximise.
        base: (p, p) information there is anyway.
        readings: Of the points (B, s, d) of plans with repeats (B, s): (B, s) readings that share
            errors, those of other points among them; None: those of each point alone. Points move
            as if they shared nothing, plans are judged by this.
    """

    space: DesignSpace
    criterion: Criterion
    base: Array
    readings: Callable[[Array, IntArray], Array] | None = None

    def totals(self, x: Array, counts: IntArray) -> tuple[Array, BoolArray]:
        """(B, p, p) information of plans (B, s, d) with repeats (B, s), and which are feasible."""
        batch, s, d = x.shape
        sharing = counts if self.readings is None else self.readings(x, counts)
        evaluation = self.space.evaluate(x.reshape(-1, d), sharing.ravel().astype(float))
        each = information(evaluation.blocks).reshape(batch, s, self.space.parameters, -1)
        total = self.base + np.einsum("bs,bsij->bij", counts, each)
        feasible = (evaluation.margins >= -1e-8).reshape(batch, -1).all(axis=1)
        return total, np.asarray(feasible)

    def values(self, x: Array, counts: IntArray) -> Array:
        """(B,) criterion of plans (B, s, d) with repeats (B, s); 0 where infeasible."""
        total, feasible = self.totals(x, counts)
        return np.where(feasible, self.criterion.value(total), 0.0)

    def near(self, information: Array) -> Goal:
        """The goal with all that decides at information matrices; itself if nothing is missing."""
        criterion = self.criterion.near(information)
        return self if criterion is self.criterion else replace(self, criterion=criterion)

    @property
    def smooth(self) -> Goal:
        """The same without kinks: those stop a quasi-Newton method."""
        if not isinstance(self.criterion, InformationFunction):
            return self
        return replace(self, criterion=self.criterion.smooth)


class Plans:
    """A batch of candidate plans: points (B, s, d), counts (B, s), values (B,)."""

    def __init__(self, x: Array, counts: IntArray, value: Array | None = None) -> None:
        self.x, self.counts = x, counts
        self.value = np.zeros(len(x)) if value is None else value

    def __len__(self) -> int:
        return len(self.x)

    def take(self, index: IntArray) -> Plans:
        """The plans at `index`."""
        return Plans(self.x[index], self.counts[index], self.value[index])

    def join(self, other: Plans) -> Plans:
        """These plans, then those of `other`."""
        return Plans(
            np.concatenate([self.x, other.x]),
            np.concatenate([self.counts, other.counts]),
            np.concatenate([self.value, other.value]),
        )

    @property
    def feasible(self) -> Plans:
        """Those that break no constraint and identify what the criterion asks for."""
        return self.take(np.flatnonzero(self.value > 0.0))

    def best(self, count: int, *, apart: float = 0.0) -> Plans:
        """The best plans; values closer than `apart` (relative) count as the same plan."""
        order = np.argsort(-self.value)
        if apart:
            values = self.value[order]
            distinct = np.append(True, np.diff(values) < -apart * np.abs(values[:-1]))
            order = order[distinct]
        return self.take(order[:count])


def refine(goal: Goal, plans: Plans, *, stages: Stages, tolerance: float = 1e-10) -> Plans:
    """Move the points of plans to local optima under the constraints; keep the best plans."""
    space = goal.space
    batch, s, d = plans.x.shape
    mover = None
    if space.core is not None:
        mover = space.core.planning(plans.counts, goal.base, goal.criterion)
    found = minimise(
        _Worth(goal, plans.counts),
        plans.x.reshape(batch, -1),
        np.tile(space.lower, s),
        np.tile(space.upper, s),
        stages=stages,
        tolerance=tolerance,
        parts=lambda count: space.parts(count * s),
        mover=mover,
    )
    x = restore(space, found.x.reshape(-1, d))
    broken = np.asarray((space.evaluate(x).margins < -1e-8).any(axis=1))
    x = np.where(broken[:, None], plans.x[found.origin].reshape(-1, d), x).reshape(-1, s, d)
    counts = plans.counts[found.origin]
    return Plans(x, counts, goal.values(x, counts))


@dataclass(frozen=True)
class _Worth:
    """Minus the logarithm of what plans are worth, as a function of their points.

    Attributes:
        goal: What plans are worth.
        counts: (B, s) repeats of all plans.
    """

    goal: Goal
    counts: IntArray

    def __call__(self, x: Array, which: IntArray) -> Trial:
        """At the points (b, s·d) of the plans `which`."""
        space, counts = self.goal.space, self.counts[which]
        evaluation = space.evaluate(x.reshape(counts.size, -1), counts.ravel().astype(float))
        blocks = evaluation.blocks.reshape(len(which), -1, space.parameters)
        rows = evaluation.blocks.shape[1]
        repeats = np.repeat(counts, rows, axis=1)[:, :, None].astype(float)
        total = self.goal.base + blocks.transpose(0, 2, 1) @ (blocks * repeats)
        value, slope = self.goal.criterion.both(total)
        regular = value > TINY
        value = np.where(regular, value, TINY)
        gradient = slope * np.where(regular, -2.0 / value, 0.0)[:, None, None]
        cotangent = ((blocks @ gradient) * repeats).reshape(evaluation.blocks.shape)
        margins = evaluation.margins.reshape(len(which), -1)

        def pull(weights: Array) -> Array:
            shaped = -weights.reshape(evaluation.margins.shape)
            return evaluation.pull(cotangent, shaped).reshape(len(which), -1)

        return Trial(-np.log(value), margins, pull)
