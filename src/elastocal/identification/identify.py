"""Identification: from measurements to compliances with honest uncertainty.

In: elastic arm, measurements. Out: an `Identification`: compliances, covariance, intervals; see
`doubts` for what is weak in it. By default the model is the nonlinear equilibrium; the linear
regressor of the paper is there by name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.effects import without
from elastocal.elastic.nuisance import Nuisance
from elastocal.errors import IdentifiabilityError, InputError
from elastocal.fitting.bounds import tangent
from elastocal.fitting.goodness import LackOfFit, lack_of_fit
from elastocal.fitting.least_squares import inverse_root
from elastocal.fitting.mixed import estimate
from elastocal.identification.at_task import covariance_at_task, model_error
from elastocal.identification.fit import Fit
from elastocal.identification.gauss_newton import solve_equilibrium, solve_linear
from elastocal.identification.influences import left_out_of
from elastocal.identification.posing import Posed, posed
from elastocal.identification.problem import Problem, Solution, compliances, free_rows
from elastocal.identification.result import Identification, NoiseFound
from elastocal.identification.uncertainty import (
    noise,
    over_all,
    prior_misfit,
    pure_dof_of,
    rows_at,
    spread_of,
    squares,
    triangle_of,
)
from elastocal.matrices import confounded
from elastocal.measuring.measurements import Measurements
from elastocal.wording.identifiability import left_open


def identify(
    arm: ElasticArm,
    measurements: Measurements,
    how: Fit | None = None,
    *,
    prior: ComplianceModel | None = None,
    known: ComplianceModel | None = None,
    nuisance: Nuisance | None = None,
) -> Identification:
    """Compliances of the springs of `arm` from measured deflections.

    Args:
        arm: Robot, springs to identify, gravity; its tool must be the measured one.
        measurements: R readings.
        how: How to fit; the default is weighted least squares on the nonlinear equilibrium.
        prior: Estimates with covariance from before; those of springs not in `arm` do not count,
            but where they are the nuisance: then they are its prior, with all correlations.
        known: Compliances of further springs that bend but are not wanted, as after the first of
            two steps. Those with an uncertainty are fitted together with the others, from what is
            known and what is read; those without are held.
        nuisance: What moves the readings besides, with its priors. It is fitted along, nothing
            that cannot be is below zero then, and the fit without it is made as well: `alone`.
            What of it is in `known` is known from there.

    Raises:
        IdentifiabilityError: the data cannot tell some compliances apart; names them.
        InputError: too few readings, or an iteration that does not come to rest.

    Source: paper eqs. (6), (9), (13); the iteration on the equilibrium and the mixed fit are ours.
    """
    how = how or Fit()
    plain = _identified(posed(arm, measurements, how, prior, known), arm, measurements, how)
    if nuisance is None or how.fitted == "joints":
        return replace(plain, model=replace(plain.model, model_error=model_error(plain)))
    if how.robust:
        raise InputError(
            f"the loss {how.loss} does not go with nuisance parameters; use squares, or fit the "
            "joints alone (--fit joints)"
        )
    if known is not None:
        nuisance = without(arm.robot, nuisance, plain.model.springs)
    rough = posed(arm, measurements, how, prior, known, nuisance, plain.model).problem
    # Errors that are shares of deflections: those of the linear model are as large.
    unknown = solve_linear(rough, how.weigher).compliance
    near = ComplianceModel(rough.arm.springs, compliances(rough, unknown)[0])
    whole = posed(arm, measurements, how, prior, known, nuisance, near)
    found = _identified(whole, arm, measurements, how)
    found = replace(found, alone=plain, nuisance=nuisance)
    model = replace(
        found.model, task_covariance=covariance_at_task(found), model_error=model_error(found)
    )
    return replace(found, model=model)


def _identified(
    whole: Posed, arm: ElasticArm, measurements: Measurements, how: Fit
) -> Identification:
    """The fit of a problem, with all that is asked of it."""
    problem, names = whole.problem, arm.springs.names
    linear = solve_linear(problem, how.weigher)
    wanted = [whole.names.index(name) for name in names]
    information = _in_like_units(linear.fit.of(0).information, wanted)
    doubts = [group.doubt(whole.names) for group in confounded(information)]
    if doubts:
        raise IdentifiabilityError(left_open(doubts, measurements.source)).with_doubts(*doubts)
    problem, found = _at_rest(problem, how, linear)
    chi_square = squares(problem, found)
    scale, variance = noise(how, problem, found, chi_square)
    spread = spread_of(how, problem, found, variance)
    triangle = triangle_of(problem, found, variance)
    model = ComplianceModel(
        springs=problem.arm.springs,
        compliance=compliances(problem, found.compliance[None])[0],
        covariance=over_all(problem, spread.covariance),
        dof=spread.dof,
        source=measurements.source,
        noise_part=over_all(problem, spread.by_noise),
        noise=scale if how.estimates_sigma else 1.0,
    )
    left_out = left_out_of(measurements, problem, found, wanted, triangle, variance)
    held = tuple(n for n, h in zip(whole.names, found.fit.held, strict=True) if h)
    return Identification(
        model=model,
        identified=names,
        fitted=whole.names,
        how=how,
        linear=frozen(linear.compliance[0, wanted]),
        scale=scale,
        noise_of_kinds=_noise_of_kinds(
            measurements, problem, found, np.sqrt(variance) * triangle, scale, how
        ),
        chi_square=chi_square,
        dof=problem.dof,
        pure_dof=pure_dof_of(how, problem, found),
        lack_of_fit=_lack_of_fit(measurements, problem, found, how),
        residual=frozen(_with_unit(problem, found.residual)),
        weight=frozen(found.weight),
        influence=left_out.of_experiments,
        configuration_influence=left_out.of_load_cases,
        without_experiment=left_out.experiments,
        without_load_case=left_out.load_cases,
        held=held,
        unknown=frozen(found.compliance),
        unbounded=_unbounded(problem, found, variance)[wanted],
        unknown_covariance=spread.covariance,
        triangle=triangle,
        variance=variance,
        iterations=found.iterations,
        measurements=measurements,
        arm=problem.arm,
    )


def _in_like_units(information: Array, wanted: Sequence[int]) -> Array:
    """Information (u, u) in which what has a prior is as large as the largest that is wanted.

    Whether something is seen is judged beside the largest, and a gain has no unit to be judged by.
    """
    size = np.sqrt(np.diagonal(information))
    most = float(size[wanted].max()) or 1.0
    scale = np.where(size > 0.0, most / np.where(size > 0.0, size, 1.0), 1.0)
    scale[wanted] = 1.0
    return np.asarray(information * np.outer(scale, scale))


def _lack_of_fit(
    data: Measurements, problem: Problem, found: Solution, how: Fit
) -> LackOfFit | None:
    """What repeats say; nothing where they have errors of their own besides the noise."""
    shared = problem.shared
    pure = shared is None or shared.repeats_show_noise(data)
    if not pure:
        return None
    return lack_of_fit(
        found.residual,
        problem.noise[0],
        data.cases.distinct[data.case] * len(data.tool.targets) + data.marker,
        problem.unknowns - len(problem.extra_rows),
        prior_misfit(problem, found),
        known=not (how.estimates_sigma or how.robust),
        beside=rows_at(problem, found) if problem.absolute else None,
    )


_ROUNDS = 30
_SETTLED = 1e-9  # change of the noise's logarithm at which its estimate rests


def _at_rest(problem: Problem, how: Fit, linear: Solution) -> tuple[Problem, Solution]:
    """The problem with the noise that it shows, and where its fit comes to rest.

    What is known in absolute size pulls the less, the less noise there is in the readings, and how
    much there is shows at the estimate: both are found in turn.
    """
    solution = linear if how.linear else solve_equilibrium(problem, linear, how.weigher)
    if not (how.estimates_sigma and problem.absolute):
        return problem, solution.of(0)
    for _ in range(_ROUNDS):
        found = solution.of(0)
        _, variance = noise(how, problem, found, squares(problem, found))
        if abs(np.log(variance / problem.variance)) < _SETTLED:
            break
        problem = replace(problem, variance=variance)
        if how.linear:
            solution = solve_linear(problem, how.weigher)
        else:
            solution = solve_equilibrium(problem, solution, how.weigher)
    return problem, solution.of(0)


def _unbounded(problem: Problem, found: Solution, variance: float) -> Array:
    """(f,) estimates without the bounds, linearised at those with them."""
    moving = tangent(problem.bounds, found.fit.held, found.compliance)
    if moving.shape[1] == problem.unknowns:
        return found.compliance
    return frozen(estimate(rows_at(problem, found), variance)[0])


def _noise_of_kinds(
    measurements: Measurements,
    problem: Problem,
    found: Solution,
    triangle: Array,
    scale: float,
    how: Fit,
) -> tuple[NoiseFound, ...]:
    """Noise of positions and of rotations; that of all where there is but one kind.

    Residuals of outlying readings tell no noise, nor do those with errors of load cases in them, so
    these fits have one scale for all.

    Source: a group of residuals has as many freedoms as coordinates, less their leverage.
    """
    kinds = measurements.quantities
    errors = measurements.common.size or (
        problem.shared is not None and problem.shared.absolute.any()
    )
    if len(kinds) == 1 or how.robust or errors or problem.dof < 1:
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
