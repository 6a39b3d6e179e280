"""Robust: a plan of which no single configuration carries the result, and little stays unseen.

In: a plan that is as good as can be, what it is to withstand. Out: one that holds the limits and
is as good as can be, or that sees as much as can be for what it may cost: load cases are exchanged
for random ones, then all are stirred at smaller and smaller scales.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.exact import ExactDesign
from elastocal.design.refinement import Goal
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt, InputError
from elastocal.planning.aim import Aim
from elastocal.planning.assessment import Assessment
from elastocal.planning.blind_effects import judged
from elastocal.planning.blind_sums import BlindSums, blind_sums
from elastocal.planning.certificate import Certificate
from elastocal.planning.exchange import Exchange, Exchanged, Held
from elastocal.planning.plain_values import Plain, simplify, without_whole_turns
from elastocal.planning.pool import anywhere
from elastocal.planning.pool import stirred as stirred_near
from elastocal.planning.standing import Standing, standing
from elastocal.study.criteria import RHO0
from elastocal.study.experiment_space import LoadCaseSpace
from elastocal.study.study import Study

_POOL, _MANY = 1000, 3000  # random load cases; blind errors have many maxima
_STIRRED, _OFTEN = 60, 300  # of each load case, likewise
_SCALES = (0.1, 0.03, 0.01)  # shares of the ranges by which load cases are stirred
_FINEST = 0.003  # the same of the last stirring, where blind errors count
_STARTS = 3  # of searches for small blind errors
_SOFT, _SHARP = 12.0, 40.0  # powers of the norm in place of the largest, if that is limited
_FEW = 8  # unknowns up to which so many are tried
_NEARLY = 1.0 + 1e-3  # a limit that is passed by less is held
CARRIED = 1.5
"""A configuration carries the result if without it so many times as much is left; ours."""
PROPOSED = 1.25
"""Times the best that a plan may leave without any configuration, of one that need not; ours."""
_LITTLE = 1.02  # times ρ0, or the promise, that this may cost where nobody asks for it
_MUCH = 0.8  # of what is left after a loss that it must come to then
_LONGER = 1.1  # times the minutes at the cell that it may take then


def least_loss(distinct: int) -> float:
    """How many times the best ρ0 a plan of so many configurations leaves at least without one.

    Source: ours; a concave φ of the mean over what is left is at least the mean of φ. It holds
    where nothing is known before.
    """
    return float(np.sqrt(distinct / (distinct - 1.0))) if distinct > 1 else float("inf")


def refuse_unfit(study: Study) -> None:
    """Raises:
    InputError: a robust plan is asked for by another criterion than ρ0, or blind errors count and
        are not known.
    """
    wish = study.experiments.robust
    if wish is None:
        return
    if study.criterion != RHO0.name:
        raise InputError(
            f"robust speaks of ρ0: the criterion must be {RHO0.name}, found {study.criterion!r}"
        )
    if wish.sees and not judged(study):
        raise InputError(
            "robust: blind errors are not known where all test poses are given as matrices; give "
            "joint values and a force"
        )


def not_held(
    study: Study, worth: Assessment, proof: Certificate, blind: float | None
) -> Iterator[Doubt]:
    """What a plan does not hold of what the study asks for.

    Args:
        study: The study.
        worth: What the plan is worth.
        proof: Its certificate.
        blind: Its largest blind error [m]; None if that is not known.
    """
    wish, loss, least = study.experiments.robust, worth.loss, proof.rho0_bound
    if wish is None:
        return
    if wish.blind is not None and blind is not None and blind > wish.blind * _NEARLY:
        yield Doubt("blind-above", numbers={"found": blind, "asked": wish.blind})
    if least is None:
        return
    if wish.within is not None and worth.promised > wish.within * least * _NEARLY:
        yield Doubt("rho0-above", numbers={"times": worth.promised / least, "asked": wish.within})
    if wish.loss is None or loss is None or loss.rho0 <= wish.loss * least * _NEARLY:
        return
    distinct = study.experiments.distinct
    numbers = {"times": loss.rho0 / least, "asked": wish.loss, "configurations": distinct}
    if not study.prior.any():
        numbers["least"] = least_loss(distinct)
    yield Doubt("loss-above", numbers=numbers)


class Withstanding(NamedTuple):
    """A plan that withstands what is asked for, and where the one before it stood."""

    design: ExactDesign
    plain: Plain
    as_good: Standing


def withstanding(
    study: Study,
    aim: Aim,
    space: LoadCaseSpace,
    goal: Goal,
    design: ExactDesign,
    before: tuple[LoadCases, IntArray],
    best: float,
    rng: np.random.Generator,
) -> Withstanding | None:
    """The plan that a study asks for which says what plans are to withstand.

    One that knows nuisance and limits no configurations gets a plan of which none carries the
    result, too, where that costs little.

    Args:
        study: The study.
        aim: What plans are to be good for.
        space: The part of its space that is searched.
        goal: What the search optimised.
        design: The plan that is as good as can be.
        before: Its load cases and repeats, as they would be carried out.
        best: No plan has a smaller ρ0, or promise [m].
        rng: Of random load cases.
    """
    wish = study.experiments.robust
    if wish is None:
        now = standing(study, *before, None)
        if not _by_default(study) or now.lost <= CARRIED * now.promised:
            return None
        made = robust(aim, space, goal, design, Held(loss=PROPOSED * best), rng)
        plain = in_plain_values(aim.space, made.x, None)
        other = standing(study, plain.cases, made.counts, None)
        paid = pays(now, other) and other.minutes <= _LONGER * now.minutes
        return Withstanding(made, plain, now) if paid else None
    sums = blind_sums(study, before[0]) if wish.sees else None
    within, loss = (None if share is None else share * best for share in (wish.within, wish.loss))
    made = robust(aim, space, goal, design, Held(within, loss, wish.blind, sums), rng)
    return Withstanding(
        made, in_plain_values(aim.space, made.x, sums), standing(study, *before, sums)
    )


def pays(now: Standing, other: Standing) -> bool:
    """Whether a plan that costs little more loses much less."""
    less = np.isfinite(other.lost) and other.lost <= _MUCH * now.lost
    return bool(less and other.promised <= _LITTLE * now.promised)


def _by_default(study: Study) -> bool:
    """Whether a study leaves it to us how many configurations there are, and whether one is dear.

    Without nuisance plans are the best for ρ0, as ever.
    """
    limited = study.experiments.max_configurations is not None
    absolute = study.experiments.weighs  # what counts there, `relieved` sees to
    named = study.criterion == RHO0.name
    return study.nuisance is not None and not limited and named and not absolute


def robust(
    aim: Aim,
    space: LoadCaseSpace,
    goal: Goal,
    design: ExactDesign,
    held: Held,
    rng: np.random.Generator,
    share: float = 1.0,
) -> ExactDesign:
    """The design after the moves.

    Args:
        aim: What plans are to be good for.
        space: The part of its space that is searched.
        goal: What the search optimised, for the value of the design.
        design: The plan to begin with.
        held: What it is to hold.
        rng: Of random load cases.
        share: Of the load cases that are tried, for a quick look.
    """
    seen = held.sums is not None
    few = share * min(1.0, (_FEW / space.parameters) ** 2)  # of many unknowns fewer are tried
    many, often = (round(few * size) for size in ((_MANY, _OFTEN) if seen else (_POOL, _STIRRED)))

    soft = _SOFT if held.blind is None else _SHARP

    def stirred(x: Array, counts: IntArray, scales: tuple[float | None, ...]) -> Exchanged:
        for scale in scales:
            if scale is None:
                more = anywhere(space, many, rng)
            else:
                more = stirred_near(space, x, max(often, 10), scale, rng)
            pool = in_plain_values(aim.space, np.concatenate([x, more]), held.sums).cases
            power = soft if seen and scale != _FINEST else np.inf
            found = Exchange(aim, pool, held, power).exchanged(counts)
            x, counts = found.x, found.counts
        return found

    begun = [
        stirred(design.x, design.counts, (None, *_SCALES)) for _ in range(_STARTS if seen else 1)
    ]
    x, counts, _ = min(begun, key=lambda found: found.cost)
    if seen:
        x, counts, _ = stirred(x, counts, (_FINEST, *_SCALES, _FINEST))
    order = np.argsort(-counts, kind="stable")
    x, counts = x[order], frozen(counts[order], np.int64)
    return replace(design, x=x, counts=counts, value=float(goal.values(x[None], counts[None])[0]))


def in_plain_values(space: LoadCaseSpace, x: Array, sums: BlindSums | None) -> Plain:
    """Load cases of design points (S, d) in plain values.

    What changes nothing of ρ0 may change what is seen of foot and station: where blind errors count
    it stays as it is.
    """
    cases = space.load_cases(x)
    if sums is None:
        return simplify(space, cases)
    return Plain(without_whole_turns(space, cases), (), "")
