"""Posing: the problem that a fit is to solve, from springs, readings and what is known before.

In: elastic arm, measurements, models from before, nuisance. Out: a `Problem` whose unknowns are,
in this order, the springs that are sought or known with doubt, the nuisance parameters, and what
all experiments share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import common_columns
from elastocal.elastic.compliance_model import ComplianceModel, refuse_other_springs, rows_of
from elastocal.elastic.known_together import known_together
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.springs import VirtualJoints, merged, subset
from elastocal.elastic.tensors import of_tensors, tensors_of
from elastocal.errors import Doubt, IdentifiabilityError, InputError
from elastocal.fitting.bounds import Bounds
from elastocal.identification.fit import Fit
from elastocal.identification.problem import Problem
from elastocal.identification.shared_errors import errors_in, shared_errors
from elastocal.measuring.measurements import Measurements
from elastocal.wording import worded


@dataclass(frozen=True)
class Posed:
    """A problem with the names of its unknowns.

    Attributes:
        problem: The problem.
        springs: Names of the fitted springs, in chain order: those sought, and those in doubt.
        names: Names of all unknowns.
    """

    problem: Problem
    springs: tuple[str, ...]
    names: tuple[str, ...]


def posed(
    arm: ElasticArm,
    data: Measurements,
    how: Fit,
    prior: ComplianceModel | None,
    known: ComplianceModel | None,
    nuisance: Nuisance | None = None,
    near: ComplianceModel | None = None,
) -> Posed:
    """All springs that bend, which of them are free, and the rows of what is known before.

    Args:
        arm: Robot, springs to identify, gravity.
        data: The readings.
        how: How to fit.
        prior: Estimates of springs to identify, from before.
        known: Further springs that bend.
        nuisance: What moves the readings besides.
        near: Compliances near those that will be found, of which errors of load cases are shares.

    Raises:
        InputError: no readings, or models that do not fit the springs.
        IdentifiabilityError: too few readings.
    """
    if not len(data):
        raise InputError(f"{data.source or 'the measurements'}: there are no readings")
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
    fitted = tuple(n for n in springs.names if n in arm.springs.names or n in doubted)
    rows, values = _known_rows(arm, fitted, prior, known, doubted)
    if 3 * len(data) + len(values) < len(fitted):
        doubt = Doubt("too-few-readings", arm.springs.names, (), {"readings": len(data)})
        raise IdentifiabilityError(worded(doubt)).with_doubts(doubt)
    bent = replace(arm, springs=springs, tool=data.tool)
    problem = Problem(
        arm=bent,
        free=np.array([springs.names.index(name) for name in fitted]),
        start=start,
        cases=data.cases,
        marker=data.case * len(data.tool.targets) + data.marker,
        deflection=data.deflection[None],
        covariance=data.covariance,
        extra_rows=rows,
        extra_values=values[None],
        bounds=_bounds(springs, fitted) if how.nonnegative else None,
        known_noise=not how.estimates_sigma,
        source=data.source,
    )
    if nuisance is None:
        whitener = problem.noise[1]
        problem = replace(problem, shared=shared_errors(data, whitener))
        return Posed(problem, fitted, fitted)
    whole = _with_nuisance(Posed(problem, fitted, fitted), data, nuisance, near)
    return whole if prior is None else _from_before(whole, arm, nuisance, prior)


def _with_nuisance(
    plain: Posed, data: Measurements, nuisance: Nuisance, near: ComplianceModel | None
) -> Posed:
    """The problem with nuisance parameters besides, and bounds at zero."""
    problem, own = plain.problem, nuisance.unknowns
    springs = merged(problem.arm.springs, own.springs)
    arm = replace(problem.arm, springs=springs)
    start = np.zeros(len(springs))
    start[_places(springs, problem.arm.springs.names)] = problem.start
    f, u = len(plain.springs), len(own)
    make = np.zeros((len(springs), f + u))
    make[_places(springs, plain.springs), np.arange(f)] = 1.0
    make[_places(springs, own.springs.names), f:] = own.make
    start[_places(springs, plain.springs)] = 0.0
    errors, cases = nuisance.errors, data.cases
    compliance = np.zeros(len(springs)) if near is None else near.of(springs.names)
    common, columns = common_columns(errors, arm, compliance, cases)
    e = len(common)
    at = data.case[:, None], 3 * data.marker[:, None] + np.arange(3)
    extra = np.zeros((len(problem.extra_rows) + u + e, f + u + e))
    extra[: len(problem.extra_rows), :f] = problem.extra_rows
    extra[len(problem.extra_rows) :, f:] = np.diag(np.append(1.0 / nuisance.deviation, np.ones(e)))
    values = np.append(nuisance.mean / nuisance.deviation, np.zeros(e))
    least = _lower(problem.arm.springs, plain.springs)
    lower = np.concatenate([least, np.where(nuisance.signed, -np.inf, 0.0), np.full(e, -np.inf)])
    tensors = np.pad(tensors_of(springs, make), [(0, 0)] * 3 + [(0, e)])
    whole = replace(
        problem,
        arm=arm,
        start=start,
        make=make,
        columns=columns[at] if e else unset(),
        extra_rows=extra,
        extra_values=np.append(problem.extra_values[0], values)[None],
        bounds=Bounds(lower, tensors),
        shared=errors_in(data, problem.noise[1], errors, arm, compliance),
    )
    return Posed(whole, plain.springs, (*plain.springs, *own.names, *common))


def _from_before(
    whole: Posed, arm: ElasticArm, nuisance: Nuisance, prior: ComplianceModel
) -> Posed:
    """The problem in which a prior that fitted nuisance parameters, too, is the prior of both."""
    known = known_together(prior, arm.springs.names, nuisance.unknowns)
    if known is None:
        return whole
    problem, f, j = whole.problem, len(whole.springs), len(known.springs)
    rows = np.zeros((len(known.rows), problem.unknowns))
    rows[:, [whole.springs.index(name) for name in known.springs]] = known.rows[:, :j]
    rows[:, f + known.told] = known.rows[:, j:]
    others = len(problem.extra_rows) - (problem.unknowns - f)  # what the springs have for a prior
    kept = np.setdiff1d(np.arange(len(problem.extra_rows)), [*range(j), *(others + known.told)])
    problem = replace(
        problem,
        extra_rows=np.vstack([rows, problem.extra_rows[kept]]),
        extra_values=np.append(known.values, problem.extra_values[0, kept])[None],
    )
    return replace(whole, problem=problem)


def _bounds(springs: VirtualJoints, fitted: Sequence[str]) -> Bounds:
    """What compliances cannot be."""
    own = subset(springs, fitted)
    return Bounds(_lower(springs, fitted), tensors_of(own, np.eye(len(own))))


def _lower(springs: VirtualJoints, fitted: Sequence[str]) -> Array:
    """(f,) least compliances: zero, but where only the sum of several has a sign."""
    return np.where(of_tensors(subset(springs, fitted)), -np.inf, 0.0)


def _places(springs: VirtualJoints, names: Sequence[str]) -> list[int]:
    return [springs.names.index(name) for name in names]


def _known_rows(
    arm: ElasticArm,
    fitted: Sequence[str],
    prior: ComplianceModel | None,
    known: ComplianceModel | None,
    doubted: Sequence[str],
) -> tuple[Array, Array]:
    """Rows (E, f) and values (E,) with unit noise that say what was known before."""
    rows, values = np.zeros((0, len(fitted))), np.zeros(0)
    if prior is not None:
        shared = [name for name in arm.springs.names if name in prior.names]
        exact = [name for name in shared if name not in prior.uncertain]
        if exact:
            raise InputError(
                f"the prior knows {exact[0]!r} exactly: leave it out of `identify`, or give it a "
                "standard error"
            )
        rows = rows_of(prior, shared, fitted)
        values = rows @ prior.of(fitted)
    if known is not None:
        given = rows_of(known, doubted, fitted)
        rows, values = np.vstack([rows, given]), np.append(values, given @ known.of(fitted))
    return rows, values
