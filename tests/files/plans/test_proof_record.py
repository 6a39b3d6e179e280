"""Records of proofs beside plans: they count if they are of the study and show what is claimed."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from elastocal.design.exact import Effort
from elastocal.errors import InputError, PlanFileError
from elastocal.files.plans.document import document_of
from elastocal.files.plans.plan_file import plan_document
from elastocal.files.plans.proof_record import proof_beside, statement_of
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.files.study.study_file import parse_study
from elastocal.planning.aim import aim_of
from elastocal.planning.certificate import with_proof
from elastocal.planning.evaluation import evaluate
from elastocal.planning.plan import Plan
from elastocal.planning.proved import Proved
from elastocal.proof.plain_data import as_data
from elastocal.wording import worded
from tests.cli.test_commands import STUDY
from tests.proof.statements import chance


@cache
def plan() -> Plan:
    study = parse_study(STUDY, Path("study.yaml"))
    return ec.plan(study, effort=Effort(batch=8, generations=2, islands=1))


def record(**changed: Any) -> bytes:
    """A record that says what the plan claims; its tree is of no interest here."""
    made = plan()
    said = {
        "study_sha256": hashlib.sha256(made.study.text.encode()).hexdigest(),
        "criterion": "test-pose",
        "count": 3,
        "rho0": 0.9 * made.certificate.lower_bound,
        "largest": 1.0,
    }
    statement = replace(chance(np.random.default_rng(0)), **(said | changed))
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w", zipfile.ZIP_LZMA) as archive:
        archive.writestr("statement.json", json.dumps(as_data(statement)))
        archive.writestr("tree", b"\xff")
    return file.getvalue()


@cache
def claimed() -> str:
    """The plan with a proof of .9 of its bound."""
    made = plan()
    loss = 0.9 * made.certificate.lower_bound
    known = Proved(loss, loss / 0.9, 1.0, 9, 0.5, "reached", (), "plan.proof", "?")
    proved = with_proof(made.certificate, aim_of(made.study), known)
    return json.dumps(plan_document(replace(made, certificate=proved)))


def written(
    folder: Path, data: bytes, change: Callable[[dict[str, Any]], None] = lambda _: None
) -> Path:
    """The same as a file, with its record beside it."""
    document = json.loads(claimed())
    document["certificate"]["proved"]["sha256"] = hashlib.sha256(data).hexdigest()
    change(document)
    (folder / "plan.proof").write_bytes(data)
    (folder / "plan.json").write_text(json.dumps(document), encoding="utf-8")
    return folder / "plan.json"


def counted(folder: Path) -> tuple[bool, str]:
    """Whether the proof of the plan there counts, and what is said of it."""
    study = plan().study
    proved, doubt = proof_beside(read_proposal(folder / "plan.json", study), study, folder)
    assert doubt is not None
    return proved is not None, worded(doubt)


def test_a_record_that_shows_what_is_claimed_counts(tmp_path: Path) -> None:
    path = written(tmp_path, record())
    assert counted(tmp_path) == (
        True,
        "its record plan.proof is of this study and says what the plan claims; the boxes in it "
        "were not bounded again here: 'elastocal check-proof plan.proof' does that",
    )
    again = ec.read_plan(path)
    assert again.certificate.kind == "rigorous"
    assert again.certificate.proved is not None
    assert again.certificate.gap == pytest.approx(0.1, rel=1e-4)


OTHERS: dict[str, Callable[[], bytes]] = {
    "it is of plans of 4 experiments": lambda: record(count=4),
    "it is of the criterion worst": lambda: record(criterion="worst"),
    "it is of another study": lambda: record(study_sha256="0" * 64),
    "it shows a smaller bound": lambda: record(rho0=0.89 * plan().certificate.lower_bound),
    "shows: it shows a smaller bound": lambda: record(rho0=None, largest=None),
    "it is none": lambda: b"nothing",
}


@pytest.mark.parametrize("words", OTHERS)
def test_a_record_of_something_else_does_not(words: str, tmp_path: Path) -> None:
    written(tmp_path, OTHERS[words]())
    found, said = counted(tmp_path)
    assert not found
    assert words in said
    assert said.endswith("so the proof does not count")


def test_a_record_that_is_lost_or_changed_does_not(tmp_path: Path) -> None:
    written(tmp_path, record())
    (tmp_path / "plan.proof").write_bytes(record() + b" ")
    assert counted(tmp_path)[0] is False
    assert "another file" in counted(tmp_path)[1]
    (tmp_path / "plan.proof").unlink()
    assert "is not beside it" in counted(tmp_path)[1]
    assert ec.read_plan(tmp_path / "plan.json").certificate.kind == "numerical"

    def elsewhere(document: dict[str, Any]) -> None:
        document["certificate"]["proved"]["record"] = "../plan.proof"

    (tmp_path / "deep").mkdir()
    written(tmp_path / "deep", record(), elsewhere)
    (tmp_path / "deep" / "plan.proof").replace(tmp_path / "plan.proof")
    assert "is not beside it" in counted(tmp_path / "deep")[1]


def test_without_a_claim_nothing_is_said(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(json.dumps(plan_document(plan())), encoding="utf-8")
    study = plan().study
    proposal = read_proposal(tmp_path / "plan.json", study)
    assert proof_beside(proposal, study, tmp_path) == (None, None)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("lower_bound_mm", -1.0, "lower_bound_mm"),
        ("lower_bound_mm", "much", "lower_bound_mm"),
        ("reachable_mm", 1e-9, "above reachable"),
        ("reachable_mm", None, "reachable"),
        ("ended", "soon", "ended"),
        ("boxes", 0.5, "boxes"),
        ("efficiency", 2.0, "efficiency"),
        ("record", "a\nb", "record"),
        ("doubts", [{"code": "proof-best-noise", "numbers": {"sigma": "?"}}], "sigma"),
    ],
)
def test_a_claim_that_makes_no_sense_is_refused(
    key: str, value: Any, words: str, tmp_path: Path
) -> None:
    path = written(tmp_path, record(), lambda d: d["certificate"]["proved"].update({key: value}))
    with pytest.raises(PlanFileError, match=words):
        document_of(path.read_text(encoding="utf-8"), path)


def test_a_kind_goes_with_what_is_proved(tmp_path: Path) -> None:
    for change in (
        lambda d: d["certificate"].update(kind="numerical"),
        lambda d: d["certificate"].pop("proved"),
    ):
        path = written(tmp_path, record(), change)
        with pytest.raises(PlanFileError, match="of kind 'rigorous' if, and only if"):
            document_of(path.read_text(encoding="utf-8"), path)


def test_doubts_that_nobody_knows_are_left_out(tmp_path: Path) -> None:
    doubts = [{"code": "of-later"}, {"code": "proof-best-noise"}, {"code": "proof-without-errors"}]
    path = written(tmp_path, record(), lambda d: d["certificate"]["proved"].update(doubts=doubts))
    proved = read_proposal(path, plan().study).claims["proved"]
    assert [doubt.code for doubt in proved.left_out] == ["proof-without-errors"]


@pytest.mark.parametrize(("share", "count"), [(0.9, 0), (1.0, 0), (1.001, 1), (1.2, 1)])
def test_a_claimed_proof_is_tried(share: float, count: int) -> None:
    """Against a design that is known, as every bound is: no proof is above what it reaches."""
    made = plan()
    assert made.bound is not None
    loss = share * made.certificate.lower_bound
    claims = {"kind": "rigorous", "proved": Proved(loss, loss, 1.0, 9, 0.5, "reached")}
    found = evaluate(made.study, made.load_cases, made.repeats, claims, made.bound)
    assert len(found.objections) == count
    if count:
        assert found.objections[0].code == "claims-proved"
        assert "so that there is no such proof" in worded(found.objections[0])
    assert "certificate-unknown" not in {doubt.code for doubt in found.remarks}


def test_statements_are_read_with_care() -> None:
    path = Path("plan.proof")
    assert statement_of(record(), path).count == 3
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("statement.json", "{}")
        archive.writestr("tree", "")
    for data in (b"", b"PK", record()[:200], file.getvalue()):
        with pytest.raises(InputError, match=r"plan\.proof: not the record of a proof"):
            statement_of(data, path)
