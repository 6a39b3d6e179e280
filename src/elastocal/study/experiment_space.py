"""The design space of calibration experiments: which load cases there are to choose from.

This is where the robot meets the optimal-design core: a design point is a configuration and, if
the load is free, the direction of the force and of the moment.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.constraints import Constraint, margins_at
from elastocal.core.library import library as core_library
from elastocal.design.oracle import restore
from elastocal.design.space import DesignEvaluation, information
from elastocal.elastic.absorbed import KnownErrors
from elastocal.elastic.allowed_loads import FreeDirection, Load, ThereOrNot
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.unknowns import Unknowns, each_spring
from elastocal.errors import Doubt, InfeasibleError
from elastocal.measuring.instrument import Instrument
from elastocal.robot.posture import Posture
from elastocal.stopping import stop_if_asked
from elastocal.study.compiled import CompiledSpace, compiled
from elastocal.study.load_case_rows import LoadCaseRows
from elastocal.wording import worded

_CHUNK = 2048  # load cases evaluated at once: what stays in the cache


_PART = 96  # load cases that make a part for one of several cores; fewer cost more than they save
_PARTS = 4  # most parts


@dataclass(frozen=True)
class LoadCaseSpace:
    """Load cases under joint limits, constraints and a bound on the wrench.

    Attributes:
        arm: The robot with the c springs that bend, load point and measured markers.
        force: Which forces may act [N].
        moment: Which moments may act [N·m].
        constraints: Constraints besides the joint limits.
        instrument: What measures the deflections of the markers.
        limits: (2, n) lower and upper joint values used for planning [rad or m].
        makers: The unknowns that make the springs; None: each spring is an unknown.
        errors: What errs besides the instrument; None: nothing. Unknowns that turn all loads
            together come behind those that make springs.
    """

    arm: ElasticArm
    force: Load
    moment: Load
    constraints: Sequence[Constraint]
    instrument: Instrument
    limits: Array
    makers: Unknowns | None = None
    errors: KnownErrors | None = None

    @cached_property
    def unknowns(self) -> Unknowns:
        """The unknowns that make springs."""
        return each_spring(self.arm.springs) if self.makers is None else self.makers

    @property
    def parameters(self) -> int:
        """Number p of unknowns."""
        return len(self.unknowns) + (0 if self.errors is None else self.errors.turns)

    def measured_together(self, repeats: float) -> LoadCaseSpace:
        """The space whose load cases are measured so often, where nobody says how often."""
        if self.errors is None or self.errors.together == repeats:
            return self
        return replace(self, errors=self.errors.of(repeats))

    @cached_property
    def lower(self) -> Array:
        """(d,) lower bounds: joint limits, then -2 for each direction variable, 0 for shares."""
        return np.concatenate([self.limits[0], *(self._ends(load)[0] for load in self._loads)])

    @cached_property
    def upper(self) -> Array:
        """(d,) upper bounds."""
        return np.concatenate([self.limits[1], *(self._ends(load)[1] for load in self._loads)])

    @property
    def _loads(self) -> tuple[Load, Load]:
        return self.force, self.moment

    def _ends(self, load: Load) -> tuple[Array, Array]:
        """Bounds of the design variables of a load."""
        least, most = (0.0, 1.0) if isinstance(load, ThereOrNot) else (-2.0, 2.0)
        return np.full(load.variables, least), np.full(load.variables, most)

    @cached_property
    def core(self) -> CompiledSpace | None:
        """The same in compiled code, where there is any that knows loads and instrument."""
        if any(self.arm.springs.by):  # the core knows no compensators
            return None
        library = core_library()
        return None if library is None else compiled(library, self)

    def __getstate__(self) -> dict[str, Any]:
        # What is compiled has addresses in it: each process makes its own.
        return {name: value for name, value in vars(self).items() if name != "core"}

    @property
    def _free(self) -> int:
        return self.force.variables + self.moment.variables

    def evaluate(self, x: Array, repeats: Array | None = None) -> DesignEvaluation:
        """Rows in units of what errs, margins and gradients at design points (N, d).

        The rows are those of one of (N,) repeats, which may share errors.
        """
        if self.errors is None:
            repeats = None
        if self.core is None:
            return LoadCaseEvaluation(self, x, repeats)
        return self.core.evaluate(x, repeats)

    def parts(self, count: int) -> int:
        """Into how many parts to divide load cases for several cores; 1 where one is fast."""
        asked = self.constraints if self.core is None else self.core.foreign
        if not any(constraint.one_by_one for constraint in asked):
            return 1
        return min(max(count // _PART, 1), _PARTS)

    def load_cases(self, x: Array) -> LoadCases:
        """Load cases at design points (N, d)."""
        return LoadCases(x[:, : len(self.arm.robot.joints)], self._wrench(x).T)

    def information(self, cases: LoadCases) -> Array:
        """(N, p, p) information of load cases, each measured once [(N·m/rad)²]."""
        return information(self._rows(cases.q, cases.wrench).blocks)

    def _rows(self, q: Array, wrench: Array, repeats: Array | None = None) -> LoadCaseRows:
        made = self.arm, self.instrument, self.unknowns, self.errors
        return LoadCaseRows(*made, LoadCases(q, wrench), repeats)

    def points(self, cases: LoadCases) -> Array:
        """(N, d) design points of load cases whose free loads have the largest norm."""
        force, moment = cases.wrench[:, :3], cases.wrench[:, 3:]
        return np.hstack([cases.q, self.force.design(force), self.moment.design(moment)])

    def canonical(self, x: Array) -> Array:
        """The same design points with direction variables of norm 1."""
        x, start = x.copy(), len(self.arm.robot.joints)
        for load in self._loads:
            end = start + load.variables
            if load.variables and not isinstance(load, ThereOrNot):
                x[:, start:end] /= np.linalg.norm(x[:, start:end], axis=1, keepdims=True)
            start = end
        return x

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        """(count, d) distinct random feasible points: uniform in the ranges, then rejection.

        Where nearly all are rejected, random points are moved to the nearest feasible ones. Fewer
        points come where no more are found in bounded time, one where everything is held.

        Raises:
            InfeasibleError: none is found even so; names the constraint in the way.
        """
        count = count if (self.lower < self.upper).any() else min(count, 1)
        found: list[Array] = []
        total = tried = 0
        while total < count and not (tried >= _ENOUGH_TRIED and total < _THIN * tried):
            stop_if_asked()
            share = (total + 1) / (tried + 1) if tried else 0.25  # of them feasible
            drawn = int(np.clip((count - total) / share, 256, 20000))
            x = self._draw(drawn, rng)
            x = x[self.feasible(x)]
            found.append(x)
            total, tried = total + len(x), tried + drawn
        if total < count:
            found.append(self._sample_thin(count - total, rng))
        if not any(map(len, found)) and count:
            self._raise_infeasible(restore(self, self._draw(1000, rng)))
        return np.concatenate(found)[:count]

    def _sample_thin(self, count: int, rng: np.random.Generator) -> Array:
        """At most (count, d) points of a thin feasible set: random ones restored, then stirred."""
        pool = np.zeros((0, len(self.lower)))
        for _ in range(_RESTORED):
            restored = restore(self, self._draw(max(2 * (count - len(pool)), 1000), rng))
            pool = _distinct(np.concatenate([pool, restored[self.feasible(restored)]]))
            if len(pool) >= count:
                break
        pool = pool[:count]
        half = pool[::2]
        for share in (0.1, 0.03, 0.01):  # from the borders inward, at several scales
            step = share * (self.upper - self.lower) * rng.normal(size=half.shape)
            moved = np.clip(half + step, self.lower, self.upper)
            inside = self.feasible(moved)
            half[inside] = moved[inside]
        return pool

    def _draw(self, count: int, rng: np.random.Generator) -> Array:
        """(count, d) points uniform in the joint ranges and in the allowed directions."""
        x = np.empty((count, len(self.lower)))
        start = len(self.arm.robot.joints)
        x[:, :start] = rng.uniform(self.limits[0], self.limits[1], (count, start))
        for load in self._loads:
            end = start + load.variables
            x[:, start:end] = load.sample(count, rng).T
            start = end
        return x

    def _raise_infeasible(self, x: Array) -> None:
        """Name the constraint that is in the way at the best of the points `x`."""
        margins = self._configuration_margins(x)
        best = int(margins.min(axis=1).argmax())
        worst = int(margins[best].argmin())
        constraint = self.constraints[worst]
        posture = Posture(self.arm.robot, x[best : best + 1, : len(self.arm.robot.joints)])
        name = constraint.names_at(posture)[0]
        depth = {"by": -float(margins[best, worst])}
        doubt = Doubt("no-configuration", (name,), (), depth, constraint.unit)
        raise InfeasibleError(worded(doubt)).with_doubts(doubt)

    def feasible(self, x: Array) -> BoolArray:
        """(N,) which design points (N, d) hold all constraints and have an allowed load.

        The costly constraints are asked last.
        """
        n = len(self.arm.robot.joints)
        allowed, unasked = np.ones(len(x), dtype=bool), self.constraints
        if self.core is not None:
            allowed = self.core.holds(x)
            unasked = self.core.foreign
        else:
            for _, room, _ in self._cones(x):
                allowed &= room >= 0.0
        left = np.flatnonzero(allowed)
        for costly in (False, True):
            asked = [c for c in unasked if c.costly == costly]
            if not asked:
                continue
            kept = []
            for start in range(0, len(left), _CHUNK):
                part = left[start : start + _CHUNK]
                room = margins_at(asked, Posture(self.arm.robot, x[part, :n]))
                kept.append(part[(room >= 0.0).all(axis=0)])
            left = np.concatenate(kept) if kept else left
        feasible = np.zeros(len(x), dtype=bool)
        feasible[left] = True
        return feasible

    def _cones(self, x: Array) -> Iterator[tuple[int, Array, Array]]:
        """Each cone of directions: first of its three variables, margin (N,), gradient (3, N)."""
        start = len(self.arm.robot.joints)
        for load in self._loads:
            if isinstance(load, FreeDirection) and load.is_cone:
                yield start, *load.cone(x.T[start : start + 3])
            start += load.variables

    def _configuration_margins(self, x: Array) -> Array:
        n = len(self.arm.robot.joints)
        chunks = []
        for start in range(0, len(x), _CHUNK):
            posture = Posture(self.arm.robot, x[start : start + _CHUNK, :n])
            chunks.append(margins_at(self.constraints, posture).T)
        return np.concatenate(chunks)

    def _wrench(self, x: Array) -> Array:
        """(6, N) wrenches of design points (N, d)."""
        n, k = len(self.arm.robot.joints), self.force.variables
        return np.concatenate([self.force.decode(x.T[n : n + k]), self.moment.decode(x.T[n + k :])])


_ENOUGH_TRIED = 100_000  # random points before rejection is given up ...
_THIN = 0.003  # ... if fewer than this share are feasible
_RESTORED = 20  # rounds of restoring random points, of twice what is missing each
_SAME = 1e-9  # design points closer than this in every variable are one [rad, m]


def _distinct(x: Array) -> Array:
    """The design points (N, d) without copies, in their order."""
    _, first = np.unique(np.round(x / _SAME), axis=0, return_index=True)
    return x[np.sort(first)]


class LoadCaseEvaluation:
    """Rows, margins and gradients of N load cases; see `design.space.DesignEvaluation`."""

    def __init__(self, space: LoadCaseSpace, x: Array, repeats: Array | None = None) -> None:
        self._space, self._x = space, x
        self._parts = []
        for start in range(0, max(len(x), 1), _CHUNK):
            own = slice(start, start + _CHUNK)
            part = _Part(space, x[own], None if repeats is None else repeats[own])
            self._parts.append(part)
        self.blocks = _joined([part.blocks for part in self._parts])
        self.margins = _joined([part.margins for part in self._parts])

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        """(N, d) gradient of a scalar with these gradients in `blocks` and `margins`."""
        pulled = []
        for i, part in enumerate(self._parts):
            chosen = slice(i * _CHUNK, (i + 1) * _CHUNK)
            pulled.append(part.pull(block_cotangent[chosen], margin_cotangent[chosen]))
        return _joined(pulled)


def _joined(arrays: list[Array]) -> Array:
    return arrays[0] if len(arrays) == 1 else np.concatenate(arrays)


class _Part:
    """One chunk of an evaluation."""

    def __init__(self, space: LoadCaseSpace, x: Array, repeats: Array | None) -> None:
        self.space, self.x = space, x
        n = len(space.arm.robot.joints)
        self.rows = space._rows(x[:, :n], space._wrench(x).T, repeats)
        self.blocks = self.rows.blocks
        results = [constraint.at(self.rows.posture) for constraint in space.constraints]
        margins = [margin for margin, _ in results]
        self.pulls = [pull for _, pull in results]
        self.cones = []
        for start, margin, gradient in space._cones(x):
            margins.append(margin)
            self.cones.append((start, gradient))
        self.margins = np.array(margins).reshape(len(margins), len(x)).T

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        n, k = len(self.space.arm.robot.joints), self.space.force.variables
        q_bar, wrench_bar = self.rows.pull(block_cotangent)
        constraint_bar, cone_bar = np.split(margin_cotangent.T, [len(self.pulls)])
        for pull, weight in zip(self.pulls, constraint_bar, strict=True):
            if weight.any():
                q_bar += pull(weight)
        x = self.x.T
        if not self.space._free:
            return q_bar.T
        gradient = np.concatenate(
            [
                q_bar,
                self.space.force.pull(x[n : n + k], wrench_bar[:3]),
                self.space.moment.pull(x[n + k :], wrench_bar[3:]),
            ]
        )
        for (start, slope), weight in zip(self.cones, cone_bar, strict=True):
            gradient[start : start + 3] += slope * weight
        return gradient.T
