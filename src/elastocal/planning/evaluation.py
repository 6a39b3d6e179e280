"""Evaluation: what a plan is really worth, from the study alone.

In: a study and load cases somebody proposes, with what is claimed of them. Out: an assessment, a
certificate from a bound computed anew, and every objection. The planner's word is not trusted.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.twins import twins
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt
from elastocal.motion.margins import Vias, motion_violations
from elastocal.planning.aim import aim_of
from elastocal.planning.assessment import (
    Assessment,
    assess,
    broken_on_the_way,
    search_stopped,
)
from elastocal.planning.blind import BlindErrors, blind_errors
from elastocal.planning.certificate import (
    KINDS,
    Bound,
    Certificate,
    certificate,
    confirmed,
    worth_by,
)
from elastocal.planning.false_promise import AGREE, claim_of, differ, false_promise
from elastocal.planning.visibility import Visibility, visibility
from elastocal.study.criteria import CRITERIA
from elastocal.study.identifiability import unidentifiable
from elastocal.study.study import Experiments, Study, with_load_cases

_ROUNDED = 1e-9  # efficiencies above 1 by less are rounding


@dataclass(frozen=True)
class Evaluation:
    """A proposed plan, judged.

    Attributes:
        repeats: (S,) how often each of its load cases is measured.
        assessment: What it is worth.
        certificate: How far it can be from the best, by a bound of its own count.
        objections: Every broken constraint and every claim that does not hold.
        unidentified: The groups of compliances it does not tell apart.
        remarks: What is odd about it, but holds: load cases that tell the same.
        collisions: Motions between configurations that are not allowed; objections, too.
        view: What the tracker sees in every configuration; None if there is no tracker.
        measured: Whether it is a campaign that was measured, and no plan.
        blind: What it cannot see of what the model lacks; None if that is not known.
    """

    repeats: IntArray
    assessment: Assessment
    certificate: Certificate
    objections: tuple[Doubt, ...]
    unidentified: tuple[Doubt, ...]
    remarks: tuple[Doubt, ...] = ()
    collisions: tuple[Doubt, ...] = ()
    view: Visibility | None = None
    measured: bool = False
    blind: BlindErrors | None = None

    @property
    def count(self) -> int:
        """Number of experiments m."""
        return int(self.repeats.sum())

    @property
    def accepted(self) -> bool:
        """Whether there is no objection."""
        return not self.objections and not self.unidentified


def evaluate(
    study: Study,
    cases: LoadCases,
    repeats: IntArray,
    claims: dict[str, Any],
    bound: Bound,
    via: Vias | None = (),
    *,
    asked: Experiments | None = None,
) -> Evaluation:
    """Judge load cases against a study.

    Args:
        study: The study.
        cases: S load cases.
        repeats: (S,) repeats.
        claims: What is claimed: rho0 [m], lower_bound [m], efficiency, standard_error by joint,
            covariance as names and a matrix, criteria and promise by name, in SI; kind of the
            certificate, its criterion, and what is proved; stopped_after, a number of generations,
            and unchecked, what else the plan says that nothing here depends on.
        bound: Bound for this study and as many experiments.
        via: Configurations passed on the way, see `motion.Vias`; None: motions are not judged.
        asked: What the study itself asks for, to remark on plans of more; None: not said.
    """
    study = with_load_cases(study, repeats)
    worth = assess(study, cases, repeats)
    x = bound.aim.space.points(cases)
    bound = confirmed(study, bound, x, np.random.default_rng(0))
    proof = certificate(study, bound, worth, study.experiments.count)
    open_ends = unidentifiable(study.fitted.names, worth.information)
    collisions = () if via is None else motion_violations(study.motion_space, cases.q, via)
    passing, _ = broken_on_the_way(study, via or ())
    claimed = (
        *false_claims(study, worth, claims, proof),
        *_false_bounds(study, worth, claims, bound, proof),
    )
    objections = [*worth.violations, *passing, *collisions, *claimed]
    view = visibility(study.space, cases.q)
    repeats = frozen(repeats, np.int64)
    remarks = (
        *search_stopped(claims.get("stopped_after")),
        *_same_information(study, cases, repeats),
        *_beyond(study, repeats, asked),
        *_unchecked(claims),
    )
    return Evaluation(
        repeats,
        worth,
        proof,
        tuple(objections),
        open_ends,
        remarks,
        collisions,
        view,
        blind=blind_errors(study, cases, repeats),
    )


def _same_information(study: Study, cases: LoadCases, repeats: IntArray) -> Iterator[Doubt]:
    """Load cases that could be one, measured more often."""
    for group in twins(study.space.information(cases), repeats, study.prior):
        if len(group) > 1:
            names = tuple(str(i + 1) for i in group)
            numbers = {"repeats": int(repeats[group].sum())}
            yield Doubt("same-information", names, numbers=numbers)


def _beyond(study: Study, repeats: IntArray, asked: Experiments | None) -> Iterator[Doubt]:
    """More experiments or configurations than the study asks for."""
    if asked is None:
        return
    count = int(repeats.sum()) + (0 if study.done is None else study.done.experiments)
    most = asked.max_configurations
    if count > asked.count:
        yield Doubt("more-experiments", numbers={"count": count, "asked": asked.count})
    if most is not None and len(repeats) > most:
        yield Doubt("more-configurations", numbers={"count": len(repeats), "asked": most})


def _unchecked(claims: dict[str, Any]) -> Iterator[Doubt]:
    """What a plan says that is not held against anything."""
    kind = claims.get("kind", "numerical")
    if kind not in KINDS:
        yield Doubt("certificate-unknown", (kind,))
    if claims.get("unchecked"):
        yield Doubt("claims-unchecked", tuple(claims["unchecked"]))


def false_claims(
    study: Study, worth: Assessment, claims: dict[str, Any], proof: Certificate | None = None
) -> Iterator[Doubt]:
    """Claims that do not hold, but for those that only a bound made anew refutes.

    Args:
        study: The study, as the plan was made for it.
        worth: What the plan is worth by it.
        claims: What is claimed, see `evaluate`.
        proof: A certificate made anew; None is quick, then what is claimed of the best plan must
            not be refuted by this one.
    """
    m = study.experiments.count
    if claims.get("experiments", m) != m:
        yield claim_of("claims-experiments", claims["experiments"], m)
    if "rho0" in claims and differ(claims["rho0"], worth.rho0, AGREE):
        yield claim_of("claims-rho0", claims["rho0"], worth.rho0)
    yield from _false_at_test_poses(study, worth, claims)
    if worth.promise is not None:
        yield from false_promise(study, worth.promise, claims)
    errors = dict(zip(study.springs.names, worth.standard_error.tolist(), strict=True))
    for name, claimed in claims.get("standard_error", {}).items():
        if name not in errors:
            yield Doubt("claims-unknown-error", (name,))
        elif differ(claimed, errors[name], AGREE):
            yield claim_of("claims-error", claimed, errors[name], name)
    if claims.get("covariance") is not None:
        yield from _false_covariance(study, worth, *claims["covariance"])
    yield from _false_criteria(study, worth, claims.get("criteria", {}))
    certified = claims.get("certified", study.criterion)
    if certified != study.criterion:
        yield Doubt("claims-other-criterion", (certified, study.criterion))
    if proof is None:  # what is claimed of the best plan must not be refuted by this one
        aim = aim_of(study)
        own = aim.loss(worth_by(aim, worth)) if aim.promise else worth.criteria[study.criterion]
        promised = claims.get("lower_bound", 0.0)
        if CRITERIA[study.criterion].is_position_error and promised > own * (1.0 + AGREE):
            yield claim_of("claims-bound", promised, own)
        least = aim.loss(worth_by(aim, worth))
        yield from _false_proof(study, claims, least * (1.0 + AGREE))
        if claims.get("efficiency", 0.0) > 1.0 + _ROUNDED:
            yield claim_of("claims-efficiency", claims["efficiency"], 1.0)


def _false_bounds(
    study: Study, worth: Assessment, claims: dict[str, Any], bound: Bound, proof: Certificate
) -> Iterator[Doubt]:
    """Bound and efficiency that are claimed, and refuted by a design that is known.

    A claim between that design and the bound is not refuted: the search has not closed that gap.
    """
    promised, efficiency = claims.get("lower_bound", 0.0), claims.get("efficiency", 0.0)
    if bound.design is None:
        if efficiency > 0.0 or claims.get("proved") is not None:
            yield Doubt("claims-no-bound", (study.criterion,), numbers={"claimed": efficiency})
        return
    m = study.experiments.count
    reached = float(bound.aim.criterion.value(bound.design.total[None])[0])
    beyond = beyond_reach(bound, m, proof.lower_bound)
    if proof.position_bound is not None and promised > beyond:
        yield claim_of("claims-bound", promised, proof.position_bound)
    yield from _false_proof(study, claims, beyond)
    most = min(worth_by(bound.aim, worth) / (m * reached), 1.0)
    if efficiency > max(most, proof.efficiency) * (1.0 + 2.0 * AGREE):
        yield claim_of("claims-efficiency", efficiency, proof.efficiency)


def beyond_reach(bound: Bound, count: int, found: float = 0.0) -> float:
    """No bound on plans of `count` experiments is above this: a design that is known reaches it.

    Args:
        bound: A bound that a search made.
        count: Number of experiments.
        found: The bound on the loss that is stated; nobody is refuted by less.
    """
    if bound.design is None:
        return float("inf")
    reached = float(bound.aim.criterion.value(bound.design.total[None])[0])
    return max(bound.aim.loss(count * reached), found) * (1.0 + bound.aim.tolerance)


def _false_proof(study: Study, claims: dict[str, Any], in_reach: float) -> Iterator[Doubt]:
    """A proof that is claimed of a loss above what is in reach."""
    proved = claims.get("proved")
    if proved is not None and proved.loss > in_reach:
        unit = "m" if CRITERIA[study.criterion].is_position_error else ""
        numbers = {"claimed": proved.loss, "found": in_reach}
        yield Doubt("claims-proved", numbers=numbers, unit=unit)


def _false_at_test_poses(
    study: Study, worth: Assessment, claims: dict[str, Any]
) -> Iterator[Doubt]:
    """Errors at the test poses that the study has, and at the worst points of its paths."""
    each, worst = claims.get("rho0_each", {}), claims.get("worst_point", {})
    for pose, rho0, point in zip(
        study.test_poses, worth.rho0_each, worth.worst_points, strict=True
    ):
        if pose.name in each and differ(each[pose.name], rho0, AGREE):
            yield claim_of("claims-rho0-at", each[pose.name], rho0, pose.name)
        largest = None if point is None else point.rho0
        if largest is not None and differ(worst.get(pose.name, largest), largest, AGREE):
            yield claim_of("claims-worst-point", worst[pose.name], largest, pose.name)


def _false_covariance(
    study: Study, worth: Assessment, names: Sequence[str], claimed: Array
) -> Iterator[Doubt]:
    """A covariance (p, p) of other springs, or of other values; the worst of them is said."""
    if unknown := tuple(name for name in names if name not in study.fitted.names):
        yield Doubt("claims-unknown-error", unknown[:1])
        return
    index = [study.fitted.names.index(name) for name in names]
    found = worth.covariance[np.ix_(index, index)]
    if not np.isfinite(found).all():
        yield claim_of("claims-error", float(np.sqrt(claimed[0, 0])), float("inf"), names[0])
        return
    scale = np.sqrt(np.diagonal(found))
    off = np.abs(claimed - found) / np.outer(scale, scale)
    if off.max() > 2.0 * AGREE:
        i, j = divmod(int(off.argmax()), len(names))
        yield claim_of(
            "claims-covariance", claimed[i, j], found[i, j], *dict.fromkeys((names[i], names[j]))
        )


def _false_criteria(study: Study, worth: Assessment, claimed: dict[str, float]) -> Iterator[Doubt]:
    """Values of criteria that are others, in one doubt; those of the standard errors are."""
    found = {name: worth.criteria[name] for name in claimed}
    wrong = tuple(name for name in found if differ(claimed[name], found[name], AGREE))
    if wrong:
        first = wrong[0]
        numbers = {"claimed": claimed[first], "found": found[first]}
        yield Doubt("claims-criteria", wrong, (), numbers, CRITERIA[first].unit(study.springs))
