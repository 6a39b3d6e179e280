"""Virtual campaigns on robots that have what a study calls nuisance, each on another robot.

In: study, true joints, plans. Out: a `MonteCarlo` as without nuisance. Every campaign draws a
robot, measures it at its equilibrium and identifies it as a real one would be; nothing of the fit
is used for the truth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, frozen
from elastocal.cores import dealt, several_cores
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import subset
from elastocal.errors import IdentifiabilityError
from elastocal.fitting.goodness import quantiles
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.planning.promise import Promise, promise
from elastocal.simulation.beforehand import as_known, drawn, rows_known
from elastocal.simulation.campaigns import Campaigns
from elastocal.simulation.true_robot import TrueRobot, true_robot
from elastocal.simulation.virtual_campaign import Reality, simulate
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import TestPath
from elastocal.study.two_steps import with_nuisance

_PART = 10  # campaigns that a process is given at once


@dataclass(frozen=True)
class _Work:
    """All that the campaigns of one plan share; sent to the workers."""

    study: Study
    nuisance: Nuisance
    given: ComplianceModel
    cases: LoadCases
    repeats: IntArray
    how: Fit
    reality: Reality


@dataclass(frozen=True)
class _Campaign:
    """What one campaign came to."""

    estimate: Array
    standard_error: Array
    inside: BoolArray
    left: Array


def campaigns_of_robots(
    study: Study,
    given: ComplianceModel,
    plans: Mapping[str, tuple[LoadCases, IntArray]],
    number: int,
    *,
    seed: int,
    workers: int,
    how: Fit,
    reality: Reality,
    progress: Callable[[str, float], None],
) -> tuple[Campaigns, ...]:
    """Draw, measure, identify and judge `number` robots for every plan.

    Args and errors as those of `monte_carlo.campaigns`, of a study that knows nuisance.
    """
    nuisance = study.nuisance
    assert nuisance is not None
    study = _unprepared(study, nuisance)
    reality = replace(reality, errors=reality.errors or nuisance.errors)
    found = []
    for i, (name, (planned, times)) in enumerate(plans.items()):
        kept = np.asarray(times) > 0
        cases, repeats = planned.chosen(kept), np.asarray(times)[kept]
        expected = promise(study, cases, repeats)
        assert expected is not None
        if not np.isfinite(expected.rho0):
            raise IdentifiabilityError(f"{name}: the plan does not tell all compliances apart")
        work = _Work(study, nuisance, given, cases, repeats, how, reality)
        seeds = [np.random.SeedSequence(seed, spawn_key=(i, k)) for k in range(number)]
        parts = [(work, seeds[k : k + _PART]) for k in range(0, number, _PART)]
        made: list[_Campaign] = []
        with several_cores(workers):
            for part in dealt(_part, parts):
                made += part
                progress(name, (i + len(made) / number) / len(plans))
        found.append(_collected(study, given, name, int(repeats.sum()), made, expected))
    return tuple(found)


def _unprepared(study: Study, nuisance: Nuisance) -> Study:
    """The study without what it knows of the springs to identify: campaigns do not have it."""
    nothing = np.zeros_like(study.prior)
    bare = replace(study, prior=nothing, carried_out=None, earlier=None, done=None)
    bare = with_nuisance(bare, None)
    return with_nuisance(bare, nuisance)


def _part(work: tuple[_Work, list[np.random.SeedSequence]]) -> list[_Campaign]:
    """Some campaigns of a plan."""
    shared, seeds = work
    return [_campaign(shared, np.random.default_rng(seed)) for seed in seeds]


def _campaign(work: _Work, rng: np.random.Generator) -> _Campaign:
    """A robot, measured, identified and judged."""
    study = work.study
    by_robot, by_reading, by_knowledge = rng.spawn(3)
    true = true_robot(study, work.given, by_robot, work.reality.loads)
    data = simulate(
        study,
        true.model,
        work.cases,
        work.repeats,
        by_reading,
        reality=replace(work.reality, loads=true.loads),
    )
    known = _known(work, by_knowledge)
    found = identify(study.arm, data, work.how, known=known, nuisance=work.nuisance)
    names = study.sought.names
    index = [found.model.names.index(name) for name in names]
    error = found.model.standard_error[index]
    interval = _interval(found, names)
    value = work.given.of(names)
    return _Campaign(
        estimate=found.model.compliance[index],
        standard_error=error,
        inside=(interval[:, 0] <= value) & (value <= interval[:, 1]),
        left=np.array(
            [
                error_left(study, pose, found.model, true, linear=work.reality.linear)
                for pose in study.test_poses
            ]
        ),
    )


def _known(work: _Work, rng: np.random.Generator) -> ComplianceModel | None:
    """What a campaign knows of springs that are given and neither sought nor nuisance.

    What the study knows with an uncertainty is off the truth by chance.
    """
    study, given = work.study, work.given
    names = [n for n in given.names if n not in work.nuisance.unknowns.springs.names]
    if set(names) <= set(study.springs.names):
        return None
    model = as_known(study, given)
    off = drawn(given.of(study.sought.names), rows_known(study), 1, rng)
    value = dict(zip(model.names, model.compliance.tolist(), strict=True))
    if off is not None:
        value |= dict(zip(study.sought.names, off[0].tolist(), strict=True))
    index = [model.names.index(name) for name in names]
    return ComplianceModel(
        subset(model.springs, names),
        frozen([value[name] for name in names]),
        model.covariance[np.ix_(index, index)],
        source=model.source,
    )


def _interval(found: Identification, names: tuple[str, ...]) -> Array:
    """(p, 2) 95 % intervals of springs, as the fit says them."""
    own = dict(zip(found.identified, found.interval, strict=True))
    model = found.model
    half = quantiles(0.975, model.freedom(np.eye(len(model.names)))) * model.standard_error
    return np.array(
        [
            own[name] if name in own else model.compliance[i] + half[i] * np.array([-1.0, 1.0])
            for name, i in ((name, model.names.index(name)) for name in names)
        ]
    )


def error_left(
    study: Study,
    pose: TestPose | TestPath,
    model: ComplianceModel,
    true: TrueRobot,
    *,
    linear: bool = False,
) -> float:
    """Distance of target and tool after compensation with a model [m], on a true robot.

    Of a path its root mean square. Friction and what no model explains are not in it: a model
    knows of neither, and no other one would leave less.

    Args:
        study: The study.
        pose: The test pose, or path.
        model: What is compensated, of whatever springs.
        true: The robot.
        linear: By the regressors.

    Source: as `remaining_error.errors_left`.
    """
    more = 1.0 + true.process_gain
    if pose.cases is None or pose.tool is None:
        names, fitted = study.fitted.springs.names, study.fitted
        off = model.of(names) - more * true.model.of(names)
        unknown = np.linalg.lstsq(fitted.make, off, rcond=None)[0]
        return float(np.sqrt(np.mean(np.sum((pose.regressors @ unknown) ** 2, axis=1))))
    cases = pose.cases
    pushed = LoadCases(cases.q, more * cases.wrench)
    bent = []
    for known, load in ((model, cases), (true.model, pushed)):
        arm = ElasticArm(study.robot, known.springs, pose.tool.at_tcp, study.gravity)
        if linear:
            bent.append(regressor(arm, load) @ known.compliance)
        else:
            bent.append(loaded_deflection(arm, known.compliance, load))
    return float(np.sqrt(np.mean(np.sum((bent[0] - bent[1]) ** 2, axis=1))))


def _collected(
    study: Study,
    given: ComplianceModel,
    name: str,
    count: int,
    made: list[_Campaign],
    expected: Promise,
) -> Campaigns:
    """The campaigns of a plan beside what it promises."""
    return Campaigns(
        name=name,
        experiments=count,
        truth=frozen(given.of(study.sought.names)),
        estimate=frozen([one.estimate for one in made]),
        standard_error=frozen([one.standard_error for one in made]),
        inside=frozen([one.inside for one in made], np.bool_),
        covariance=expected.covariance,
        error=frozen([one.left for one in made]),
        weight=frozen(study.shares),
        squares=expected.squares,
        rho0_each=frozen(expected.rho0_each),
    )
