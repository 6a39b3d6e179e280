"""Accuracy against time: ρ0 over the hours of a campaign, for few or many configurations.

In: a study with its pace. Out: curves of plans with their hours.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.exact import Effort
from elastocal.errors import IdentifiabilityError
from elastocal.planning.certificate import Bound
from elastocal.planning.plan import Plan, plan
from elastocal.study.study import Study, with_count


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


def curve_of(plans: Sequence[Plan], configurations: int | None) -> TimeCurve:
    """The curve of plans that are there."""
    return TimeCurve(
        configurations,
        frozen([p.count for p in plans], "int64"),
        frozen([p.schedule.hours for p in plans]),
        frozen([p.assessment.rho0 for p in plans]),
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
                plans.append(plan(wanted, seed=seed, effort=effort, bound=bound))
            except IdentifiabilityError:
                continue
        if plans:
            curves.append(curve_of(plans, most))
    return tuple(curves)
