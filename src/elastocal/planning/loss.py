"""Loss: what is left of a plan if one of its configurations is lost.

A beam that breaks unseen, a wrong nest or a bump spoils all that is measured in one configuration,
and in those near it.

In: a study, load cases with repeats and their information. Out: the configuration that is missed
most, and ρ0 without it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.matrices import rank_of
from elastocal.planning.near import near_configurations
from elastocal.study.criteria import RHO0
from elastocal.study.study import Study


@dataclass(frozen=True)
class AfterLoss:
    """A plan without the configuration that is missed most.

    Attributes:
        load_case: Number of its first load case, from 1.
        rho0: ρ0 without it [m]; infinite where compliances are not told apart any more.
    """

    load_case: int
    rho0: float


def loss_of(
    study: Study, cases: LoadCases, repeats: IntArray, each: Array, total: Array
) -> AfterLoss:
    """The configuration that is missed most; load cases of near joint values are one.

    Args:
        study: The study.
        cases: S load cases.
        repeats: (S,) repeats.
        each: (S, f, f) information of each, measured once.
        total: (f, f) information of all, prior included.

    Source: ours.
    """
    group = near_configurations(study.robot, cases.q)
    worst = AfterLoss(1, 0.0)
    for g in range(int(group.max(initial=-1)) + 1):
        own = group == g
        left = total - np.einsum("i,ijk->jk", repeats[own].astype(float), each[own])
        known = rank_of(left, scale=total) == len(left)
        rho0 = float(RHO0.loss(study, left)) if known else float("inf")
        if rho0 > worst.rho0:
            worst = AfterLoss(int(np.flatnonzero(own)[0]) + 1, rho0)
    return worst
