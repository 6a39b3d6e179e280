"""Monte Carlo: many virtual campaigns of plans side by side, predictions against what is found.

In: study, truth, plans. Out: a `MonteCarlo`: for every plan the estimates and the errors that are
left at the test poses when their compliances are used for compensation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.cores import dealt, several_cores
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.neighbourhood import deflection_series
from elastocal.errors import IdentifiabilityError, InputError
from elastocal.fitting.goodness import quantile
from elastocal.identification.batch import Design, fit_all, predicted_covariance
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.simulation.beforehand import as_known, drawn, rows_known
from elastocal.simulation.campaigns import Campaigns, MonteCarlo, RandomCampaigns
from elastocal.simulation.remaining_error import Judge, errors_left, judge
from elastocal.simulation.virtual_campaign import (
    Reality,
    VirtualReadings,
    deflections,
    disturbed,
    gross_errors,
    lever,
    noise,
    simulate,
    virtual_readings,
)
from elastocal.simulation.with_nuisance import campaigns_of_robots
from elastocal.study.study import Study

_POOL = 20_000  # random load cases that random plans are drawn from

CHUNK = 250
"""Campaigns computed together. Fixed, so that results do not depend on the number of workers."""

_PART = 4
"""Chunks that a process is given at once, with their plan."""

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class _Plan:
    """All that the campaigns of one plan share; sent to the workers."""

    design: Design
    ideal: VirtualReadings
    compliance: Array
    how: Fit
    judges: tuple[Judge, ...]
    reality: Reality
    lever: float | None


def campaigns(
    study: Study,
    truth: ComplianceModel,
    plans: Mapping[str, tuple[LoadCases, IntArray]],
    number: int,
    *,
    seed: int = 0,
    workers: int = 1,
    how: Fit | None = None,
    reality: Reality | None = None,
    random: int = 0,
    progress: Progress | None = None,
) -> MonteCarlo:
    """Simulate, identify and judge `number` campaigns of every plan.

    Springs of the truth that the study does not identify bend in the experiments, and are known to
    the fit and to the compensation: what is compared is how well the plans find the others. What
    the study knows with an uncertainty is known to each campaign with an error drawn from it. A
    study that knows nuisance has each campaign on a robot of its own: see `with_nuisance`.

    Args:
        study: Robot, springs to identify, tool, instrument, test poses.
        truth: True compliances; all springs that are fitted must be in it.
        plans: Load cases and repeats by the name of the plan.
        number: Campaigns of each plan, at least 2.
        seed: Same seed, same result, whatever the number of workers.
        workers: Processes.
        how: How to fit; robust losses and bounds are not available here.
        reality: Load errors, outliers; a linear truth is judged by the regressors of the test
            poses.
        random: Random plans beside, with as many experiments as the first plan and together as many
            campaigns as one plan has, at least 2 each; 0 for none.
        progress: Told what is going on.

    Raises:
        InputError: the truth lacks a spring; fewer than 2 campaigns; no plan to compare with.
        IdentifiabilityError: a plan does not identify the springs.
        EquilibriumError: the arm gives way.
    """
    how, reality = how or Fit(), reality or Reality()
    linear = reality.linear
    _check(study, truth, number, how)
    result = MonteCarlo(
        springs=study.sought.names,
        known=tuple(n for n in truth.names if n not in study.fitted.springs.names),
        test_poses=tuple(pose.name for pose in study.test_poses),
        plans=(),
        number=number,
        seed=seed,
        how=how,
        linear=linear,
        nuisance=study.nuisance is not None,
    )
    done = campaigns_of_robots if result.nuisance else _alike
    result = replace(
        result,
        plans=done(
            study,
            truth,
            plans,
            number,
            seed=seed,
            workers=workers,
            how=how,
            reality=reality,
            progress=progress or (lambda what, share: None),
        ),
    )
    if not random:
        return result
    beside = _random_campaigns(study, truth, result, random, reality, progress)
    return replace(result, random=beside)


def _alike(
    study: Study,
    truth: ComplianceModel,
    plans: Mapping[str, tuple[LoadCases, IntArray]],
    number: int,
    *,
    seed: int,
    workers: int,
    how: Fit,
    reality: Reality,
    progress: Progress,
) -> tuple[Campaigns, ...]:
    """Campaigns of every plan, all on the same robot, in batches."""
    linear, arm = reality.linear, study.fitted_arm
    judges = tuple(judge(arm, truth, pose, linear=linear) for pose in study.test_poses)
    shared: dict[str, _Plan] = {}
    for name, (planned, times) in plans.items():
        kept = np.asarray(times) > 0
        cases, repeats = planned.chosen(kept), np.asarray(times)[kept]
        ideal = virtual_readings(arm, study.instrument, truth, cases, linear=linear)
        shared[name] = _Plan(
            _design(study, truth, ideal, cases, repeats, how),
            ideal,
            truth.compliance,
            how,
            judges,
            reality,
            lever(study.instrument),
        )
        # One campaign the long way: it refuses what cannot be identified, by name.
        plain, rng = Reality(linear=linear), np.random.default_rng(seed)
        one = simulate(study, truth, cases, repeats, rng, reality=plain)
        identify(study.arm, one, how, known=as_known(study, truth))
    jobs = [
        (name, size, np.random.SeedSequence(seed, spawn_key=(i, k)))
        for i, name in enumerate(plans)
        for k, size in enumerate(_sizes(number))
    ]
    done = _run(shared, jobs, workers, progress)
    found = []
    for name in plans:
        parts = [d for job, d in zip(jobs, done, strict=True) if job[0] == name]
        found.append(_collected(study, truth, name, shared[name], parts))
    return tuple(found)


def _random_campaigns(
    study: Study,
    truth: ComplianceModel,
    known: MonteCarlo,
    plans: int,
    reality: Reality,
    progress: Progress | None,
) -> RandomCampaigns:
    """Campaigns of random plans, as those of the plans that are `known`.

    A plan is as many load cases as it has experiments, uniform in the joint ranges, rejected where
    a constraint is broken.
    """
    tell, rng = progress or (lambda what, share: None), np.random.default_rng([known.seed, 1])
    m, each = known.plans[0].experiments, max(2, -(-known.number // plans))
    space, once = study.space, np.ones(m, dtype=np.int64)
    pool = space.sample(min(plans * m, _POOL), rng)
    order = rng.permutation(len(pool)) if len(pool) == plans * m else None
    rho0, total = [], []
    for r in range(plans):
        chosen = rng.integers(0, len(pool), m) if order is None else order[r * m : (r + 1) * m]
        plan = {"random": (space.load_cases(pool[chosen]), once)}
        seed = int(rng.integers(2**31))
        how = known.how
        try:
            one = campaigns(study, truth, plan, each, seed=seed, how=how, reality=reality).plans[0]
        except (IdentifiabilityError, InputError):  # of this plan: the others went well
            continue
        rho0.append(one.rho0)
        total.append(one.total)
        tell("random plans", (r + 1) / plans)
    if not rho0:
        raise IdentifiabilityError(
            f"none of {plans} random plans of {m} experiments tells the compliances apart"
        )
    return RandomCampaigns(m, plans, frozen(rho0), frozen(total))


def _check(study: Study, truth: ComplianceModel, number: int, how: Fit) -> None:
    missing = [name for name in study.sought.names if name not in truth.names]
    if missing:
        does = "identifies" if missing[0] in study.springs.names else "knows"
        raise InputError(f"the truth says nothing of {missing[0]}, which the study {does}")
    if number < 2:
        raise InputError(f"the number of campaigns must be at least 2, found {number}")
    if how.robust or how.nonnegative:
        raise InputError("many campaigns are fitted by plain least squares, without bounds")


def _design(
    study: Study,
    truth: ComplianceModel,
    ideal: VirtualReadings,
    cases: LoadCases,
    repeats: IntArray,
    how: Fit,
) -> Design:
    free = np.array([truth.names.index(name) for name in study.sought.names])
    return Design(
        arm=ideal.arm,
        free=free,
        start=truth.compliance,
        cases=cases,
        case=np.repeat(np.arange(len(cases)), repeats),
        covariance=ideal.covariance,
        common=ideal.common,
        linear=how.linear,
        known=rows_known(study),
        near=None if how.linear else deflection_series(ideal.arm, truth.compliance, cases, free),
    )


def _sizes(number: int) -> list[int]:
    """Sizes of the chunks."""
    return [min(CHUNK, number - start) for start in range(0, number, CHUNK)]


def _run(
    shared: dict[str, _Plan],
    jobs: list[tuple[str, int, np.random.SeedSequence]],
    workers: int,
    tell: Progress,
) -> list[tuple[Array, Array, Array]]:
    """The results of all chunks, in order."""
    done: list[tuple[Array, Array, Array]] = []
    parts = [
        (name, own[i : i + _PART])
        for name in shared
        for own in [[(size, seed) for plan, size, seed in jobs if plan == name]]
        for i in range(0, len(own), _PART)
    ]
    with several_cores(workers):
        results = dealt(_part, [(shared[name], chunks) for name, chunks in parts])
        for (name, _), result in zip(parts, results, strict=True):
            done += result
            tell(name, len(done) / len(jobs))
    return done


def _part(
    work: tuple[_Plan, list[tuple[int, np.random.SeedSequence]]],
) -> list[tuple[Array, Array, Array]]:
    """The results of some chunks of a plan."""
    plan, chunks = work
    return [_chunk(plan, size, seed) for size, seed in chunks]


def _chunk(plan: _Plan, size: int, seed: np.random.SeedSequence) -> tuple[Array, Array, Array]:
    """Estimates, standard errors and errors at the test poses of so many campaigns of a plan."""
    rng = np.random.default_rng(seed)
    readings = _readings(plan, size, rng)
    true = plan.compliance[plan.design.free]
    fitted = fit_all(plan.design, readings, drawn(true, plan.design.known, size, rng))
    variance = np.ones(size)
    if plan.how.estimates_sigma:
        variance = fitted.chi_square / plan.design.dof
    diagonal = variance[:, None] * np.diagonal(fitted.covariance, axis1=1, axis2=2)
    if len(plan.design.known):  # what was known keeps its own noise: see `covariance_of`
        moved = fitted.covariance @ plan.design.known.T
        diagonal = diagonal + (1.0 - variance[:, None]) * np.sum(moved**2, axis=2)
    error = np.sqrt(diagonal)
    left = np.stack([errors_left(one, fitted.compliance) for one in plan.judges], axis=1)
    return fitted.compliance, error, left


def _readings(plan: _Plan, size: int, rng: np.random.Generator) -> Array:
    """(C, N, T, 3) what is read in `size` campaigns [m, rad]."""
    case, ideal, cases = plan.design.case, plan.ideal, plan.design.cases
    by_noise, by_load, by_outlier = rng.spawn(3)
    many = np.tile(case, size)
    true = ideal.deflection[many]
    load_error, outliers = plan.reality.load_error, plan.reality.outliers
    if load_error.size or load_error.direction:
        wrench = disturbed(cases.wrench[many], load_error, by_load)
        acting = LoadCases(cases.q[many], wrench)
        true = deflections(ideal.arm, plan.compliance, acting, plan.reality.linear)
    read = true + noise(ideal.covariance, many, by_noise, ideal.common)
    if outliers.share:
        read = read + gross_errors(read.shape, outliers, by_outlier, plan.lever)
    return np.asarray(read.reshape(size, len(case), *read.shape[1:]))


def _collected(
    study: Study,
    truth: ComplianceModel,
    name: str,
    plan: _Plan,
    parts: list[tuple[Array, Array, Array]],
) -> Campaigns:
    """The campaigns of a plan with what the plan alone predicts for them."""
    estimate, error, left = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    design = plan.design
    covariance = predicted_covariance(design)
    poses = study.test_poses
    weight = study.shares
    loss = sum(w * p.regressor.T @ p.regressor for w, p in zip(weight, poses, strict=True))
    dof = float(design.dof) if plan.how.estimates_sigma else np.inf
    truth_of = truth.of(study.sought.names)
    width = quantile(0.975, dof)
    scale = np.sqrt(np.diagonal(covariance))
    root = np.linalg.cholesky(covariance / np.outer(scale, scale)) * scale[:, None]
    squares = np.maximum(np.linalg.eigvalsh(root.T @ loss @ root), 0.0)
    return Campaigns(
        name=name,
        experiments=len(design.case),
        truth=frozen(truth_of),
        estimate=frozen(estimate),
        standard_error=frozen(error),
        inside=frozen(np.abs(estimate - truth_of) <= width * error, np.bool_),
        covariance=frozen(covariance),
        error=frozen(left),
        weight=frozen(weight),
        squares=frozen(squares),
        rho0_each=frozen(
            [np.sqrt(np.trace(p.regressor @ covariance @ p.regressor.T)) for p in poses]
        ),
    )
