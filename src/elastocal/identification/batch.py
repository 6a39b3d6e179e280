"""Many campaigns of one plan: the estimates of `identify` without diagnostics.

In: a problem, readings of C campaigns that repeat its load cases. Out: C estimates with their
standard errors. What differs between campaigns is what was read, so that one regressor serves all
of them, and the linearised equilibria of all campaigns are one batch.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, IntArray, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.fitting.robust import Squares
from elastocal.identification.gauss_newton import Problem, solve_equilibrium, solve_linear


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
    """

    arm: ElasticArm
    free: IntArray
    start: Array
    cases: LoadCases
    case: IntArray
    covariance: Array
    linear: bool
    known: Array = field(default_factory=unset)

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
        )


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
    problem = design.problem(mean, before)
    solution = solve_linear(problem, Squares())
    if not design.linear:
        try:
            solution = solve_equilibrium(problem, solution, Squares())
        except InputError:
            raise InputError(
                "a virtual campaign cannot be fitted: the loads are too large for these compliances"
            ) from None
    chi_square = np.sum(apart**2, axis=(1, 2, 3)) + np.sum(solution.residual**2, axis=(1, 2))
    off = problem.extra_values - solution.compliance @ problem.extra_rows.T
    chi_square = chi_square + np.sum(off**2, axis=1)
    return Estimates(solution.compliance, solution.fit.covariance, chi_square)


def predicted_covariance(design: Design) -> Array:
    """(p, p) covariance (13) of the estimates, from the linear model, whatever is read."""
    nothing = np.zeros((1, *design.covariance.shape[:3]))
    return np.asarray(solve_linear(design.problem(nothing), Squares()).fit.covariance[0])
