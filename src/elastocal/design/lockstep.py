"""Many small constrained minimisations in lockstep.

B independent problems of D variables advance together, one evaluation of the whole batch per
iteration: at these sizes a loop over single problems spends its time in overhead. Bounds by
projection, other constraints by an augmented Lagrangian, curvature by dense BFGS. The penalty of
a constraint is raised only while it stays broken: raising all of them makes every problem stiff
and was measured to halve the yield, raising none misses optima in thin feasible sets.

Source: Nocedal & Wright, Numerical Optimization, ch. 6 and 17; the lockstep form is ours.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray

PENALTIES = (0.3, 1.0, 10.0)
"""First penalties, dealt out in turn: paths that differ end in different optima."""


class Step(NamedTuple):
    """Objective and constraints of a batch at one point."""

    value: Array  # (B,) objective
    margins: Array  # (B, C) feasible where >= 0
    pull: Callable[[Array], Array]  # (B, C) multipliers -> (B, D) gradient of value - Σ λ g


Stages = Sequence[tuple[int, int]]
"""(evaluations, problems to keep then), in turn."""

Problem = Callable[[Array, IntArray], Step]
"""(x (B, D), which problems (B,)) -> Step."""


class Minimum(NamedTuple):
    """Where the batch ended."""

    x: Array  # (B, D)
    value: Array  # (B,)
    violation: Array  # (B,) largest constraint violation
    origin: IntArray  # (B,) which of the starts they come from


def minimise(
    problem: Problem,
    x: Array,
    lower: Array,
    upper: Array,
    *,
    stages: Stages,
    tolerance: float = 0.0,
    reach: float = 0.5,
    penalties: Sequence[float] = PENALTIES,
) -> Minimum:
    """Minimise B problems from the starts `x`, (B, D), within bounds and margins.

    Where only the best of many starts matter, most can be given up early: each stage advances the
    batch and then keeps the problems of lowest merit.

    Args:
        problem: Objective, margins and gradients, in units in which 1 is a large change.
        x: (B, D) starts.
        lower: (D,) lower bounds.
        upper: (D,) upper bounds.
        stages: (evaluations of the batch, how many problems to keep then) in turn.
        tolerance: A problem rests once ten iterations gain less than this and no margin is
            violated by more than its root.
        reach: Longest step in one variable.
        penalties: First penalties of the constraints, dealt out to the problems in turn.
    """
    state = _State(problem, np.clip(x, lower, upper), lower, upper, reach, penalties)
    rested = state.snapshot(np.zeros(len(x), dtype=bool))
    for iterations, kept in stages:
        for iteration in range(iterations):
            if not len(state.index):
                break
            state.advance()
            if iteration % 10 == 9:
                done = state.update_multipliers(tolerance)
                if done.any():
                    rested = _joined(rested, state.snapshot(done))
                    state.keep(~done)
        room = max(kept - len(rested.origin), 0)
        if room < len(state.index):
            best = np.zeros(len(state.index), dtype=bool)
            best[np.argsort(state.merit, kind="stable")[:room]] = True
            state.keep(best)
    found = _joined(rested, state.snapshot(np.ones(len(state.index), dtype=bool)))
    order = np.argsort(found.origin)
    return Minimum(found.x[order], found.value[order], found.violation[order], found.origin[order])


def _joined(first: Minimum, second: Minimum) -> Minimum:
    return Minimum(
        np.concatenate([first.x, second.x]),
        np.concatenate([first.value, second.value]),
        np.concatenate([first.violation, second.violation]),
        np.concatenate([first.origin, second.origin]),
    )


_BATCHED = (
    "index", "x", "multipliers", "penalty", "broken", "value", "margins", "merit", "gradient",
    "inverse", "fresh", "checkpoint", "direction", "length",
)  # fmt: skip


class _State:
    """The running batch: points, multipliers, inverse Hessians, line-search steps."""

    def __init__(
        self,
        problem: Problem,
        x: Array,
        lower: Array,
        upper: Array,
        reach: float,
        penalties: Sequence[float],
    ) -> None:
        self.problem, self.lower, self.upper, self.reach = problem, lower, upper, reach
        batch, self.size = x.shape
        self.index = np.arange(batch)
        self.x = x
        step = problem(x, self.index)
        self.multipliers = np.zeros_like(step.margins)
        first = np.resize(np.array(penalties), (batch, 1))
        self.penalty = np.broadcast_to(first, step.margins.shape).copy()
        self.broken = np.maximum(0.0, -step.margins)
        self.value, self.margins = step.value, step.margins
        self.merit, self.gradient = self._merit(step)
        self.inverse = np.tile(np.eye(self.size), (batch, 1, 1))
        self.fresh = np.ones(batch, dtype=bool)
        self.checkpoint = self.value.copy()
        self.direction = np.zeros_like(x)
        self.length = np.ones(batch)
        self._aim(np.ones(batch, dtype=bool))

    def snapshot(self, mask: BoolArray) -> Minimum:
        return Minimum(self.x[mask], self.value[mask], self._violation()[mask], self.index[mask])

    def keep(self, mask: BoolArray) -> None:
        for name in _BATCHED:
            setattr(self, name, getattr(self, name)[mask])

    def advance(self) -> None:
        """One evaluation: accept where the merit falls enough, shorten the step elsewhere."""
        trial = np.clip(self.x + self.length[:, None] * self.direction, self.lower, self.upper)
        moved = trial - self.x
        step = self.problem(trial, self.index)
        merit, gradient = self._merit(step)
        slope = np.einsum("bd,bd->b", self.gradient, moved)
        with np.errstate(invalid="ignore"):
            good = merit <= self.merit + 1e-4 * slope
        # A variable held at its bound says nothing of the curvature among the others.
        self._learn(good, moved, np.where(moved == 0.0, 0.0, gradient - self.gradient))
        self.x = np.where(good[:, None], trial, self.x)
        self.gradient = np.where(good[:, None], gradient, self.gradient)
        self.margins = np.where(good[:, None], step.margins, self.margins)
        self.value = np.where(good, step.value, self.value)
        rise = np.where(np.isfinite(merit), merit - self.merit - slope, np.inf)
        self.merit = np.where(good, merit, self.merit)
        with np.errstate(divide="ignore", invalid="ignore"):
            shrink = -0.5 * slope / rise
        shrink = np.clip(np.where(np.isfinite(shrink), shrink, 0.5), 0.1, 0.5)
        stuck = ~good & (self.length < 1e-6)
        self.inverse[stuck] = np.eye(self.size)
        self.fresh |= stuck
        self.length = np.where(good | stuck, 1.0, self.length * shrink)
        self._aim(good | stuck)

    def update_multipliers(self, tolerance: float) -> BoolArray:
        """Move the multipliers; say which problems have come to rest."""
        self.multipliers = np.maximum(0.0, self.multipliers - self.penalty * self.margins)
        broken = np.maximum(0.0, -self.margins)
        stubborn = (broken > 1e-4) & (broken > 0.5 * self.broken)
        self.penalty = np.where(stubborn, np.minimum(5.0 * self.penalty, 1e4), self.penalty)
        self.broken = broken
        gain = self.checkpoint - self.value
        done = (np.abs(gain) < tolerance) & (self._violation() < np.sqrt(tolerance))
        self.checkpoint = self.value.copy()
        step = self.problem(self.x, self.index)
        self.merit, self.gradient = self._merit(step)
        self._aim(np.ones(len(self.x), dtype=bool))
        self.length[:] = 1.0
        return done

    def _merit(self, step: Step) -> tuple[Array, Array]:
        shifted = np.maximum(0.0, self.multipliers - self.penalty * step.margins)
        penalty = ((shifted**2 - self.multipliers**2) / (2.0 * self.penalty)).sum(axis=1)
        return step.value + penalty, step.pull(shifted)

    def _violation(self) -> Array:
        if not self.margins.shape[1]:
            return np.zeros(len(self.x))
        return np.maximum(0.0, -self.margins.min(axis=1))

    def _learn(self, which: BoolArray, moved: Array, change: Array) -> None:
        """BFGS update of the inverse Hessians of the problems `which`."""
        curvature = np.einsum("bd,bd->b", moved, change)
        norm = np.einsum("bd,bd->b", change, change)
        use = which & (curvature > 1e-8 * norm) & (norm > 1e-100) & np.isfinite(norm)
        first = use & self.fresh
        if first.any():
            self.inverse[first] *= (curvature[first] / norm[first])[:, None, None]
            self.fresh &= ~first
        inverse_curvature = np.where(use, 1.0 / np.where(use, curvature, 1.0), 0.0)
        bent = (self.inverse @ change[:, :, None])[:, :, 0]
        factor = (1.0 + np.einsum("bd,bd->b", change, bent) * inverse_curvature) / 2.0
        left = (factor[:, None] * moved - bent) * inverse_curvature[:, None]
        outer = left[:, :, None] * moved[:, None, :]
        self.inverse += outer
        self.inverse += outer.transpose(0, 2, 1)

    def _aim(self, which: BoolArray) -> None:
        """New search directions, in the subspace of the variables that are free to move."""
        free = ~(
            ((self.x <= self.lower) & (self.gradient > 0.0))
            | ((self.x >= self.upper) & (self.gradient < 0.0))
        )
        reduced = np.where(free, self.gradient, 0.0)
        direction = -np.where(free, (self.inverse @ reduced[:, :, None])[:, :, 0], 0.0)
        longest = np.abs(direction).max(axis=1)
        limit = np.where(self.fresh, 0.2 * self.reach, self.reach)
        scale = np.where(self.fresh | (longest > limit), limit / np.maximum(longest, 1e-300), 1.0)
        direction = direction * np.minimum(scale, 1e6)[:, None]
        self.direction = np.where(which[:, None], direction, self.direction)
