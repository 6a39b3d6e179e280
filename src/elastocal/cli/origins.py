"""What is said of files that were made from something else than there is here.

Imported by the commands when they run.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from elastocal.errors import InputError
from elastocal.names import LONGEST
from elastocal.wording import worded
from elastocal.wording.lists import springs_in_short

if TYPE_CHECKING:
    from elastocal.errors import Doubt
    from elastocal.files.plans.proposal_file import Proposal
    from elastocal.measuring.measurements import Measurements
    from elastocal.planning.certificate import Certificate
    from elastocal.study.known import Known
    from elastocal.study.study import Study


def note_origin(name: str, proposal: Proposal, study: Study, known: Known | None = None) -> None:
    """Say on standard error if a plan was made from something else, or changed since.

    Args:
        name: What the plan is called.
        proposal: The plan.
        study: The study as it is written.
        known: What is known of further springs where the plan is judged.
    """
    notes = [f"was made {other}" for other in _others(proposal, study)]
    if proposal.edited:
        notes.append("has other load cases than it was written with")
    if proposal.named != proposal.criterion:
        notes.append(
            f"was made for what version 0.1.0 called {proposal.named}; it is judged by that, which "
            f"is {proposal.criterion!r} now"
        )
    if proposal.known is not None:
        notes += _on_known(proposal.known, study, known)
    elif known is not None and proposal.claims.get("rho0") is not None:
        notes.append(
            f"was made as if {', '.join(known.model.names)} did not bend; it is judged by what "
            f"{known.source} knows of them"
        )
    for note in notes:
        print(f"note: {name} {note}", file=sys.stderr)


def _others(proposal: Proposal, study: Study) -> list[str]:
    """What a plan was made from that is not what there is here."""
    from elastocal.files.plans.plan_file import study_hash

    found = []
    if proposal.study_hash and proposal.study_hash != study_hash(study):
        found.append("from another version of the study")
    if proposal.robot_hash and proposal.robot_hash != study.robot.sha256:
        found.append("with another robot file")
    for path, digest in study.path_hashes.items():
        if proposal.path_hashes.get(path, digest) != digest:
            found.append(f"for another content of {path}")
    prior = study.prior_file[1]
    if proposal.prior_hash and prior and proposal.prior_hash != prior:
        found.append(f"after another prior {'plan' if study.earlier is None else 'model'}")
    return found


def _names(known: Known) -> str:
    springs = known.model.springs
    return ", ".join(springs_in_short(springs.names, springs.of_joints))


def _on_known(known: Known, study: Study, here: Known | None) -> list[str]:
    """What is to be said of what a plan knew of further springs."""
    joints = _names(known)
    if here is None:
        return [
            f"was made by what {known.source} knows of {joints}; it is judged as if they did not "
            "bend"
        ]
    if here.sha256 != known.sha256:
        return [
            f"was made when {known.source} was another file; it is judged by what {here.source} "
            f"knows of {_names(here)} now"
        ]
    return [] if study.known is not None else [f"counts what {known.source} knows of {joints}"]


def note_before(name: str, proposal: Proposal, shown: Proposal) -> None:
    """Say on standard error if a plan counts other experiments before it than the one shown."""
    own, other = proposal.done, shown.done
    if (own and own.sha256) == (other and other.sha256):
        return
    counted = f"{other.experiments} experiments" if other else "no experiments"
    print(
        f"note: {name} is judged with {counted} measured before it, as {shown.name} was made; it "
        f"was made with {own.experiments if own else 'none'}",
        file=sys.stderr,
    )


def note_proof(name: str, certificate: Certificate, doubt: Doubt | None) -> None:
    """Say on standard error if a proof that a plan claims does not count.

    Args:
        name: What the plan is called.
        certificate: The certificate that was made anew, with what counts as proved.
        doubt: What is to be said of the record; None if no proof is claimed.
    """
    if doubt is None or certificate.proved is not None:
        return
    said = worded(doubt)
    if doubt.code == "proof-not-checked":
        said = "it claims a proof that the bound made anew refutes, so that it does not count"
    print(f"note: {name}: {said}", file=sys.stderr)


def refuse_false_claims(name: str, proposal: Proposal, study: Study) -> None:
    """Refuse a plan that claims what the study it was made from does not give.

    What was made from something else is not compared with this: that is said, see `note_origin`.

    Raises:
        InputError: the first claim that does not hold.
    """
    from elastocal.files.plans.proposal_file import study_for
    from elastocal.planning.assessment import assess
    from elastocal.planning.evaluation import false_claims

    judged = study_for(proposal, study)
    known = None if judged.known is None else judged.known.sha256
    if _others(proposal, study) or known != (proposal.known and proposal.known.sha256):
        return
    worth = assess(judged, proposal.load_cases, proposal.repeats)
    for doubt in false_claims(judged, worth, proposal.claims):
        raise InputError(
            f"{name}: {worded(doubt)}, so it was changed after planning; load cases that are "
            "changed by hand are a run sheet (CSV), which claims nothing"
        )


def note_measurements(path: Path, data: Measurements, *, fitted: bool = False) -> None:
    """Say on standard error if a model names measurements otherwise than they are.

    Args:
        path: The model.
        data: Measurements that are not those it names, by their hash.
        fitted: Whether the model follows from them all the same.
    """
    from elastocal.files.models.model_file import model_sections, readings_in

    origin = model_sections(path)["provenance"].get("measurements") or {}
    name, digest = Path(origin.get("name", "")).name[:LONGEST], origin.get("sha256", "")
    if not digest or digest == data.sha256:
        return
    if fitted:
        note = (
            f"follows from {data.source}, but names other measurements under provenance: "
            f"{name!r}, sha256 {digest[:16]}…"
        )
    elif {*data.readings} & {*readings_in(path)}:
        note = f"counts readings of {data.source} already: they are no test of it"
    elif name == Path(data.source).name[:LONGEST]:
        note = (
            f"was made from another content of {name} than it has now (sha256 {digest[:16]}… "
            f"there, {data.sha256[:16]}… here): one of them was changed"
        )
    else:
        return
    print(f"note: {path.name} {note}", file=sys.stderr)


def note_model(path: Path, study: Study) -> None:
    """Say on standard error if a model was made with another version of the study."""
    from elastocal.files.models.model_file import model_sections
    from elastocal.files.plans.plan_file import study_hash

    origin = model_sections(path)["provenance"].get("study") or {}
    if origin.get("sha256") and study.text and origin["sha256"] != study_hash(study):
        print(f"note: {path.name} was made with another version of the study", file=sys.stderr)
