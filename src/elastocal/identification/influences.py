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
from elastocal.fitting.influence import Influence, influence, influence_on, reordered
from elastocal.identification.problem import Problem, Solution, free_rows
from elastocal.identification.uncertainty import over_noise
from elastocal.measuring.measurements import Measurements


@dataclass(frozen=True)
class LeftOut:
    """A fit without its experiments, one after the other.

    Where readings of several experiments share an error, these are left out together: what the
    others say of one alone would be what its neighbours read.

    Attributes:
        of_experiments: Influence of each experiment on the unknowns that are sought.
        of_load_cases: Of each distinct load case.
        residual: (R, 3) residuals over the noise when the experiment is left out.
        covariance: (R, 3, 3) in which these are expected [m², rad²], infinite where nothing is
            known without the experiment; not given where `leave_one_out` finds it without more.
    """

    of_experiments: Influence
    of_load_cases: Influence
    residual: Array
    covariance: Array


def left_out_of(
    data: Measurements,
    problem: Problem,
    found: Solution,
    wanted: Sequence[int],
    triangle: Array,
    variance: float,
) -> LeftOut:
    """The fit without its experiments; `wanted` are the places of the unknowns that are sought."""
    configuration = data.cases.distinct
    information = np.asarray(triangle.T @ triangle)
    rows, residual = over_noise(problem, found, variance)
    shared, count = problem.shared, int(configuration.max()) + 1
    if shared is None:
        each, groups = data.case, len(data.cases)
        rows, residual = rows.reshape(len(each), 3, -1), residual.reshape(len(each), 3)
        own = influence(rows, residual, each, groups, information)
        if count == len(data.cases):  # no repeats: the same groups, in another order
            by_case = reordered(own, _inverse(configuration))
        else:
            by_case = influence(rows, residual, configuration[each], count, information)
    else:
        each, groups = np.repeat(shared.group, 3), int(shared.group.max()) + 1
        rows, residual = rows[:, None], residual[:, None]
        together = influence(rows, residual, each, groups, information)
        of_experiment = _first(shared.group, data.case, len(data.cases))
        own = reordered(together, of_experiment)
        by_case = reordered(together, _first(shared.group, configuration[data.case], count))
    shift, moving = own.shift, tangent(problem.bounds, found.fit.held, found.compliance)
    if moving.shape[1] < problem.unknowns:  # what is held stays there
        shift = np.zeros_like(shift)
        if moving.shape[1]:
            part = moving.T @ information @ moving
            moved = influence(rows @ moving, residual, each, groups, part).shift
            shift = (moved if shared is None else moved[of_experiment]) @ moving.T
    free = free_rows(problem, found)
    left_out = found.residual - np.einsum("rip,rp->ri", free, np.nan_to_num(shift)[data.case])
    expected = unset()
    if problem.make.size or problem.columns.size or problem.shared is not None:
        weighed = rows.reshape(-1, problem.unknowns)
        expected = _expected(data, problem, free, weighed, own, information, variance)
    if len(wanted) < problem.unknowns:
        own = influence_on(wanted, own, information)
        by_case = influence_on(wanted, by_case, information)
    return LeftOut(own, by_case, left_out, expected)


_LOST = 1e3  # growth of a standard error beyond which nothing is known without an experiment


def _expected(
    data: Measurements,
    problem: Problem,
    free: Array,
    weighed: Array,
    own: Influence,
    information: Array,
    variance: float,
) -> Array:
    """(R, 3, 3) covariance of left-out residuals: noise, errors of its own, and of the others' fit.

    `free` are rows (R, 3, u) over the noise, `weighed` (3R, u) the same over all that errs.

    Source: the fit without group g has the information M - M_g.
    """
    group = data.case if problem.shared is None else problem.shared.group
    u, each = problem.unknowns, np.repeat(group, 3)
    count = int(group.max()) + 1
    size = 1.0 / np.sqrt(np.diagonal(information))
    weighed = weighed * size
    order = np.argsort(each, kind="stable")
    begin = np.searchsorted(each[order], np.arange(count))
    end = np.append(begin[1:], len(each))
    scaled = information * np.outer(size, size)
    without = np.empty((count, u, u))
    lost = np.zeros(count, dtype=bool)
    beyond: BoolArray = np.any(own.error_ratio > _LOST, axis=1)
    np.logical_or.at(lost, group, beyond[data.case])
    for g in range(count):
        part = weighed[order[begin[g] : end[g]]]
        without[g] = np.linalg.inv(np.eye(u) if lost[g] else scaled - part.T @ part)
    rows = np.asarray(problem.noise[0] @ free)
    spread = rows * size
    expected = variance * data.covariance + spread @ without[group] @ spread.transpose(0, 2, 1)
    if problem.shared is not None:
        expected = expected + problem.shared.own
    expected[lost[group]] = np.inf
    return frozen(expected)


def _first(group: IntArray, of: IntArray, count: int) -> IntArray:
    """(count,) group of the first reading of each number in `of`, (R,); 0 for one without any."""
    place = np.zeros(count, dtype=np.int64)
    place[of[::-1]] = group[::-1]
    return place


def _inverse(order: IntArray) -> IntArray:
    """(N,) where each number is in an order of all of them."""
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return place
