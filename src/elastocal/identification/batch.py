"""Many campaigns of one plan: the estimates of `identify` without diagnostics.

In: a problem, readings of C campaigns that repeat its load cases. Out: C estimates with their
standard errors. What differs between campaigns is what was read, so that one regressor serves all
of them, and the linearised equilibria of all campaigns are one batch.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.neighbourhood import Series
from elastocal.errors import InputError
from elastocal.fitting.least_squares import column_norms
from elastocal.fitting.robust import Squares
from elastocal.identification.gauss_newton import solve_equilibrium, solve_linear
from elastocal.identification.problem import Problem
from elastocal.identification.shared_errors import SharedErrors, Turn
from elastocal.matrices import eliminated


@dataclass(frozen=True)
class Design:
    """What C campaigns have in common.

    Attributes:
        arm: Robot with the c springs that bend, and the tool with T targets.
        free: (p,) positions of the fitted springs.
        start: (c,) compliances; those of the free springs do not count.
        cases: S load cases, as recorded.
        case: (N,) load case of each experiment.
        covariance: (S, T, 3, 3) of the readings [m², rad²].
        linear: Whether the model is the regressor, or else the nonlinear equilibrium.
        known: (E, p) rows with unit noise of what is known before each campaign; none if not given.
        near: Series of the deflections about the start, where the estimates are near to it: then
            most fits need no equilibrium.
        common: (S, T, 3, e) what readings of one experiment share, in `covariance` already; none if
            not given.
    """

    arm: ElasticArm
    free: IntArray
    start: Array
    cases: LoadCases
    case: IntArray
    covariance: Array
    linear: bool
    known: Array = field(default_factory=unset)
    near: Series | None = None
    common: Array = field(default_factory=unset)

    @cached_property
    def turns(self) -> Array | None:
        """(S, 3T, 3T) what makes readings over their noise independent; None if they are."""
        if not self.common.size:
            return None
        moved = np.linalg.inv(np.linalg.cholesky(self.covariance)) @ self.common
        columns = moved.reshape(len(moved), -1, moved.shape[3])
        whole = columns @ columns.transpose(0, 2, 1)
        own = np.kron(np.eye(moved.shape[1]), np.ones((3, 3)))  # in the covariances already
        return np.linalg.inv(np.linalg.cholesky(whole * (1.0 - own) + np.eye(len(own))))

    @property
    def dof(self) -> int:
        """Degrees of freedom of the residuals."""
        read = 3 * len(self.case) * len(self.arm.tool.targets)
        return read + len(self.known) - len(self.free)

    @property
    def repeats(self) -> IntArray:
        """(S,) how often each load case is measured."""
        return np.bincount(self.case, minlength=len(self.cases))

    def problem(self, mean: Array, before: Array | None = None) -> Problem:
        """To fit (C, S, T, 3) means over the repeats of each load case [m, rad].

        `before` are (C, p) compliances as they were known before; only the rows of `known` count.
        """
        count, rows = mean.shape[1] * mean.shape[2], self.known.reshape(-1, len(self.free))
        values = np.zeros((1, len(rows))) if before is None else before @ rows.T
        return Problem(
            arm=self.arm,
            free=self.free,
            start=self.start,
            cases=self.cases,
            marker=np.arange(count),
            deflection=mean.reshape(len(mean), count, 3),
            covariance=(self.covariance / self.repeats[:, None, None, None]).reshape(count, 3, 3),
            extra_rows=rows,
            extra_values=values,
            shared=_of_experiments(self.turns),
        )


def _of_experiments(turns: Array | None) -> SharedErrors | None:
    """What readings of one experiment share, as `turns` (S, m, m) undo it."""
    if turns is None:
        return None
    count, m = turns.shape[:2]
    turn = Turn(np.arange(count * m).reshape(count, m), turns)
    group = np.repeat(np.arange(count), m // 3)
    nothing = np.zeros(count * m), np.zeros((count * m // 3, 3, 3))
    return SharedErrors(group, (turn,), *nothing, of_experiments=False)


@dataclass(frozen=True)
class Estimates:
    """C fits.

    Attributes:
        compliance: (C, p) estimates [rad/(N·m) or m/N].
        covariance: (C or 1, p, p) for the noise that the covariances of the readings promise.
        chi_square: (C,) sums of the squared residuals over their variances.
    """

    compliance: Array
    covariance: Array
    chi_square: Array


def fit_all(design: Design, readings: Array, before: Array | None = None) -> Estimates:
    """Fit every campaign by itself.

    Repeats of a load case have the same row and the same weight, so their mean tells all that
    the estimate needs; their scatter goes to chi-square.

    Args:
        design: What the campaigns have in common.
        readings: (C, N, T, 3) deflections read [m, rad].
        before: (C, p) compliances as each campaign knew them before; see `Design.known`.

    Raises:
        InputError: an iteration does not come to rest.

    Source: paper eqs. (6), (9), (13); the batch is ours.
    """
    case, count = design.case, len(design.case)
    share = np.zeros((len(design.cases), count))
    share[case, np.arange(count)] = 1.0 / design.repeats[case]
    mean = (share @ readings.reshape(len(readings), count, -1)).reshape(
        len(readings), len(design.cases), *readings.shape[2:]
    )
    whitener = np.linalg.inv(np.linalg.cholesky(design.covariance))
    apart = np.einsum("nkij,cnkj->cnki", whitener[case], readings - mean[:, case])
    apart = apart.reshape(*apart.shape[:2], -1)
    if design.turns is not None:
        apart = np.einsum("nij,cnj->cni", design.turns[case], apart)
    scatter = np.einsum("cni,cni->c", apart, apart)
    found, sure = None, np.zeros(len(mean), dtype=bool)
    if design.near is not None and not design.linear and design.turns is None:
        found, sure = _by_series(design.near, design.start, design.problem(mean, before))
    if found is None or not sure.any():
        found = _one_by_one(design, mean, before)
    elif not sure.all():
        rest = _one_by_one(design, mean[~sure], None if before is None else before[~sure])
        for whole, part in zip(vars(found).values(), vars(rest).values(), strict=True):
            whole[~sure] = part
    return Estimates(found.compliance, found.covariance, found.chi_square + scatter)


def _one_by_one(design: Design, mean: Array, before: Array | None) -> Estimates:
    """Fits (C,) by the linear model, or by iterations on the equilibrium."""
    problem = design.problem(mean, before)
    solution = solve_linear(problem, Squares())
    if not design.linear:
        try:
            solution = solve_equilibrium(problem, solution, Squares())
        except InputError:
            raise InputError(
                "a virtual campaign cannot be fitted: the loads are too large for these compliances"
            ) from None
    off = problem.extra_values - solution.compliance @ problem.extra_rows.T
    left = solution.residual.reshape(len(solution.residual), -1)
    if problem.shared is not None:
        left = problem.shared.turned(left.T).T
    chi_square = np.sum(left**2, axis=1) + np.sum(off**2, axis=1)
    return Estimates(solution.compliance, solution.fit.covariance, chi_square)


_STEPS = 5  # at most; each leaves a ten thousandth of the error before
_AT_REST = 1e-7  # step over the standard errors after which nothing is left
_CLEAR = 1e3  # condition up to which normal equations are exact enough


def _by_series(near: Series, start: Array, problem: Problem) -> tuple[Estimates | None, BoolArray]:
    """Fits by the series of the deflections about the start, and which (C,) of them are exact.

    Steps of Gauss-Newton with the information at the centre and the gradient where they are. No
    estimates at all where the unknowns are not well told apart.
    """
    count, p = len(problem.deflection), len(problem.free)
    exact = np.zeros(count, dtype=bool)
    whitener, centre = problem.noise[1], start[problem.free]

    def white(values: Array) -> Array:
        """(C, m, x) values over the noise."""
        apart = values.reshape(len(values), -1, 3, values.shape[2])
        return (whitener @ apart).reshape(values.shape)

    together = np.vstack([white(near.gradient(np.zeros((1, p))))[0], problem.extra_rows])
    scale = column_norms(together)
    triangle = np.asarray(np.linalg.qr(together / scale, mode="r"))
    if len(triangle) < p or not np.linalg.cond(triangle) < _CLEAR:
        return None, exact
    root = np.linalg.inv(triangle) / scale[:, None]
    read, change = problem.deflection.reshape(count, -1), np.zeros((count, p))
    value, rows = near.value[None], white(near.gradient(np.zeros((1, p))))
    for _ in range(_STEPS):
        left = white((read - value)[..., None])[..., 0]
        off = problem.extra_values - (centre + change) @ problem.extra_rows.T
        pull = np.matmul(left[:, None], rows)[:, 0] + off @ problem.extra_rows
        step = pull @ root  # over the standard errors
        change = change + step @ root.T
        at_rest = np.abs(step).max(axis=1) <= _AT_REST
        if at_rest.all():
            break
        value, exact = near.at(change)
        rows = white(near.gradient(change))
    rows = np.broadcast_to(rows, (count, *rows.shape[1:]))
    scaled = rows / scale
    known = problem.extra_rows / scale
    information = scaled.transpose(0, 2, 1) @ scaled + known.T @ known
    identity = np.broadcast_to(np.eye(p)[..., None], (p, p, count)).copy()
    inverse = eliminated(np.ascontiguousarray(information.transpose(1, 2, 0)), identity)
    covariance = inverse.transpose(2, 0, 1) / np.outer(scale, scale)
    chi_square = np.einsum("cm,cm->c", left, left) + np.sum(off**2, axis=1)
    return Estimates(centre + change, covariance, chi_square), at_rest & exact


def predicted_covariance(design: Design) -> Array:
    """(p, p) covariance (13) of the estimates, from the linear model, whatever is read."""
    nothing = np.zeros((1, *design.covariance.shape[:3]))
    return np.asarray(solve_linear(design.problem(nothing), Squares()).fit.covariance[0])
