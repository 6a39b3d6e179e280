"""Standing: what decides between plans that can lose something and plans that cannot.

In: a study, load cases with repeats. Out: what they promise, what is left after a loss, what stays
unseen, and how long they take.
"""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.arrays import IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.motion.schedule import fastest
from elastocal.planning.aim import accuracy
from elastocal.planning.blind_sums import BlindSums, blind_sums
from elastocal.planning.loss import loss_of
from elastocal.study.study import Study


@dataclass(frozen=True)
class Standing:
    """Where a plan stands.

    Attributes:
        promised: ρ0, or what it promises [m].
        lost: The same without the configuration that is missed most [m]; infinite where the rest
            does not tell compliances apart.
        blind: Largest blind error of what some load case of the study shows [m]; None if unknown.
        minutes: How long it takes at the cell [min].
    """

    promised: float
    lost: float
    blind: float | None
    minutes: float


def asked_standing(study: Study, cases: LoadCases, repeats: IntArray) -> Standing:
    """Where load cases stand by what the study asks for; see `standing`."""
    wish = study.experiments.robust
    sums = blind_sums(study, cases) if wish is not None and wish.sees else None
    return standing(study, cases, repeats, sums)


def standing(study: Study, cases: LoadCases, repeats: IntArray, sums: BlindSums | None) -> Standing:
    """Where S load cases stand, each measured (S,) `repeats` times, in the order that is fastest.

    Args:
        study: The study.
        cases: S load cases.
        repeats: (S,) repeats.
        sums: What decides on blind errors; None if they are not asked for.
    """
    aim = accuracy(study)
    found = aim.loss(float(aim.criterion.value(aim.total(cases, repeats)[None])[0]))
    blind = None
    if sums is not None:
        total = sums.informations(cases, repeats).sum(axis=0)
        blind = float(sums.worst(total[None], len(cases))[0])
    return Standing(
        promised=found,
        lost=loss_of(study, cases, repeats).rho0,
        blind=blind,
        minutes=fastest(cases, repeats, study.pace).total / 60.0,
    )
