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
from dataclasses import dataclass, fields
from functools import partial
from typing import NamedTuple, Protocol

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.cores import dealt
from elastocal.stopping import stop_if_asked

PENALTIES = (0.3, 1.0, 10.0)
"""First penalties, dealt out in turn: paths that differ end in different optima."""
_REACH = 0.5  # longest step in one variable


class Trial(NamedTuple):
    """Objective and constraints of a batch at one point."""

    value: Array  # (B,) objective
    margins: Array  # (B, C) feasible where >= 0
    pull: Callable[[Array], Array]  # (B, C) multipliers -> (B, D) gradient of value - Σ λ g


Stages = Sequence[tuple[int, int]]
"""(evaluations, problems to keep then), in turn."""

Problem = Callable[[Array, IntArray], Trial]
"""(x (B, D), which problems (B,)) -> Trial."""


class Mover(Protocol):
    """Moves a batch of problems within bounds: NumPy here, or compiled code that does the same."""

    def begin(self, index: IntArray, x: Array, penalty: Array) -> Batch:
        """The batch of the problems `index` at x, (B, D), with first penalties (B,)."""

    def advance(self, batch: Batch, iterations: int, *, settle: bool) -> None:
        """So many evaluations; then move the multipliers if they are to be settled."""


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
    penalties: Sequence[float] = PENALTIES,
    parts: Callable[[int], int] = lambda count: 1,
    mover: Mover | None = None,
) -> Minimum:
    """Minimise B problems from the starts `x`, (B, D), within bounds and margins.

    Where only the best of many starts matter, most can be given up early: each stage advances the
    batch and then goes on with those problems that are among so many of lowest merit, those at rest
    counted: what rests at once because it is flat there must not keep better ones out.

    Args:
        problem: Objective, margins and gradients, in units in which 1 is a large change.
        x: (B, D) starts.
        lower: (D,) lower bounds.
        upper: (D,) upper bounds.
        stages: (evaluations of the batch, how many problems to keep then) in turn.
        tolerance: A problem rests once ten iterations gain less than this and no margin is
            violated by more than its root.
        penalties: First penalties of the constraints, dealt out to the problems in turn.
        parts: Into how many parts a batch of so many problems is divided for several cores.
        mover: What moves the batch of these problems, if not NumPy.
    """
    mover = _Search(problem, lower, upper) if mover is None else mover
    x, first = np.clip(x, lower, upper), np.resize(np.array(penalties), len(x))
    starts = [
        (index, x[index], first[index])
        for index in np.array_split(np.arange(len(x)), parts(len(x)))
    ]
    running = _together(list(dealt(partial(_begun, mover), starts)))
    rested = running.only(np.zeros(len(x), dtype=bool)).minimum
    for iterations, kept in stages:
        stop_if_asked()
        divided = running.divided(parts(len(running.index)))
        advanced = partial(_advanced, mover, iterations, tolerance)
        ended = list(dealt(advanced, divided))
        running = _together([batch for batch, _ in ended])
        rested = _joined(rested, *(rest for _, rest in ended))
        best = np.zeros(len(rested.origin) + len(running.index), dtype=bool)
        best[np.argsort(np.append(rested.value, running.merit), kind="stable")[:kept]] = True
        running = running.only(best[len(rested.origin) :])
    found = _joined(rested, running.minimum)
    order = np.argsort(found.origin)
    return Minimum(found.x[order], found.value[order], found.violation[order], found.origin[order])


def _joined(*minima: Minimum) -> Minimum:
    x, value, violation, origin = (np.concatenate(one) for one in zip(*minima, strict=True))
    return Minimum(x, value, violation, origin)


@dataclass
class Batch:
    """The problems that are still running: every array has one row for each of them.

    Attributes:
        index: (B,) which of the starts it comes from.
        x: (B, D) where it is.
        value: (B,) objective at x.
        margins: (B, C) constraints at x.
        merit: (B,) augmented Lagrangian at x.
        gradient: (B, D) of the merit.
        multipliers: (B, C).
        penalty: (B, C).
        broken: (B, C) violations when the multipliers last moved.
        checkpoint: (B,) objective when the multipliers last moved ...
        gain: (B,) ... and how much it had fallen since the time before.
        inverse: (B, …) inverse Hessian of the merit, as the mover keeps it.
        fresh: (B,) whether that is the first guess still.
        direction: (B, D) where to go.
        length: (B,) how far, as a share of `direction`.
    """

    index: IntArray
    x: Array
    value: Array
    margins: Array
    merit: Array
    gradient: Array
    multipliers: Array
    penalty: Array
    broken: Array
    checkpoint: Array
    gain: Array
    inverse: Array
    fresh: BoolArray
    direction: Array
    length: Array

    @classmethod
    def at(
        cls, index: IntArray, x: Array, penalty: Array, *, margins: int, inverse: Array
    ) -> Batch:
        """Problems at x, (B, D), of which nothing else is known yet."""
        count, size = x.shape
        return cls(
            index=index,
            x=np.array(x, order="C"),
            penalty=np.repeat(penalty[:, None], margins, axis=1),
            inverse=inverse,
            fresh=np.ones(count, dtype=bool),
            length=np.ones(count),
            **{name: np.zeros(count) for name in ("value", "merit", "checkpoint", "gain")},
            **{name: np.zeros((count, size)) for name in ("gradient", "direction")},
            **{name: np.zeros((count, margins)) for name in ("margins", "multipliers", "broken")},
        )

    def only(self, mask: BoolArray) -> Batch:
        """The problems of `mask` alone."""
        return Batch(*(getattr(self, field.name)[mask] for field in fields(self)))

    def divided(self, parts: int) -> list[Batch]:
        """The problems in so many parts, in order."""
        if parts == 1:
            return [self]
        arrays = (np.array_split(getattr(self, field.name), parts) for field in fields(self))
        return [Batch(*part) for part in zip(*arrays, strict=True)]

    @property
    def violation(self) -> Array:
        """(B,) largest constraint violation."""
        if not self.margins.shape[1]:
            return np.zeros(len(self.x))
        return np.maximum(0.0, -self.margins.min(axis=1))

    @property
    def minimum(self) -> Minimum:
        """Where it is now."""
        return Minimum(self.x, self.value, self.violation, self.index)


def _together(parts: Sequence[Batch]) -> Batch:
    """Parts of a batch as one again."""
    if len(parts) == 1:
        return parts[0]
    names = [field.name for field in fields(Batch)]
    return Batch(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _begun(mover: Mover, start: tuple[IntArray, Array, Array]) -> Batch:
    """A batch at its starts: their numbers, places (B, D) and first penalties (B,)."""
    return mover.begin(*start)


def _advanced(
    mover: Mover, iterations: int, tolerance: float, batch: Batch
) -> tuple[Batch, Minimum]:
    """A batch after so many evaluations, and the problems of it that have come to rest."""
    rested = batch.only(np.zeros(len(batch.index), dtype=bool)).minimum
    for done in range(0, iterations, _SETTLED):
        if not len(batch.index):
            break
        stop_if_asked()
        settle = done + _SETTLED <= iterations
        mover.advance(batch, min(_SETTLED, iterations - done), settle=settle)
        if settle:
            still = (np.abs(batch.gain) < tolerance) & (batch.violation < np.sqrt(tolerance))
            if still.any():
                rested = _joined(rested, batch.only(still).minimum)
                batch = batch.only(~still)
    return batch, rested


_SETTLED = 10  # evaluations after which multipliers move


class _Search:
    """Moves a batch of problems within bounds."""

    def __init__(self, problem: Problem, lower: Array, upper: Array) -> None:
        self.problem, self.lower, self.upper = problem, lower, upper

    def begin(self, index: IntArray, x: Array, penalty: Array) -> Batch:
        """See `Mover`."""
        step = self.problem(x, index)
        inverse = np.tile(np.eye(x.shape[1]), (len(x), 1, 1))
        margins = step.margins.shape[1]
        batch = Batch.at(index, x, penalty, margins=margins, inverse=inverse)
        batch.value, batch.checkpoint = step.value.copy(), step.value.copy()
        batch.margins, batch.broken = step.margins, np.maximum(0.0, -step.margins)
        self._restart(batch, step)
        return batch

    def advance(self, batch: Batch, iterations: int, *, settle: bool) -> None:
        """See `Mover`."""
        for _ in range(iterations):
            self._step(batch)
        if settle:
            self._settle(batch)

    def _step(self, now: Batch) -> None:
        """One evaluation: accept where the merit falls enough, shorten the step elsewhere."""
        trial = np.clip(now.x + now.length[:, None] * now.direction, self.lower, self.upper)
        moved = trial - now.x
        step = self.problem(trial, now.index)
        merit, gradient = _merit(step, now.multipliers, now.penalty)
        slope = np.einsum("bd,bd->b", now.gradient, moved)
        with np.errstate(invalid="ignore"):
            good = merit <= now.merit + 1e-4 * slope
        # A variable held at its bound says nothing of the curvature among the others.
        self._learn(now, good, moved, np.where(moved == 0.0, 0.0, gradient - now.gradient))
        now.x = np.where(good[:, None], trial, now.x)
        now.gradient = np.where(good[:, None], gradient, now.gradient)
        now.margins = np.where(good[:, None], step.margins, now.margins)
        now.value = np.where(good, step.value, now.value)
        rise = np.where(np.isfinite(merit), merit - now.merit - slope, np.inf)
        now.merit = np.where(good, merit, now.merit)
        with np.errstate(divide="ignore", invalid="ignore"):
            shrink = -0.5 * slope / rise
        shrink = np.clip(np.where(np.isfinite(shrink), shrink, 0.5), 0.1, 0.5)
        stuck = ~good & (now.length < 1e-6)
        now.inverse[stuck] = np.eye(now.x.shape[1])
        now.fresh |= stuck
        now.length = np.where(good | stuck, 1.0, now.length * shrink)
        self._aim(now, good | stuck)

    def _settle(self, now: Batch) -> None:
        """Move the multipliers; penalties rise where a margin stays broken."""
        now.multipliers = np.maximum(0.0, now.multipliers - now.penalty * now.margins)
        broken = np.maximum(0.0, -now.margins)
        stubborn = (broken > 1e-4) & (broken > 0.5 * now.broken)
        now.penalty = np.where(stubborn, np.minimum(5.0 * now.penalty, 1e4), now.penalty)
        now.broken = broken
        now.gain = now.checkpoint - now.value
        now.checkpoint = now.value.copy()
        self._restart(now, self.problem(now.x, now.index))

    def _restart(self, now: Batch, step: Trial) -> None:
        """From where it is, with multipliers and penalties as they are."""
        now.merit, now.gradient = _merit(step, now.multipliers, now.penalty)
        self._aim(now, np.ones(len(now.x), dtype=bool))
        now.length = np.ones(len(now.x))

    def _learn(self, now: Batch, which: BoolArray, moved: Array, change: Array) -> None:
        """BFGS update of the inverse Hessians of the problems `which`."""
        curvature = np.einsum("bd,bd->b", moved, change)
        norm = np.einsum("bd,bd->b", change, change)
        use = which & (curvature > 1e-8 * norm) & (norm > 1e-100) & np.isfinite(norm)
        first = use & now.fresh
        if first.any():
            now.inverse[first] *= (curvature[first] / norm[first])[:, None, None]
            now.fresh &= ~first
        inverse_curvature = np.where(use, 1.0 / np.where(use, curvature, 1.0), 0.0)
        bent = (now.inverse @ change[:, :, None])[:, :, 0]
        factor = (1.0 + np.einsum("bd,bd->b", change, bent) * inverse_curvature) / 2.0
        left = (factor[:, None] * moved - bent) * inverse_curvature[:, None]
        outer = left[:, :, None] * moved[:, None, :]
        now.inverse += outer
        now.inverse += outer.transpose(0, 2, 1)

    def _aim(self, now: Batch, which: BoolArray) -> None:
        """New search directions, in the subspace of the variables that are free to move."""
        free = ~(
            ((now.x <= self.lower) & (now.gradient > 0.0))
            | ((now.x >= self.upper) & (now.gradient < 0.0))
        )
        reduced = np.where(free, now.gradient, 0.0)
        direction = -np.where(free, (now.inverse @ reduced[:, :, None])[:, :, 0], 0.0)
        longest = np.abs(direction).max(axis=1)
        limit = np.where(now.fresh, 0.2 * _REACH, _REACH)
        scale = np.where(now.fresh | (longest > limit), limit / np.maximum(longest, 1e-300), 1.0)
        direction = direction * np.minimum(scale, 1e6)[:, None]
        now.direction = np.where(which[:, None], direction, now.direction)


def _merit(step: Trial, multipliers: Array, penalty: Array) -> tuple[Array, Array]:
    """(B,) augmented Lagrangian and its gradient (B, D)."""
    shifted = np.maximum(0.0, multipliers - penalty * step.margins)
    terms = ((shifted**2 - multipliers**2) / (2.0 * penalty)).sum(axis=1)
    return step.value + terms, step.pull(shifted)
