"""Carried: a plan of which a single configuration carries the result, where another need not.

In: a study that does not say what plans are to withstand, load cases with repeats. Out: that one of
them carries the result, with what nearly as good load cases would leave, by a quick exchange.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from elastocal.arrays import IntArray
from elastocal.design.exact import ExactDesign
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt
from elastocal.planning.aim import accuracy
from elastocal.planning.assessment import Assessment
from elastocal.planning.exchange import Held
from elastocal.planning.plain_values import simplify
from elastocal.planning.robust import CARRIED, PROPOSED, pays, robust
from elastocal.planning.standing import standing
from elastocal.study.criteria import RHO0
from elastocal.study.study import Study

_SHARE = 0.3  # of the load cases that a robust plan tries


def one_carries(study: Study, worth: Assessment) -> bool:
    """Whether one configuration of a plan for ρ0 carries the result, and nobody asked about it."""
    asked = study.experiments.robust is not None or study.criterion != RHO0.name
    loss = worth.loss
    return not asked and loss is not None and loss.rho0 > CARRIED * worth.promised


def carried(
    study: Study, cases: LoadCases, repeats: IntArray, worth: Assessment, best: float | None
) -> Iterator[Doubt]:
    """That one configuration carries the result, if load cases nearly as good need none that does.

    Nothing is said where repeats share errors: mends say what other configurations are worth there.

    Args:
        study: The study.
        cases: S load cases.
        repeats: (S,) repeats.
        worth: What they are worth.
        best: No plan has a smaller ρ0 [m]; None if that is not known.
    """
    count = int(repeats.sum())
    if best is None or not one_carries(study, worth) or count < 3:
        return
    experiments = replace(study.experiments, count=count, max_configurations=None)
    aim = accuracy(replace(study, experiments=experiments))
    if aim.shares:
        return
    design = ExactDesign(aim.space.points(cases), repeats, 0.0)
    rng, held = np.random.default_rng(0), Held(loss=PROPOSED * best)
    made = robust(aim, aim.space, aim.goal(), design, held, rng, _SHARE)
    plain = simplify(aim.space, aim.space.load_cases(made.x)).cases
    now, other = (standing(study, *p, None) for p in ((cases, repeats), (plain, made.counts)))
    if pays(now, other):
        assert worth.loss is not None
        numbers = {
            "promised": now.promised,
            "lost": now.lost,
            "other_promised": other.promised,
            "other_lost": other.lost,
            "asked": PROPOSED,
            "configurations": len(made.counts),
            "allowed": study.experiments.distinct,
            "minutes": other.minutes - now.minutes,
        }
        yield Doubt("one-carries", (str(worth.loss.load_case),), numbers=numbers)
