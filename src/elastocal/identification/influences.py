"""What is left out: experiments and load cases without which a fit is made once more, in one step.

In: readings, a problem and where its fit came to rest. Out: influence of each, residuals of what
is left out and, where readings share errors, how large these are expected.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, frozen, unset
from elastocal.fitting.bounds import tangent
from elastocal.fitting.influence import Influence, influence, influence_on, reordered, shifts
from elastocal.identification.problem import Problem, Solution, free_rows
from elastocal.identification.shared_errors import connected
from elastocal.identification.uncertainty import over_noise
from elastocal.measuring.measurements import Measurements


@dataclass(frozen=True)
class LeftWithout:
    """A fit without groups of readings, one after the other.

    Attributes:
        residual: (R, 3) residuals when the group of the reading is left out [m, rad].
        covariance: (R, 3, 3) in which these are expected [m², rad²], infinite where nothing is
            known without the group; not given where `leave_one_out` finds it without more.
    """

    residual: Array
    covariance: Array


@dataclass(frozen=True)
class LeftOut:
    """A fit without its experiments, and without its load cases.

    Where readings of several experiments share an error, these are left out together: what the
    others say of one alone would be what its neighbours read.

    Attributes:
        of_experiments: Influence of each experiment on the unknowns that are sought.
        of_load_cases: Of each distinct load case.
        experiments: What is left when an experiment goes.
        load_cases: What is left when all repeats of a load case go.
    """

    of_experiments: Influence
    of_load_cases: Influence
    experiments: LeftWithout
    load_cases: LeftWithout


def left_out_of(
    data: Measurements,
    problem: Problem,
    found: Solution,
    wanted: Sequence[int],
    triangle: Array,
    variance: float,
) -> LeftOut:
    """The fit without its experiments; `wanted` are the places of the unknowns that are sought."""
    fit = _InGroups(data, problem, found, np.asarray(triangle.T @ triangle), variance)
    shared, cases = problem.shared, data.cases
    configuration, count = cases.distinct[data.case], int(cases.distinct.max()) + 1
    own, groups = data.case, len(cases)
    whole, wholes = configuration, count
    if shared is not None:
        own, groups = shared.group, int(shared.group.max()) + 1
        whole = connected([shared.group, configuration])
        wholes = int(whole.max()) + 1
    one, left = fit.without(own, groups)
    all_, gone = one, left
    if wholes == groups:  # no repeats, or none that stay: the same groups, in another order
        order = _first(own, whole, wholes)
        if shared is None:
            order = _first(np.arange(groups), cases.distinct, count)
        all_ = reordered(one, order)
    else:
        all_, gone = fit.without(whole, wholes)
    if shared is not None:
        one = reordered(one, _first(own, data.case, len(cases)))
        all_ = reordered(all_, _first(whole, configuration, count))
    if len(wanted) < problem.unknowns:
        one = influence_on(wanted, one, fit.information)
        all_ = influence_on(wanted, all_, fit.information)
    return LeftOut(one, all_, left, gone)


class _InGroups:
    """A fit whose readings go in groups."""

    def __init__(
        self,
        data: Measurements,
        problem: Problem,
        found: Solution,
        information: Array,
        variance: float,
    ) -> None:
        self.data, self.problem, self.found = data, problem, found
        self.information, self.variance = information, variance
        self.free = free_rows(problem, found)
        self.rows, self.residual = over_noise(problem, found, variance)
        self.moving = tangent(problem.bounds, found.fit.held, found.compliance)

    def without(self, group: IntArray, count: int) -> tuple[Influence, LeftWithout]:
        """Influence of `count` groups, (R,) the group of each reading, and what is left."""
        problem, u = self.problem, self.problem.unknowns
        if problem.shared is None:
            each, rows = group, self.rows.reshape(len(group), 3, -1)
            residual = self.residual.reshape(len(group), 3)
        else:
            each, rows = np.repeat(group, 3), self.rows[:, None]
            residual = self.residual[:, None]
        own = influence(rows, residual, each, count, self.information)
        shift, moving = own.shift, self.moving
        if moving.shape[1] < u:  # what is held stays there
            shift = np.zeros_like(shift)
            if moving.shape[1]:
                part = moving.T @ self.information @ moving
                shift = shifts(rows @ moving, residual, each, count, part) @ moving.T
        moved = np.einsum("rip,rp->ri", self.free, np.nan_to_num(shift)[group])
        expected = unset()
        if problem.make.size or problem.columns.size or problem.shared is not None:
            expected = self._expected(group, own)
        left = np.einsum("rij,rj->ri", problem.noise[0], self.found.residual - moved)
        return own, LeftWithout(frozen(left), expected)

    def _expected(self, group: IntArray, own: Influence) -> Array:
        """(R, 3, 3) covariance of left-out residuals: noise, own errors, and the others' fit.

        Source: the fit without group g has the information M - M_g.
        """
        problem, u = self.problem, self.problem.unknowns
        each, count = np.repeat(group, 3), len(own.leverage)
        size = 1.0 / np.sqrt(np.diagonal(self.information))
        weighed = self.rows.reshape(-1, u) * size
        order = np.argsort(each, kind="stable")
        begin = np.searchsorted(each[order], np.arange(count + 1))
        scaled = self.information * np.outer(size, size)
        without = np.empty((count, u, u))
        lost: BoolArray = np.any(own.error_ratio > _LOST, axis=1)
        for g in range(count):
            part = weighed[order[begin[g] : begin[g + 1]]]
            without[g] = np.linalg.inv(np.eye(u) if lost[g] else scaled - part.T @ part)
        spread = np.asarray(problem.noise[0] @ self.free) * size
        expected = self.variance * self.data.covariance
        expected = expected + spread @ without[group] @ spread.transpose(0, 2, 1)
        if problem.shared is not None:
            expected = expected + problem.shared.own
        expected[lost[group]] = np.inf
        return frozen(expected)


_LOST = 1e3  # growth of a standard error beyond which nothing is known without a group


def _first(group: IntArray, of: IntArray, count: int) -> IntArray:
    """(count,) group of the first reading of each number in `of`, (R,); 0 for one without any."""
    place = np.zeros(count, dtype=np.int64)
    place[of[::-1]] = group[::-1]
    return place
