"""`check-proof`: verified or not, and never by the core."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from elastocal.proof import check_proof
from elastocal.proof.check_proof import ProofVerdict
from tests.cli.test_commands import run
from tests.files.plans.test_proof_record import record

RIGHT = ProofVerdict(True, True, 9, 9, "verified, complete")
PART = ProofVerdict(False, False, 9, 4, "not verified, only sampled: 4 of 9 leaves")


@pytest.fixture
def proof(tmp_path: Path) -> Path:
    path = tmp_path / "plan.proof"
    path.write_bytes(record(left_out=("A2 against A5",), name="cell \x1b[2J"))
    return path


def by_hand(monkeypatch: pytest.MonkeyPatch, verdict: ProofVerdict) -> dict[str, Any]:
    """A checker that finds this; what it is asked for."""
    asked: dict[str, Any] = {}

    def check(path: Path, *, progress: Any, **options: Any) -> ProofVerdict:
        asked.update(options, name=path.name)
        progress(verdict.checked, verdict.leaves)
        return verdict

    monkeypatch.setattr(check_proof, "check", check)
    return asked


@pytest.mark.parametrize(("verdict", "code"), [(RIGHT, 0), (PART, 1)])
def test_only_what_is_verified_is_right(
    proof: Path, monkeypatch: pytest.MonkeyPatch, verdict: ProofVerdict, code: int
) -> None:
    asked = by_hand(monkeypatch, verdict)
    result = run("check-proof", proof, "--seconds", "5", "--sample", "4")
    assert result.exit_code == code
    assert asked == {"name": "plan.proof", "seconds": 5.0, "sample": 4}
    said = " ".join(result.stdout.split())
    assert "Claim: no plan of 3 experiments has ρ0 below" in said
    assert "Left out, so that the bound may be weaker: A2 against A5." in said
    assert said.endswith(f"plan.proof: {verdict.message}")
    assert "\x1b" not in result.stdout
    document = json.loads(run("check-proof", proof, "--json").stdout)
    assert document["verified"] is verdict.verified
    assert document["experiments"] == 3
    assert document["left_out"] == ["A2 against A5"]


def test_a_record_that_claims_nothing_says_so(proof: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    by_hand(monkeypatch, PART)
    proof.write_bytes(record(rho0=None, largest=None))
    assert "it claims nothing" in run("check-proof", proof).stdout


def test_what_is_no_proof_is_bad_input(proof: Path) -> None:
    for name, data in (("study.yaml", b"elastocal: 1"), ("part.proof", proof.read_bytes()[:99])):
        (proof.parent / name).write_bytes(data)
        result = run("check-proof", proof.parent / name)
        assert result.exit_code == 2
        assert f"{name}: not the record of a proof" in result.stderr
    assert run("check-proof", proof.parent / "none.proof").exit_code == 2


def test_one_that_does_not_hold_is_not_verified(proof: Path) -> None:
    """Its tree is of another statement."""
    result = run("check-proof", proof)
    assert result.exit_code == 1
    assert "not verified" in result.stdout
