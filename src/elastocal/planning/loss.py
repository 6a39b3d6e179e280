"""Loss: what is left of a plan if one of its configurations is lost.

A beam that breaks unseen, a wrong nest or a bump spoils all that is measured in one configuration,
and in those near it.

In: a study, load cases with repeats and their information. Out: the configuration that is missed
most, and ρ0 without it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.matrices import rank_of
from elastocal.planning.aim import accuracy
from elastocal.planning.near import near_configurations
from elastocal.study.study import Study


@dataclass(frozen=True)
class AfterLoss:
    """A plan without the configuration that is missed most.

    Attributes:
        load_case: Number of its first load case, from 1.
        rho0: ρ0 without it, or what is promised then [m]; infinite where compliances are not told
            apart any more.
    """

    load_case: int
    rho0: float


def loss_of(study: Study, cases: LoadCases, repeats: IntArray) -> AfterLoss:
    """The configuration that is missed most of S load cases, each measured (S,) `repeats` times.

    Load cases of near joint values are one.

    Source: ours.
    """
    aim = accuracy(study)
    each = aim.informations(cases, repeats)
    total = aim.before(cases, repeats) + each.sum(axis=0)
    group = near_configurations(study.robot, cases.q)
    worst = AfterLoss(1, 0.0)
    for g in range(int(group.max(initial=-1)) + 1):
        own = group == g
        left = total - each[own].sum(axis=0)
        known = rank_of(left, scale=total) == len(left)
        rho0 = aim.loss(float(aim.criterion.value(left[None])[0])) if known else float("inf")
        if rho0 > worst.rho0:
            worst = AfterLoss(int(np.flatnonzero(own)[0]) + 1, rho0)
    return worst
