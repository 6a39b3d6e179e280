"""What a plan achieves, in plain sentences.

In: plan, random plans. Out: words and the few numbers that matter most.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.planning.aim import is_for_promise
from elastocal.planning.certificate import Certificate
from elastocal.planning.plan import Plan
from elastocal.study.left_rigid import counted as counted_in
from elastocal.study.study import Study
from elastocal.wording import ended, worded
from elastocal.wording.lists import counted, springs_in_short
from elastocal.wording.numbers import given, length, length_and_unit, number, percent, small
from elastocal.wording.plans import NOT_TRIED, floor_sentence, missed, only_of, searched
from elastocal.wording.promises import promise_sentences
from elastocal.wording.proofs import NOT_AGAIN, at_most, proof_sentences, proved_length


@dataclass(frozen=True)
class Tile:
    """One number that matters.

    Attributes:
        name: What it is.
        value: The number with its unit.
        meaning: One sentence.
    """

    name: str
    value: str
    meaning: str


@dataclass(frozen=True)
class Verdict:
    """The first thing one reads.

    Attributes:
        work: What is to be done.
        rho0: The figure of merit, number and unit apart.
        promised: Whether it is the promise, with errors of load cases, and not ρ0.
        meaning: What that number is.
        tiles: The next few numbers.
        proof: Sentences about the certificate.
        advice: Sentences about what limits the plan's worth.
    """

    work: str
    rho0: tuple[str, str]
    promised: bool
    meaning: str
    tiles: tuple[Tile, ...]
    proof: tuple[str, ...]
    advice: tuple[str, ...]


def only(plan: Plan) -> str:
    """Of which springs ρ0 is, if others bend at the test poses."""
    return only_of(counted_in(plan.study), plan.doubts, plan.study.robot.joint_names)


def _turned(study: Study) -> str:
    """The noise of a rotation, if it is measured."""
    sigma = study.instrument.sigma_rotation
    return "" if sigma is None else f", rotations {small(sigma, 'rad')}"


def verdict(plan: Plan, random: Array | None) -> Verdict:
    """What `plan` achieves; `random` (K,) are errors of random plans [m]."""
    study, rho0 = plan.study, plan.assessment.rho0
    m, s = plan.count, len(plan.load_cases)
    work = (
        f"{counted(m, 'experiment')} in {counted(s, 'configuration')}, "
        f"to identify {counted(len(study.springs), _unknown(study))}"
    )
    where = "at the test pose" if len(study.test_poses) == 1 else "at the test poses"
    if study.only_path is not None:
        where = f"along the {len(study.only_path.cases)} points of {study.only_path.name}"
    meaning = (
        f"Root mean square position error that is left {where} after compensation, "
        f"because measurements are noisy (σ\u00a0=\u00a0{given(study.sigma)} per axis"
        f"{_turned(study)}){only(plan)}. It is the share of the calibration alone: repeatability, "
        "geometry and temperature come on top."
    )
    headline = plan.assessment.promised
    if headline != rho0:
        meaning += (
            " It is what is promised: errors of loads, friction and what no model explains count "
            f"in the readings; without them ρ₀ would be {length(rho0)}."
        )
    return Verdict(
        work,
        length_and_unit(headline),
        headline != rho0,
        meaning,
        tuple(_tiles(plan, random)),
        tuple(proof(plan.certificate, m)),
        tuple(_advice(plan)),
    )


def proof(certificate: Certificate, count: int) -> list[str]:
    """What kind of certificate it is, of a plan of `count` experiments, in honest words."""
    if certificate.stopped:
        return [f"The plan has no certificate: {NOT_TRIED}. A better plan is possible."]
    if certificate.kind == "none":
        return [
            f"Criterion {certificate.criterion} has no certificate: it is not concave, so no bound "
            "on other plans exists, and a better plan is possible."
        ]
    c = certificate
    proved = proof_sentences(c, count)
    beside = "The bound of the search rests on a numerical certificate" if proved else ""
    sentences = [
        *([proved[0], " ".join((*proved[1:], NOT_AGAIN))] if proved else []),
        f"{beside or 'Numerical certificate'}: "
        + searched(c.fresh_starts, c.attained, c.narrow_starts, c.narrow_attained, c.rarest),
        f"{missed(c.missed)} It rests on that search, not on a proof.",
    ]
    if certificate.floored:
        sentences.append(
            f"{floor_sentence(c.left_out)} The bound itself is "
            "for the criterion without the floor; what the floor costs is part of the efficiency."
        )
    return sentences


def bound_of(plan: Plan) -> float | None:
    """Lower bound on ρ0 [m] if the certificate speaks of ρ0."""
    return plan.certificate.rho0_bound or None


def _tiles(plan: Plan, random: Array | None) -> list[Tile]:
    """Bound, efficiency, random plans, instrument: as far as they are known."""
    certificate, m = plan.certificate, plan.count
    rho0, promised = plan.assessment.rho0, plan.assessment.promised
    bound, before = bound_of(plan), bool(np.any(plan.study.prior))
    tiles = []
    if promised != rho0:
        meaning = "Without errors of load cases."
        if not certificate.promise:
            meaning = "Without errors of load cases; bound and efficiency speak of it."
        tiles.append(Tile("ρ₀", length(rho0), meaning))
    if bound is not None:
        tiles += _bounds(certificate, bound, m)
    if np.isfinite(certificate.efficiency):
        saved = max(0.0, 100.0 * (1.0 - certificate.efficiency))
        under = "" if bound is not None else f" under criterion {certificate.criterion}"
        meaning = f"At best {number(saved, 2)} % of the experiments could be saved{under}."
        if before:  # nothing of what is known was an experiment of this plan
            gain = 100.0 * (1.0 - np.sqrt(min(certificate.efficiency, 1.0)))
            meaning = f"At most {number(gain, 2)} % to gain in the error{under}."
        if saved < 0.01:
            meaning = f"There is nothing left to gain{under}."
        meaning = f"{meaning} {_by(certificate, in_error=before)}"
        tiles.append(Tile("Efficiency", percent(certificate.efficiency), meaning))
    if random is not None and len(random) and np.isfinite(promised):
        factor = float(np.median(random)) / promised
        if np.isfinite(factor):
            meaning = "Median error of random feasible plans over this one."
            if not before:
                times = number(factor**2, 2)
                meaning += f" A random plan would need about {times} times as many experiments."
            tiles.append(Tile("Against random", f"{number(factor, 2)} ×", meaning))
        else:
            meaning = "More than half of all random plans cannot tell the compliances apart."
            tiles.append(Tile("Against random", "∞", meaning))
    loss = plan.assessment.loss
    if loss is not None and np.isfinite(rho0):
        what = "ρ₀" if plan.assessment.promise is None else "Promised"
        meaning = f"{what} without configuration {loss.load_case}, which is missed most"
        if np.isfinite(loss.rho0):
            meaning += f": {number(loss.rho0 / promised, 2)} times as much."
        else:
            meaning += ": the rest does not tell the compliances apart."
        tiles.append(Tile("After a loss", length(loss.rho0), meaning))
    return tiles


def _bounds(certificate: Certificate, bound: float, count: int) -> list[Tile]:
    """The bound of the search, or the one that is proved, if one is."""
    every = f"No plan with {counted(count, 'experiment')} can do better"
    if certificate.proved is None:
        meaning = f"{every}, as far as a search finds: a numerical bound, not proved."
        return [Tile("Lower bound", length(bound), meaning)]
    proved = certificate.proved.loss
    meaning = f"{every}: a theorem about the model. By a search, not proved: {length(bound, 4)}."
    return [Tile("Proved bound", proved_length(proved), meaning)]


def _by(certificate: Certificate, *, in_error: bool) -> str:
    """What the share that could be gained rests on: in the error, or in experiments."""
    proved = certificate.proved
    if proved is None or not np.isfinite(proved.efficiency):
        return "By a search, not proved."
    share = np.sqrt(proved.efficiency) if in_error else proved.efficiency
    return f"By a search; proved is {at_most(1.0 - float(share))} at most."


def _advice(plan: Plan) -> list[str]:
    """What a reader should know before trusting ρ0."""
    sentences = []
    if not plan.assessment.identifiable:
        sentences.append(
            "These experiments do not tell all compliances apart. Use more or other configurations."
        )
    sentences += promise_sentences(
        plan.assessment.rho0, plan.assessment.promise, made_for_it=is_for_promise(plan.study)
    )
    sentences += [ended(worded(doubt)) for doubt in plan.doubts]
    if plan.study.known is not None:
        known = plan.study.known
        how = "promised by" if known.planned else "found in"
        springs = known.model.springs
        names = ", ".join(springs_in_short(springs.names, springs.of_joints))
        sentences.append(
            f"{names} bend as well: their errors, as {how} "
            f"{known.source or 'an earlier campaign'}, count in every number."
        )
    wanted = plan.study.wanted
    if np.any(plan.study.prior[np.ix_(wanted, wanted)]):
        sentences.append("What was known before these experiments is counted in every number.")
    return sentences


def _unknown(study: Study) -> str:
    """What is identified, one of it."""
    return "unknown" if study.experiments.weighs else "compliance"
