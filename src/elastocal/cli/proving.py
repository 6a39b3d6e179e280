"""Proving bounds as several commands do it: foretold, with progress, kept in a file as it grows.

Imported by the commands when they run.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.cli.ending import undisturbed
from elastocal.cli.planning import write_pair
from elastocal.cli.stopping import SearchEnd, ended_by
from elastocal.core.library import library
from elastocal.errors import InputError
from elastocal.files.plans.proof_record import LARGEST, SUFFIX, proof_beside, statement_of
from elastocal.files.texts import text_hash
from elastocal.planning.aim import aim_of
from elastocal.planning.certificate import (
    Bound,
    certificate,
    confirmed,
    with_proof,
    worth_by,
)
from elastocal.planning.plan import Plan
from elastocal.planning.proved import Proved
from elastocal.proof.posing import refuse
from elastocal.reading import bytes_of
from elastocal.study.criteria import CRITERIA
from elastocal.study.study import Study
from elastocal.terminal.progress import progress_and_lines
from elastocal.wording.numbers import length, number
from elastocal.wording.proofs import (
    at_most,
    corrected_sentence,
    foretold,
    going_on,
    nothing_proved,
    proved_length,
    so_far,
)
from elastocal.writing import write_bytes

if TYPE_CHECKING:
    from elastocal.elastic.load_cases import LoadCases
    from elastocal.files.plans.proposal_file import Proposal
    from elastocal.planning.evaluation import Evaluation
    from elastocal.proof.prove import Progress, Proof
    from elastocal.proof.statement import Statement
    from elastocal.proof.tree import Region

AGAIN = 3
"""How often a bound that a proof refutes is made and proved again."""


@dataclass(frozen=True)
class Proving:
    """How a bound is to be proved.

    Attributes:
        seconds: How long it may take.
        gap: How near to the bound of the search is near enough, as a share.
        record: The file with the record.
        force: Whether to write over any file, and to begin anew.
    """

    seconds: float
    gap: float
    record: Path
    force: bool = False


def record_of(plan: Path, named: Path | None, *, more: str = "") -> Path:
    """Where the record of a proof goes: to the file that is named, else beside the plan."""
    return named or plan.with_suffix(f"{more}{SUFFIX}")


def refuse_unprovable(study: Study, how: Proving) -> None:
    """Refuse before any work is done what cannot be proved here, or not into that file.

    Raises:
        InputError: there is no compiled core, of the study there is no proof, or the file is no
            record of a proof, or one of another study.
    """
    if library() is None:
        raise InputError(
            "--prove needs the compiled core, which is not here; 'elastocal --version' says why. "
            "Proofs that there are can be checked without it"
        )
    refuse(study, study.space)
    if how.force or not how.record.exists():
        return
    found = statement_of(bytes_of(how.record, LARGEST), how.record)
    hint = "choose another file with --proof, or begin anew with --force"
    if found.study_sha256 != text_hash(study.text):
        raise InputError(f"{how.record}: is the proof of another study, {found.name!r}; {hint}")
    if (found.count, found.criterion) != (aim_of(study).count, study.criterion):
        raise InputError(
            f"{how.record}: is a proof of {found.count} experiments by {found.criterion}; {hint}"
        )


def proved_plan(
    made: Plan, out: Path, how: Proving, again: Callable[[Bound], Plan] | None = None
) -> Plan:
    """The plan with what could be proved of its bound, written.

    A bound that the proof refutes is made again, and so is the plan, which stays if it is better.

    Args:
        made: The plan.
        out: Where it is written.
        how: How to prove.
        again: Plans again for a bound.
    """
    study, bound = made.study, made.bound
    if bound is None or bound.design is None:
        print("note: there is no bound to be proved: the search was stopped", file=sys.stderr)
        return made

    def other(better: Bound) -> Array:
        nonlocal made
        worth = certificate(study, better, made.assessment, made.count)
        made = replace(made, certificate=worth, bound=better)
        if again is not None:
            found, aim = again(better), better.aim
            if worth_by(aim, found.assessment) > worth_by(aim, made.assessment):
                made = found
        return study.space.points(made.load_cases)

    points = bound.aim.space.points(made.load_cases)
    bound, proof = proved_bound(study, bound, points, how, other)
    if proof is not None:
        numerical = certificate(study, bound, made.assessment, made.count)
        made = replace(made, certificate=with_proof(numerical, bound.aim, proof), bound=bound)
    write_pair(made, out)
    return made


def proved_bound(
    study: Study,
    bound: Bound,
    points: Array,
    how: Proving,
    corrected: Callable[[Bound], Array],
) -> tuple[Bound, Proved | None]:
    """The bound, made again if a proof refutes it, and what could be proved of it.

    Args:
        study: The study.
        bound: A bound that a search made.
        points: (K, d) design points of plans, which no proof may exclude.
        how: How to prove.
        corrected: Told a bound that was made again; gives the points of what are plans then.
    """
    from elastocal.proof.tree import symbols_of

    left = how.seconds
    for attempt in range(AGAIN):
        proof = _proof(study, bound, points, replace(how, seconds=left), fresh=attempt > 0)
        left = max(left - proof.seconds, 0.0)
        better = _refuted(study, bound, proof)
        if better is None:
            break
        _say_corrected(study, bound, better)
        points, bound = corrected(better), better
        if attempt + 1 == AGAIN or left == 0.0:  # what was proved is true of any bound
            break
    if proof.loss <= 0.0:
        print(f"note: {nothing_proved(proof.ended)}", file=sys.stderr)
        return bound, None
    assert proof.statement.largest is not None
    return bound, Proved(
        loss=proof.loss,
        reachable=proof.numerical,
        largest=proof.statement.largest,
        boxes=len(symbols_of(proof.tree)),
        seconds=proof.seconds,
        ended=proof.ended,
        left_out=proof.doubts,
        record=how.record.name,
        sha256=hashlib.sha256(bytes_of(how.record, LARGEST)).hexdigest(),
    )


def proved_for(
    study: Study, bound: Bound, cases: LoadCases, how: Proving
) -> tuple[Bound, Proved | None]:
    """The same for load cases that somebody proposes."""
    points = bound.aim.space.points(cases)
    known = points[bound.aim.space.feasible(points)]
    bound = confirmed(study, bound, known, np.random.default_rng(0)) if len(known) else bound
    return proved_bound(study, bound, points, how, lambda _: points)


def with_what_is_proved(result: Evaluation, bound: Bound, proved: Proved | None) -> Evaluation:
    """A judged plan with what was proved of its bound."""
    if proved is None:
        return result
    feasible = not result.assessment.violations
    found = with_proof(result.certificate, bound.aim, proved, feasible=feasible)
    return replace(result, certificate=found)


def with_claimed_proof(
    result: Evaluation, proposal: Proposal, study: Study, folder: Path
) -> Evaluation:
    """A judged plan with what is to be said of a proof that its file claims."""
    _, doubt = proof_beside(proposal, study, folder)
    return result if doubt is None else replace(result, remarks=(*result.remarks, doubt))


def _proof(study: Study, bound: Bound, points: Array, how: Proving, *, fresh: bool) -> Proof:
    """One proof, kept in its file now and then, and at its end."""
    from elastocal.proof.prove import prove
    from elastocal.proof.record import proof_bytes, read_proof

    def keep(statement: Statement, root: Region) -> None:
        with undisturbed():
            write_bytes(how.record, proof_bytes(statement, root))

    on = how.record.exists() and not fresh and not how.force
    with progress_and_lines("proof") as (tell, stay):
        end = SearchEnd(tell)
        steps = _Steps(study, bound, stay)
        with ended_by(end):
            proof = prove(
                study,
                bound,
                known=points,
                seconds=how.seconds,
                gap=how.gap,
                progress=partial(steps.told, end.tell),
                predicted=lambda expected: stay(foretold(expected)),
                stop=end,
                resumed=read_proof(how.record) if on else None,
                proved=lambda _, loss: steps.reached(loss),
                saved=keep,
            )
            keep(proof.statement, proof.tree)
        steps.reached(proof.loss)
    return proof


class _Steps:
    """What is proved, step by step, as lines."""

    def __init__(self, study: Study, bound: Bound, say: Callable[[str], None]) -> None:
        criterion = CRITERIA[study.criterion]
        self._say, self._said, self._gap = say, 0.0, 1.0
        self._is_length, self._bound = criterion.is_position_error, bound.loss(bound.aim.count)
        self._so_far = partial(
            so_far,
            "a promise" if bound.aim.promise else criterion.symbol,
            bound.aim.count,
            bound=self._bound,
            is_length=self._is_length,
        )

    def told(self, tell: Callable[[str, float], None], now: Progress) -> None:
        """What goes on."""
        known = ""
        if now.loss > 0.0:
            known = proved_length(now.loss) if self._is_length else f"all but {at_most(self._gap)}"
        tell(going_on(now.gap, now.left, now.boxes, known), now.done)

    def reached(self, loss: float) -> None:
        """A line, if more is proved than was said before."""
        if loss > self._said:
            self._said, self._gap = loss, max(1.0 - loss / self._bound, 0.0)
            self._say(self._so_far(loss=loss))


def _refuted(study: Study, bound: Bound, proof: Proof) -> Bound | None:
    """A bound made again that knows what the proof found; None if that refutes nothing."""
    if not len(proof.refuted) or bound.design is None:
        return None
    design, space = bound.design, bound.aim.space
    dual, n = design.certificate, proof.refuted.shape[1]
    # Loads are those that the search knows as good: what climbs from there finds the best one.
    best = dual.x_found[np.argsort(-dual.s_found)[:_LOADS], n:]
    loads = np.concatenate([best, design.x[:, n:]])
    around = _within(proof.refuted, space.limits, study.robot.prismatic)
    x = np.array([np.concatenate([q, load]) for q in around for load in loads])
    x = x[space.feasible(x)]
    if not len(x):
        return None
    with progress_and_lines("bound") as (tell, _):
        tell("a load case that refutes it", 0.0)
        found = confirmed(study, bound, x, np.random.default_rng(0))
    if found.design is None or found.design.certificate.gradient is dual.gradient:
        return None
    same = np.array_equal(found.design.certificate.gradient, dual.gradient)
    return None if same else found


def _within(q: Array, limits: Array, slides: BoolArray) -> Array:
    """(K, n) configurations with joints that turn brought into their limits by whole turns."""
    turn = 2.0 * np.pi
    above = np.ceil(np.maximum(q - limits[1], 0.0) / turn)
    below = np.ceil(np.maximum(limits[0] - q, 0.0) / turn)
    return np.where(slides, q, q + turn * (below - above))


_LOADS = 20


def _say_corrected(study: Study, before: Bound, after: Bound) -> None:
    shown = length if CRITERIA[study.criterion].is_position_error else number
    m = before.aim.count
    said = corrected_sentence(shown(before.loss(m), 5), shown(after.loss(m), 5))
    print(f"note: {said}", file=sys.stderr)
