"""How a plan compares: with random plans, and with more or fewer experiments or configurations.

In: a study. Out: ρ0 of random feasible plans; ρ0 over the number of experiments and of
configurations, with the bound as a line, and over hours. What a user needs to decide how much to
measure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.exact import Effort
from elastocal.design.space import information
from elastocal.errors import IdentifiabilityError
from elastocal.planning.aim import accuracy, aim_of
from elastocal.planning.certificate import Bound, Progress, lower_bound
from elastocal.planning.plan import Plan, plan
from elastocal.study.study import Study, with_count

LIGHT = Effort(batch=48, generations=6, patience=2, islands=1)
"""A shorter search: a curve needs many plans, each within about a tenth of a percent."""
_LIGHTER = Effort(batch=16, generations=2, patience=1, islands=1)  # promises, with many unknowns


@dataclass(frozen=True)
class TimeCurve:
    """Plans of more and more experiments.

    Attributes:
        configurations: Most distinct configurations of each plan; None for as many as help.
        counts: (K,) numbers of experiments.
        hours: (K,) hours at the cell from home to home.
        rho0: (K,) ρ0 [m].
    """

    configurations: int | None
    counts: IntArray
    hours: Array
    rho0: Array


@dataclass(frozen=True)
class TradeOff:
    """ρ0 over what a campaign costs.

    Attributes:
        counts: (K,) numbers of experiments.
        rho0: (K,) ρ0 of a plan for each [m].
        bound: (K,) no plan of as many experiments has a smaller ρ0 [m]; NaN if unknown.
        configurations: (L,) numbers of distinct configurations, at the study's own count.
        rho0_configurations: (L,) ρ0 of a plan for each [m].
        by_time: ρ0 over hours, with few, the study's own and any number of configurations.
    """

    counts: IntArray
    rho0: Array
    bound: Array
    configurations: IntArray
    rho0_configurations: Array
    by_time: tuple[TimeCurve, ...] = ()


def trade_off(
    study: Study,
    *,
    seed: int = 0,
    counts: Sequence[int] | None = None,
    most_configurations: int = 6,
    progress: Progress | None = None,
) -> TradeOff:
    """ρ0 over the number of experiments and of configurations.

    Args:
        study: The study; its own count is always among those planned.
        seed: Seed of every search.
        counts: Numbers of experiments; a spread around the study's own if None, half and twice as
            many where it plans for a promise.
        most_configurations: Up to how many configurations.
        progress: Told what is going on.
    """
    own, promise = study.experiments.count, aim_of(study).promise
    usual = (max(own // 2, 1), 2 * own) if promise else (1, 2, 3, 4, 6, 8, 12, 16, 24)
    effort = _LIGHTER if promise else LIGHT
    wanted = sorted({*(counts or usual), own})
    tell = progress or (lambda what, share: None)
    limits = range(1, min(own, most_configurations) + 1)
    steps = len(wanted) + len(limits)
    kept: list[tuple[int, float, float]] = []
    many: list[Plan] = []
    bound = _bound_for_all(study, seed)
    for i, m in enumerate(wanted):
        tell(f"{m} experiments", i / steps)
        # Configurations are not limited here: the two curves answer separate questions.
        try:
            found = plan(with_count(study, m), seed=seed, effort=effort, bound=bound)
        except IdentifiabilityError:
            continue
        if not found.assessment.identifiable:
            continue
        lowest = found.certificate.rho0_bound
        kept.append((m, found.assessment.promised, np.nan if lowest is None else lowest))
        many.append(found)
    few: list[tuple[int, float]] = []
    for i, s in enumerate(limits):
        tell(f"{s} configurations", (len(wanted) + i) / steps)
        try:
            found = plan(with_count(study, own, s), seed=seed, effort=effort, bound=bound)
        except IdentifiabilityError:
            continue
        if found.assessment.identifiable:
            few.append((s, found.assessment.promised))
    tell("hours", 0.95)
    # The fewest configurations that will do, and as many as the study wants.
    limited = {s for s, _ in few[:1]} | {study.experiments.max_configurations} - {None}
    by_time = time_trade_off(
        study,
        configurations=sorted(s for s in limited if s is not None),
        counts=(max(own // 2, 1), own, 2 * own),
        seed=seed,
        effort=effort,
        bound=bound,
    )
    tell("trade-off", 1.0)
    table, short = np.array(kept).reshape(-1, 3), np.array(few).reshape(-1, 2)
    return TradeOff(
        counts=frozen(table[:, 0], np.int64),
        rho0=frozen(table[:, 1]),
        bound=frozen(table[:, 2]),
        configurations=frozen(short[:, 0], np.int64),
        rho0_configurations=frozen(short[:, 1]),
        by_time=(*by_time, curve_of(many, None)) if many else by_time,
    )


def _bound_for_all(study: Study, seed: int) -> Bound | None:
    """A bound to be used for every number of experiments; None where each needs its own.

    On promises it would be one for each, and take longer than the plans: those have none here.
    """
    aim = aim_of(study)
    if aim.promise:
        return Bound(aim, aim.criterion, None, stopped=True)
    return None if np.any(study.prior) else lower_bound(study, np.random.default_rng(seed))


_POOL = 20_000  # random load cases that random plans are drawn from
_MANY = 2_000


def random_plans(study: Study, number: int, *, seed: int = 0) -> Array:
    """(number,) ρ0, or promise, of random feasible plans with as many experiments as the study [m].

    Uniform in the joint ranges, rejected where a constraint is broken; infinite where a plan
    does not identify what the test poses need.
    """
    rng = np.random.default_rng(seed)
    aim = accuracy(study)
    space, m = aim.space.measured_together(1.0), aim.count
    pool = information(space.evaluate(space.sample(min(number * m, _POOL), rng)).blocks)
    drawn = min(m, _MANY)  # the mean of thousands is as good as that of millions
    totals = np.array([pool[rng.integers(0, len(pool), drawn)].sum(axis=0) for _ in range(number)])
    values = aim.criterion.value(aim.base + totals * (m / drawn))
    return np.array([aim.loss(value) for value in values])


def curve_of(plans: Sequence[Plan], configurations: int | None) -> TimeCurve:
    """The curve of plans that are there."""
    return TimeCurve(
        configurations,
        frozen([p.count for p in plans], "int64"),
        frozen([p.schedule.hours for p in plans]),
        frozen([p.assessment.promised for p in plans]),
    )


def time_trade_off(
    study: Study,
    *,
    configurations: Sequence[int | None],
    counts: Sequence[int],
    seed: int = 0,
    effort: Effort | None = None,
    bound: Bound | None = None,
) -> tuple[TimeCurve, ...]:
    """ρ0 over hours, one curve for each number of configurations.

    Plans that cannot identify the compliances are left out, and curves without any plan.

    Args:
        study: The study; its own counts do not matter.
        configurations: Most distinct configurations of each curve; None for any number.
        counts: Numbers of experiments.
        seed: Seed of every search.
        effort: How long to search.
        bound: Bound known before, to be used again.
    """
    curves = []
    for most in configurations:
        plans = []
        for count in sorted(set(counts)):
            wanted = with_count(study, count, None if most is None else min(most, count))
            try:
                made = plan(wanted, seed=seed, effort=effort, bound=bound)
            except IdentifiabilityError:
                continue
            if made.assessment.identifiable:
                plans.append(made)
        if plans:
            curves.append(curve_of(plans, most))
    return tuple(curves)
