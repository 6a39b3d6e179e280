"""Identification: from measurements to compliances with honest uncertainty.

In: elastic arm, measurements. Out: an `Identification`: compliances, covariance, intervals; see
`doubts` for what is weak in it. By default the model is the nonlinear equilibrium; the linear
regressor of the paper is there by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import (
    ComplianceModel,
    refuse_other_springs,
    rows_of,
)
from elastocal.elastic.springs import merged, subset
from elastocal.errors import Doubt, IdentifiabilityError, InputError
from elastocal.fitting.goodness import lack_of_fit
from elastocal.fitting.influence import Influence, influence, influence_on, reordered
from elastocal.fitting.least_squares import inverse_root
from elastocal.fitting.mixed import estimate
from elastocal.identification.fit import Fit
from elastocal.identification.gauss_newton import (
    Problem,
    Solution,
    free_rows,
    solve_equilibrium,
    solve_linear,
)
from elastocal.identification.result import Identification, NoiseFound
from elastocal.identification.uncertainty import (
    noise,
    over_all,
    rows_at,
    spread_of,
    triangle_of,
)
from elastocal.matrices import confounded
from elastocal.measuring.measurements import Measurements
from elastocal.wording import worded
from elastocal.wording.identifiability import left_open


def identify(
    arm: ElasticArm,
    measurements: Measurements,
    how: Fit | None = None,
    *,
    prior: ComplianceModel | None = None,
    known: ComplianceModel | None = None,
) -> Identification:
    """Compliances of the springs of `arm` from measured deflections.

    Args:
        arm: Robot, springs to identify, gravity; its tool must be the measured one.
        measurements: R readings.
        how: How to fit; the default is weighted least squares on the nonlinear equilibrium.
        prior: Estimates with covariance from before; those of springs not in `arm` do not count.
        known: Compliances of further springs that bend but are not wanted, as after the first of
            two steps. Those with an uncertainty are fitted together with the others, from what is
            known and what is read; those without are held.

    Raises:
        IdentifiabilityError: the data cannot tell some compliances apart; names them.
        InputError: too few readings, or an iteration that does not come to rest.

    Source: paper eqs. (6), (9), (13); the iteration on the equilibrium is ours.
    """
    how = how or Fit()
    problem = _problem(arm, measurements, how, prior, known)
    linear = solve_linear(problem, how.weigher)
    names, fitted = arm.springs.names, _fitted(problem)
    doubts = [group.doubt(fitted) for group in confounded(linear.fit.of(0).information)]
    if doubts:
        raise IdentifiabilityError(left_open(doubts, measurements.source)).with_doubts(*doubts)
    problem, found = _at_rest(problem, how, linear)
    misfit = _prior_misfit(problem, found)
    chi_square = float(np.sum(found.residual**2)) + misfit
    scale, variance = noise(how, problem, found, chi_square)
    spread = spread_of(how, problem, found, variance)
    triangle = triangle_of(problem, found, variance)
    compliance = np.array(problem.start)
    compliance[problem.free] = found.compliance
    model = ComplianceModel(
        springs=problem.arm.springs,
        compliance=compliance,
        covariance=over_all(problem, spread.covariance),
        dof=spread.dof,
        source=measurements.source,
        by_noise=over_all(problem, spread.by_noise),
        noise=scale if how.estimates_sigma else 1.0,
    )
    wanted = [fitted.index(name) for name in names]
    influences, left_out = _influences(measurements, problem, found, wanted, triangle, variance)
    return Identification(
        model=model,
        identified=names,
        fitted=fitted,
        how=how,
        linear=frozen(linear.compliance[0, wanted]),
        scale=scale,
        noise_of_kinds=_noise_of_kinds(
            measurements, problem, found, np.sqrt(variance) * triangle, scale, how
        ),
        chi_square=chi_square,
        dof=problem.dof,
        lack_of_fit=lack_of_fit(
            found.residual,
            problem.noise[0],
            measurements.cases.distinct[measurements.case] * len(measurements.tool.targets)
            + measurements.marker,
            len(fitted) - len(problem.extra_rows),
            misfit,
            known=not (how.estimates_sigma or how.robust),
            beside=rows_at(problem, found) if len(problem.extra_rows) else None,
        ),
        residual=frozen(_with_unit(problem, found.residual)),
        weight=frozen(found.weight),
        influence=influences[0],
        configuration_influence=influences[1],
        left_out=frozen(_with_unit(problem, left_out)),
        held=tuple(n for n, h in zip(fitted, found.fit.held, strict=True) if h),
        unbounded=_unbounded(problem, found, variance)[wanted],
        triangle=triangle,
        variance=variance,
        iterations=found.iterations,
        measurements=measurements,
        arm=problem.arm,
    )


_ROUNDS = 30
_SETTLED = 1e-9  # change of the noise's logarithm at which its estimate rests


def _at_rest(problem: Problem, how: Fit, linear: Solution) -> tuple[Problem, Solution]:
    """The problem with the noise that it shows, and where its fit comes to rest.

    What is known in absolute size pulls the less, the less noise there is in the readings, and how
    much there is shows at the estimate: both are found in turn.
    """
    solution = linear if how.linear else solve_equilibrium(problem, linear, how.weigher)
    if not (how.estimates_sigma and len(problem.extra_rows)):
        return problem, solution.of(0)
    for _ in range(_ROUNDS):
        found = solution.of(0)
        chi_square = float(np.sum(found.residual**2)) + _prior_misfit(problem, found)
        _, variance = noise(how, problem, found, chi_square)
        if abs(np.log(variance / problem.variance)) < _SETTLED:
            break
        problem = replace(problem, variance=variance)
        if how.linear:
            solution = solve_linear(problem, how.weigher)
        else:
            solution = solve_equilibrium(problem, solution, how.weigher)
    return problem, solution.of(0)


def _unbounded(problem: Problem, found: Solution, variance: float) -> Array:
    """(f,) estimates without the bound at zero, linearised at those with it."""
    if not found.fit.held.any():
        return found.compliance
    return frozen(estimate(rows_at(problem, found), variance)[0])


def _problem(
    arm: ElasticArm,
    measurements: Measurements,
    how: Fit,
    prior: ComplianceModel | None,
    known: ComplianceModel | None,
) -> Problem:
    """All springs that bend, which of them are free, and the rows of the prior."""
    if not len(measurements):
        raise InputError(f"{measurements.source or 'the measurements'}: there are no readings")
    for model in (prior, known):
        if model is not None:
            refuse_other_springs(model, arm.springs)
    springs, start = arm.springs, np.zeros(len(arm.springs))
    doubted: tuple[str, ...] = ()
    if known is not None:
        others = [name for name in known.names if name not in arm.springs.names]
        springs = merged(arm.springs, subset(known.springs, others))
        start = np.where([n in others for n in springs.names], known.of(springs.names), 0.0)
        doubted = tuple(name for name in known.uncertain if name in others)
    free = [i for i, n in enumerate(springs.names) if n in arm.springs.names or n in doubted]
    fitted = [springs.names[i] for i in free]
    rows, values = _prior_rows(arm.springs.names, fitted, prior)
    if known is not None:
        given = rows_of(known, doubted, fitted)
        rows, values = np.vstack([rows, given]), np.append(values, given @ known.of(fitted))
    if 3 * len(measurements) + len(values) < len(free):
        doubt = Doubt("too-few-readings", arm.springs.names, (), {"readings": len(measurements)})
        raise IdentifiabilityError(worded(doubt)).with_doubts(doubt)
    bent = replace(arm, springs=springs, tool=measurements.tool)
    return Problem(
        arm=bent,
        free=np.array(free),
        start=start,
        cases=measurements.cases,
        marker=measurements.case * len(measurements.tool.targets) + measurements.marker,
        deflection=measurements.deflection[None],
        covariance=measurements.covariance,
        extra_rows=rows,
        extra_values=values[None],
        nonnegative=how.nonnegative,
        known_noise=not how.estimates_sigma,
        source=measurements.source,
    )


def _fitted(problem: Problem) -> tuple[str, ...]:
    """Names of the springs that are fitted."""
    return tuple(problem.arm.springs.names[i] for i in problem.free)


def _prior_rows(
    names: tuple[str, ...], fitted: Sequence[str], prior: ComplianceModel | None
) -> tuple[Array, Array]:
    """Rows (E, f) and values (E,) with unit noise that say what was known of `names`."""
    if prior is None:
        return np.zeros((0, len(fitted))), np.zeros(0)
    shared = [name for name in names if name in prior.names]
    exact = [name for name in shared if name not in prior.uncertain]
    if exact:
        raise InputError(
            f"the prior knows {exact[0]!r} exactly: leave it out of `identify`, or give it a "
            "standard error"
        )
    rows = rows_of(prior, shared, fitted)
    return rows, rows @ prior.of(fitted)


def _prior_misfit(problem: Problem, found: Solution) -> float:
    return float(np.sum((problem.extra_values[0] - problem.extra_rows @ found.compliance) ** 2))


def _influences(
    measurements: Measurements,
    problem: Problem,
    found: Solution,
    wanted: Sequence[int],
    triangle: Array,
    variance: float,
) -> tuple[tuple[Influence, Influence], Array]:
    """Influence of experiments and of load cases on the `wanted` ones; residuals (R, 3) over the
    noise when an experiment is left out."""
    cases = measurements.cases
    configuration = cases.distinct
    free = free_rows(problem, found)
    rows, residual = free, found.residual
    if (found.weight != 1.0).any() or variance != 1.0:
        root = np.sqrt(found.weight / variance)[:, None]
        rows, residual = free * root[..., None], residual * root
    information = np.asarray(triangle.T @ triangle)
    own = influence(rows, residual, measurements.case, len(cases), information)
    count = int(configuration.max()) + 1
    group = configuration[measurements.case]
    alone = count == len(cases)  # no repeats: the same groups, in another order
    by_case = (
        reordered(own, _inverse(configuration))
        if alone
        else influence(rows, residual, group, count, information)
    )
    shift = np.nan_to_num(own.shift)[measurements.case]
    left_out = found.residual - np.einsum("rip,rp->ri", free, shift)
    if len(wanted) == len(problem.free):
        return (own, by_case), left_out
    return (
        influence_on(wanted, own, information),
        influence_on(wanted, by_case, information),
    ), left_out


def _inverse(order: IntArray) -> IntArray:
    """(N,) where each number is in an order of all of them."""
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return place


def _noise_of_kinds(
    measurements: Measurements,
    problem: Problem,
    found: Solution,
    triangle: Array,
    scale: float,
    how: Fit,
) -> tuple[NoiseFound, ...]:
    """Noise of positions and of rotations; that of all where there is but one kind.

    Residuals of outlying readings tell no noise, so a robust fit has one scale for all.

    Source: a group of residuals has as many freedoms as coordinates, less their leverage.
    """
    kinds = measurements.quantities
    if len(kinds) == 1 or how.robust or problem.dof < 1:
        return tuple(NoiseFound(kind, scale, float(problem.dof)) for kind in kinds)
    rows = free_rows(problem, found)
    root = inverse_root(triangle)
    leverage, square = np.sum((rows @ root) ** 2, axis=(1, 2)), np.sum(found.residual**2, axis=1)
    noise = []
    for kind in kinds:
        dof = float(3 * kind.readings.sum() - leverage[kind.readings].sum())
        total = float(square[kind.readings].sum())
        noise.append(NoiseFound(kind, float(np.sqrt(total / dof)) if dof > 0.1 else np.nan, dof))
    return tuple(noise)


def _with_unit(problem: Problem, residual: Array) -> Array:
    """(R, 3) residuals [m, rad] of residuals over the noise."""
    return np.einsum("rij,rj->ri", problem.noise[0], residual)
