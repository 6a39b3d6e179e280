"""A space of load cases as the compiled core sees it, and what the core then does.

In: `LoadCaseSpace`. Out: rows, margins and their gradients, and batches of problems that move in
the core. A constraint of a kind that it does not know is asked in Python, for a whole batch at
once; so is a criterion.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.constraints.base import Pull
from elastocal.core import layout
from elastocal.core.layout import Asked, Memory, address
from elastocal.core.library import Library, levels
from elastocal.cores import side_by_side
from elastocal.design.criterion import Criterion
from elastocal.design.lockstep import Batch
from elastocal.measuring.instrument import Isotropic, LaserTracker, positions_of
from elastocal.robot.posture import Posture
from elastocal.study.plain_space import Described, PlainSpaceOf


def compiled(library: Library, space: Described) -> CompiledSpace | None:
    """The space for the core; None if the core does not know its instrument."""
    known = type(positions_of(space.instrument)) in (Isotropic, LaserTracker)
    return CompiledSpace(library, space) if known else None


class CompiledSpace:
    """A space of load cases in the core.

    Attributes:
        foreign: The constraints that only Python knows, in order.
        foreign_columns: Their columns among the margins.
    """

    def __init__(self, library: Library, space: Described) -> None:
        self.space, self.library = space, library
        self._memory = Memory()
        told = PlainSpaceOf(space, self._memory)
        self.foreign = [space.constraints[c] for c in told.foreign]
        self.foreign_columns = np.array(told.foreign, dtype=np.int64)
        self._space = told.space
        self.variables, self.margins = len(space.lower), told.columns
        self.rows = 3 * len(space.arm.tool.targets)
        self._call = {name: library.function(name) for name in layout.SIGNATURES}
        for name, function in self._call.items():
            function.argtypes, function.restype = layout.SIGNATURES[name], layout.Int

    def __reduce__(self) -> tuple[Any, ...]:
        return _here, (self.library.level, self.space)

    def evaluate(self, x: Array, repeats: Array | None = None) -> CompiledEvaluation:
        """Rows in units of what errs, margins and gradients at design points (N, d)."""
        return CompiledEvaluation(self, x, repeats)

    def blocks(self, x: Array, repeats: Array | None = None) -> Array:
        """(N, rows, p) rows in units of what errs at design points (N, d), measured (N,) times."""
        x, found = _table(x), np.empty((len(x), self.rows, self.space.parameters))
        often = None if repeats is None else _table(repeats)
        given = address(x), None if often is None else address(often)
        self._do("evaluate", len(x), *given, address(found), None)
        return found

    def known_margins(self, x: Array) -> Array:
        """(N, C) margins; zero where only Python knows them."""
        x, found = _table(x), np.zeros((len(x), self.margins))
        self._do("evaluate", len(x), address(x), None, None, address(found))
        return found

    def holds(self, x: Array) -> BoolArray:
        """(N,) which design points hold all margins but those that only Python knows."""
        x, found = _table(x), np.empty(len(x), dtype=bool)
        self._do("feasible", len(x), address(x), address(found))
        return found

    def pull(
        self, x: Array, repeats: Array | None, block_bar: Array | None, margin_bar: Array | None
    ) -> Array:
        """(N, d) gradient of a scalar with these in rows and margins; None for zero."""
        x, found = _table(x), np.empty((len(x), self.variables))
        given = repeats, block_bar, margin_bar
        bars = [None if bar is None else _table(bar) for bar in given]
        addresses = [None if bar is None else address(bar) for bar in bars]
        self._do("pull", len(x), address(x), *addresses, address(found))
        return found

    def foreign_at(self, x: Array) -> list[tuple[Array, Pull]]:
        """Margins (N,) and pulls at design points (N, d) of the constraints only Python knows."""
        if not self.foreign:
            return []
        robot = self.space.arm.robot
        posture = Posture(robot, x[:, : len(robot.joints)])
        return [constraint.at(posture) for constraint in self.foreign]

    def restored(self, x: Array, iterations: int) -> Array | None:
        """(N, d) feasible points near x; None if there are constraints that only Python knows."""
        if self.foreign:
            return None
        moved = np.array(x, dtype=float, order="C")
        bounds = [_table(bound) for bound in (self.space.lower, self.space.upper)]
        self._do("restore", len(x), address(moved), *map(address, bounds), iterations)
        return moved

    def climbing(self, root: Array, level: float) -> Moving:
        """Moves a batch of points to where |rows V|² is large, in units of `level`."""
        return Moving(self, root=root, level=level)

    def planning(self, counts: IntArray, base: Array, criterion: Criterion) -> Moving:
        """Moves a batch of plans with repeats (B, s) to where they are worth much."""
        return Moving(self, counts=counts, base=base, criterion=criterion)

    def _do(self, name: str, *args: Any) -> None:
        failed = self._call[name](ctypes.byref(self._space), *args)
        if failed:
            raise MemoryError("the compiled core could not get the memory it needs")

    def advance(self, goal: layout.PlainGoal, batch: layout.PlainBatch, *orders: int) -> int:
        """One call of the core; not zero if it was stopped."""
        stopped: int = self._call["advance"](
            ctypes.byref(self._space), ctypes.byref(goal), ctypes.byref(batch), *orders
        )
        return stopped


def _here(level: str, space: Described) -> CompiledSpace:
    """The space in the core of this process: addresses are worth nothing in another one."""
    return CompiledSpace(levels()[level], space)


class CompiledEvaluation:
    """Rows, margins and gradients of N load cases; see `design.space.DesignEvaluation`."""

    def __init__(self, place: CompiledSpace, x: Array, repeats: Array | None) -> None:
        self._place, self._x, self._repeats = place, x, repeats

    @cached_property
    def blocks(self) -> Array:
        """(N, rows, p) rows in units of their noise."""
        return self._place.blocks(self._x, self._repeats)

    @cached_property
    def margins(self) -> Array:
        """(N, C) margins."""
        margins = self._place.known_margins(self._x)
        if self._foreign:
            margins[:, self._place.foreign_columns] = np.transpose([m for m, _ in self._foreign])
        return margins

    @cached_property
    def _foreign(self) -> list[tuple[Array, Pull]]:
        return self._place.foreign_at(self._x) if len(self._x) else []

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        """(N, d) gradient of a scalar with these gradients in `blocks` and `margins`."""
        gradient = self._place.pull(
            self._x,
            self._repeats,
            block_cotangent if block_cotangent.any() else None,
            margin_cotangent if margin_cotangent.any() else None,
        )
        if self._foreign:
            weights = margin_cotangent[:, self._place.foreign_columns]
            pulls = [pull for _, pull in self._foreign]
            gradient += foreign_pull(pulls, weights, gradient.shape[1])
        return gradient


@dataclass(frozen=True)
class Moving:
    """Moves batches of problems in the core; see `design.lockstep.Mover`."""

    place: CompiledSpace
    root: Array | None = None
    level: float = 0.0
    counts: IntArray | None = None
    base: Array | None = None
    criterion: Criterion | None = None

    def begin(self, index: IntArray, x: Array, penalty: Array) -> Batch:
        """See `Mover`."""
        row, column = np.tril_indices(x.shape[1])
        inverse = np.tile((row == column).astype(float), (len(x), 1))
        margins = self.place.margins * (x.shape[1] // self.place.variables)
        batch = Batch.at(index, x, penalty, margins=margins, inverse=inverse)
        self._move(batch, 1, 0, 0)
        return batch

    def advance(self, batch: Batch, iterations: int, *, settle: bool) -> None:
        """See `Mover`."""
        self._move(batch, 0, iterations, int(settle))

    def _move(self, batch: Batch, *orders: int) -> None:
        if not len(batch.x):
            return
        goal, answers, _ = self._goal
        asks = self.place.foreign or goal.asks_worth  # about the whole batch
        least = len(batch.x) if asks else max(1, _WORTH_A_THREAD // goal.points)
        counts = None if self.counts is None else self.counts[batch.index].astype(float)
        stopped = []

        def move(first: int, last: int) -> None:
            told = layout.PlainBatch(count=last - first)
            told.lower, told.upper = self._bounds
            if counts is not None:
                told.counts = address(counts[first:last])
            for name in _KEPT:
                setattr(told, name, address(getattr(batch, name)[first:last]))
            stopped.append(self.place.advance(goal, told, *orders))

        answers.error = None
        side_by_side(move, len(batch.x), least)
        if answers.error is not None:
            raise answers.error
        if any(stopped):
            raise MemoryError("the compiled core could not get the memory it needs")

    @cached_property
    def _bounds(self) -> tuple[int, int]:
        """Addresses of the bounds of a problem."""
        space, (goal, _, memory) = self.place.space, self._goal
        return (
            memory.reals(np.tile(space.lower, goal.points)),
            memory.reals(np.tile(space.upper, goal.points)),
        )

    @cached_property
    def _goal(self) -> tuple[layout.PlainGoal, _Answers, Memory]:
        """What the core is told of the problems, who answers it, and what keeps it alive."""
        memory, answers = Memory(), _Answers(self.place, self.criterion)
        goal = layout.PlainGoal(foreign=len(self.place.foreign), ask=layout.ASK(answers))
        if self.root is not None:
            goal.points, goal.level = 1, self.level
            goal.rank, goal.root = self.root.shape[1], memory.reals(self.root)
            return goal, answers, memory
        assert self.counts is not None
        assert self.base is not None
        assert self.criterion is not None
        goal.points, goal.base = self.counts.shape[1], memory.reals(self.base)
        losses = self.criterion.losses
        if losses is None:
            goal.asks_worth = 1
            return goal, answers, memory
        goal.criterion = layout.PlainCriterion(
            unknowns=len(self.base),
            losses=len(losses.roots),
            ranks=memory.integers([root.shape[1] for root in losses.roots]),
            roots=memory.reals(np.hstack(losses.roots)),
            sharpness=losses.sharpness,
        )
        return goal, answers, memory

    def __getstate__(self) -> dict[str, Any]:
        # Addresses are worth nothing in another process.
        return {name: value for name, value in vars(self).items() if name[0] != "_"}


_WORTH_A_THREAD = 100  # points of a batch that a thread of its own moves
_KEPT = (
    *("x", "value", "margins", "merit", "gradient", "multipliers", "penalty", "broken"),
    *("checkpoint", "inverse", "fresh", "direction", "length", "gain"),
)


class _Answers:
    """Answers what the core asks of Python, for a whole batch at once."""

    def __init__(self, place: CompiledSpace, criterion: Criterion | None) -> None:
        self.place, self.criterion = place, criterion
        self.error: BaseException | None = None
        self._pulls: list[Pull] = []

    def __call__(self, what: int, count: int, given: Any, wanted: Any) -> int:
        try:
            self._answer(what, count, given, wanted)
        except BaseException as error:  # it is raised where the core was called
            self.error = error
            return 1
        return 0

    def _answer(self, what: int, count: int, given: Any, wanted: Any) -> None:
        place = self.place
        foreign, d = len(place.foreign), place.variables
        if what == Asked.MARGINS:
            found = place.foreign_at(_seen(given, (count, d)).copy())
            _seen(wanted, (count, foreign))[:] = np.transpose([margin for margin, _ in found])
            self._pulls = [pull for _, pull in found]
        elif what == Asked.PULL:
            weights, gradient = _seen(given, (count, foreign)), _seen(wanted, (count, d))
            gradient[:] = foreign_pull(self._pulls, weights, d)
        else:
            assert self.criterion is not None
            p = place.space.parameters
            value, slope = self.criterion.both(_seen(given, (count, p, p)).copy())
            answer = _seen(wanted, (count * (1 + p * p),))
            answer[:count], answer[count:] = value, slope.ravel()


def foreign_pull(pulls: Sequence[Pull], weights: Array, d: int) -> Array:
    """(N, d) gradient of margins that only Python knows, times weights (N, F)."""
    gradient = np.zeros((len(weights), d))
    for pull, weight in zip(pulls, weights.T, strict=True):
        if weight.any():
            slope = pull(np.ascontiguousarray(weight)).T
            gradient[:, : slope.shape[1]] += slope
    return gradient


def _seen(address: Any, shape: tuple[int, ...]) -> Array:
    return np.ctypeslib.as_array(address, shape)


def _table(values: Array) -> Array:
    return np.ascontiguousarray(values, dtype=float)
