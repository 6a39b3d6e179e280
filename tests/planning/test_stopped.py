"""The planner shows what it has: first plans, bracket, and what is left when it is stopped."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.design.exact import Effort
from elastocal.files.plans.plan_file import plan_document, read_plan, write_plan
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.planning.aim import aim_of
from elastocal.planning.bracket import bracket
from elastocal.planning.certificate import lower_bound
from elastocal.planning.evaluation import evaluate
from elastocal.report.verdict import proof
from elastocal.study.study import Study
from elastocal.terminal.certificates import certificate_sentences
from tests.test_examples import ROOT

EFFORT = Effort(batch=16, generations=4, patience=9)


@pytest.fixture(scope="module")
def study() -> Study:
    return ec.read_study(ROOT / "examples" / "kr270" / "study.yaml")


def after(asked: int) -> Callable[[], bool]:
    """True from that question on."""
    left = iter(range(asked))
    return lambda: next(left, None) is None


def questions(study: Study) -> list[str]:
    """What was told before each question whether to stop, of a search that ends by itself."""
    now, asked = [""], []

    def stop() -> bool:
        asked.append(now[0])
        return False

    ec.plan(study, effort=EFFORT, progress=lambda what, _: now.__setitem__(0, what), stop=stop)
    return asked


def test_the_bracket_closes(study: Study) -> None:
    """ρ0 of the best plan never rises, nor is it told to be better than the plan at the end."""
    told: list[str] = []
    found = ec.plan(study, effort=EFFORT, progress=lambda what, _: told.append(what))
    assert told[0] == "first plans"
    rho0 = [float(value) for what in told for value in re.findall(r"^ρ0 ([\d.]+) µm", what)]
    assert len(rho0) > 10
    assert rho0 == sorted(rho0, reverse=True)
    assert rho0[-1] >= 1e6 * found.assessment.rho0 - 5e-4
    (least,) = {
        float(value) for what in told for value in re.findall(r"at least ([\d.]+) µm", what)
    }
    assert found.certificate.rho0_bound is not None
    assert least == pytest.approx(1e6 * found.certificate.rho0_bound, abs=5e-4)
    known = [what for what in told if "at least" in what]
    assert not [what for what in told[: told.index(known[0])] if "gain" in what]


def test_nobody_is_asked_before_there_is_a_plan(study: Study) -> None:
    asked = questions(study)
    assert all(what.startswith("ρ0 ") for what in asked)
    assert any("trying the bound" in what for what in asked)
    assert "at least" in asked[-1]


def test_being_watched_changes_nothing(study: Study) -> None:
    alone = ec.plan(study, effort=EFFORT)
    watched = ec.plan(study, effort=EFFORT, progress=lambda *_: None, stop=lambda: False)
    np.testing.assert_array_equal(alone.load_cases.q, watched.load_cases.q)
    np.testing.assert_array_equal(alone.repeats, watched.repeats)
    assert plan_document(alone) == plan_document(watched)
    assert alone.stopped_after is None
    assert "stopped_after" not in plan_document(alone)["searches"]


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.7, 0.95])
def test_a_stopped_plan_is_a_plan(study: Study, share: float, tmp_path: Path) -> None:
    """Feasible, no better than it says, and read back; it says that the search was stopped."""
    asked = questions(study)
    number = int(share * len(asked))
    found = ec.plan(study, effort=EFFORT, stop=after(number))
    whole = ec.plan(study, effort=EFFORT)
    assert not found.broken
    assert found.count == 12
    assert whole.assessment.rho0 <= found.assessment.rho0 * (1.0 + 1e-9)
    assert found.assessment.rho0 < 1.1 * whole.assessment.rho0
    bounded = "at least" in asked[number]
    assert (found.certificate.kind, found.certificate.stopped) == (
        ("numerical", False) if bounded else ("none", True)
    )
    if bounded:
        assert found.certificate.lower_bound == whole.certificate.lower_bound
    assert found.doubts[0].code == "search-stopped"
    assert found.stopped_after is not None
    assert found.stopped_after >= 1
    write_plan(found, file := tmp_path / "plan.json")
    proposal = read_proposal(file, study)
    bound = lower_bound(study, np.random.default_rng(1))
    judged = evaluate(study, proposal.load_cases, proposal.repeats, proposal.claims, bound)
    assert judged.accepted, judged.objections
    assert judged.remarks[0] == found.doubts[0]
    again = read_plan(file)
    assert again.stopped_after == found.stopped_after
    assert again.certificate.kind == "numerical"


def test_why_there_is_no_certificate_is_said(study: Study) -> None:
    found = ec.plan(study, effort=EFFORT, stop=lambda: True)
    why = "stopped before its bound had been tried from fresh starts"
    assert why in certificate_sentences(found.certificate, 12)[0]
    assert why in proof(found.certificate, 12)[0]
    assert why in plan_document(found)["certificate"]["why"]
    assert "not concave" not in str(plan_document(found))


def test_what_the_criterion_ignores_stays_identified_at_once() -> None:
    """Nobody knows yet that the optimum is singular: the first plans have a floor anyway."""
    study = ec.read_study(ROOT / "examples" / "three-link" / "study.yaml")
    found = ec.plan(study, stop=lambda: True)
    assert found.certificate.stopped
    assert found.assessment.identifiable


def test_words_of_the_bracket(study: Study) -> None:
    bound = lower_bound(study, np.random.default_rng(0))
    assert bound.design is not None
    upper, aim = bound.upper(12), aim_of(study)
    assert bracket(study, aim, 0.0, bound) == ""
    assert bracket(study, aim, 0.81 * upper, None) == "ρ0 3.094 µm so far"
    shown = bracket(study, aim, 0.81 * upper, bound)
    assert shown == "ρ0 3.094 µm, at least 2.784 µm: 10 % to gain at most"
    assert bracket(study, aim, upper, bound).endswith(": 0 % to gain at most")
