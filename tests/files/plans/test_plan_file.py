"""Plan files: what is written is read back, and judged anew."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import Doubt, PlanFileError
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.evaluation import evaluate
from elastocal.wording import worded
from tests.files.campaign import study
from tests.paper.problems import three_link_study

LIGHT = ec.Effort(batch=8, generations=1, patience=1, islands=1)


@pytest.fixture(scope="module")
def plan() -> ec.Plan:
    return ec.plan(study(), seed=3, effort=LIGHT)


def test_a_plan_is_read_back(plan: ec.Plan, tmp_path: Path) -> None:
    ec.write_plan(plan, tmp_path / "plan.json")
    again = ec.read_plan(tmp_path / "plan.json")
    np.testing.assert_allclose(again.load_cases.q, plan.load_cases.q, atol=1e-12)
    np.testing.assert_array_equal(again.load_cases.wrench, plan.load_cases.wrench)
    np.testing.assert_array_equal(again.repeats, plan.repeats)
    assert (again.criterion, again.seed, again.count) == (plan.criterion, 3, 3)
    assert again.free_joints == plan.free_joints == ("A1",)
    assert again.study.text == plan.study.text
    assert again.assessment.rho0 == pytest.approx(plan.assessment.rho0, rel=1e-12)
    bound = plan.certificate.lower_bound
    assert again.certificate.lower_bound == pytest.approx(bound, rel=1e-3)


def test_a_joint_that_turns_with_the_load_is_read_back(tmp_path: Path) -> None:
    made = ec.plan(three_link_study(3), seed=0, effort=LIGHT)
    assert made.turns_with_load == "J1"
    assert made.load_range < 1e-9
    ec.write_plan(made, tmp_path / "plan.json")
    document = json.loads((tmp_path / "plan.json").read_text("utf-8"))
    assert document["turns_with_load"] == "J1"
    again = ec.read_plan(tmp_path / "plan.json", made.study)
    assert again.turns_with_load == "J1"
    for odd in ("J9", 1, ["J1"]):
        document["turns_with_load"] = odd
        (tmp_path / "plan.json").write_text(json.dumps(document), "utf-8")
        assert ec.read_plan(tmp_path / "plan.json", made.study).turns_with_load == ""


def test_what_a_plan_claims_is_not_believed(plan: ec.Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    ec.write_plan(plan, path)
    document = json.loads(path.read_text("utf-8"))
    document["rho0_mm"] /= 2.0
    document["certificate"]["rho0_lower_bound_mm"] /= 2.0
    path.write_text(json.dumps(document), "utf-8")
    again = ec.read_plan(path)
    assert again.assessment.rho0 == pytest.approx(plan.assessment.rho0, rel=1e-12)
    assert again.certificate.lower_bound > 0.99 * plan.certificate.lower_bound


def test_a_run_sheet_needs_its_study(plan: ec.Plan, tmp_path: Path) -> None:
    ec.write_run_sheet(plan, tmp_path / "plan.csv")
    again = ec.read_plan(tmp_path / "plan.csv", plan.study)
    np.testing.assert_allclose(again.load_cases.q, plan.load_cases.q, atol=1e-6)
    assert again.assessment.rho0 == pytest.approx(plan.assessment.rho0, rel=1e-4)


def test_what_a_certificate_rests_on_is_read_back(plan: ec.Plan, tmp_path: Path) -> None:
    ec.write_plan(plan, tmp_path / "plan.json")
    ec.write_run_sheet(plan, tmp_path / "plan.csv")
    found = ec.read_proposal(tmp_path / "plan.json", plan.study).certified
    made = plan.certificate
    assert found is not None
    assert made.support is not None
    assert made.weights is not None
    assert made.peak is not None
    np.testing.assert_allclose(found.support.q, made.support.q, atol=1e-12)
    np.testing.assert_allclose(found.weights, made.weights / made.weights.sum(), rtol=1e-12)
    np.testing.assert_allclose(found.peak.q, made.peak.q, atol=1e-12)
    np.testing.assert_array_equal(found.peak.wrench, made.peak.wrench)
    assert ec.read_proposal(tmp_path / "plan.csv", plan.study).certified is None


@pytest.mark.parametrize("weights", [[3.0, 1.0], [-1.0, 2.0], [0.0, 0.0]])
def test_weights_of_a_certificate_are_shares(
    plan: ec.Plan, tmp_path: Path, weights: list[float]
) -> None:
    path = tmp_path / "plan.json"
    ec.write_plan(plan, path)
    document = json.loads(path.read_text("utf-8"))
    entries = document["certificate"]["continuous_design"][:2]
    document["certificate"]["continuous_design"] = [
        entry | {"weight": weight} for entry, weight in zip(entries, weights, strict=True)
    ]
    path.write_text(json.dumps(document), "utf-8")
    if weights == [3.0, 1.0]:
        found = ec.read_proposal(path, plan.study).certified
        assert found is not None
        np.testing.assert_allclose(found.weights, [0.75, 0.25])
    else:
        with pytest.raises(PlanFileError, match=r"must be shares of 1|expected 0 or a positive"):
            ec.read_proposal(path, plan.study)
    del document["certificate"]["continuous_design"]
    path.write_text(json.dumps(document), "utf-8")
    assert ec.read_proposal(path, plan.study).certified is None


def test_a_run_sheet_that_a_spreadsheet_saved_is_read(plan: ec.Plan, tmp_path: Path) -> None:
    ec.write_run_sheet(plan, tmp_path / "plan.csv")
    text = (tmp_path / "plan.csv").read_text("utf-8").replace(",", ";")
    header, *rows = text.split("\n")
    saved = "\r\n".join([header, *(row.replace(".", ",") for row in rows)])
    (tmp_path / "saved.csv").write_bytes(saved.encode("cp1252"))
    sheet = ec.read_proposal(tmp_path / "plan.csv", plan.study)
    again = ec.read_proposal(tmp_path / "saved.csv", plan.study)
    np.testing.assert_array_equal(again.load_cases.q, sheet.load_cases.q)
    np.testing.assert_array_equal(again.load_cases.wrench, sheet.load_cases.wrench)
    np.testing.assert_array_equal(again.repeats, sheet.repeats)


QUICK = """\
elastocal: 1
robot: three-link
test_poses:
  - {tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 3}
instrument: {sigma_mm: 0.1}
constraints: {collision: off, floor: off}
criterion: coordinate
"""


def as_0_1_0_wrote_it(plan: ec.Plan, path: Path) -> dict[str, Any]:
    """A plan for the largest error of one coordinate, when that was called G."""
    ec.write_plan(plan, path)
    document: dict[str, Any] = json.loads(path.read_text("utf-8"))
    criteria, certificate = document["criteria"], document["certificate"]
    del criteria["G"]
    criteria["G_mm"] = criteria.pop("coordinate_mm")
    if plan.criterion == "coordinate":
        document["criterion"] = certificate["criterion"] = "G"
        certificate["G_lower_bound_mm"] = certificate.pop("coordinate_lower_bound_mm")
    path.write_text(json.dumps(document), "utf-8")
    return document


def test_what_was_called_g_is_judged_by_what_it_meant(tmp_path: Path) -> None:
    """Claims in metres under the old name are held against `coordinate`, never against G."""
    wanted = study(QUICK)
    bound = lower_bound(wanted, np.random.default_rng(0))
    old = ec.plan(wanted, seed=3, effort=LIGHT, bound=bound)
    path = tmp_path / "plan.json"
    document = as_0_1_0_wrote_it(old, path)
    proposal = ec.read_proposal(path, old.study)
    assert (proposal.named, proposal.criterion) == ("G", "coordinate")
    worth = old.assessment.criteria
    assert proposal.claims["criteria"]["coordinate"] == pytest.approx(worth["coordinate"])
    assert proposal.claims["lower_bound"] == pytest.approx(old.certificate.lower_bound)
    assert "G" not in proposal.claims["criteria"]
    assert ec.read_plan(path).criterion == "coordinate"
    assert judged(old, path, bound) == ()
    document["criteria"]["G_mm"] *= 1.01
    document["certificate"]["G_lower_bound_mm"] *= 1.01
    path.write_text(json.dumps(document), "utf-8")
    value, least = judged(old, path, bound)
    assert (value.code, value.about, value.unit) == ("claims-criteria", ("coordinate",), "m")
    assert worded(value).startswith("it claims 0.0")
    assert worded(value).split(" but ")[0].endswith(" mm for criterion coordinate")
    assert least.code == "claims-bound"


def judged(plan: ec.Plan, path: Path, bound: Bound) -> tuple[Doubt, ...]:
    p = ec.read_proposal(path, plan.study)
    return evaluate(plan.study, p.load_cases, p.repeats, p.claims, bound).objections


def test_a_plan_for_another_criterion_may_claim_the_old_g(plan: ec.Plan, tmp_path: Path) -> None:
    as_0_1_0_wrote_it(plan, tmp_path / "plan.json")
    proposal = ec.read_proposal(tmp_path / "plan.json", plan.study)
    assert proposal.named == proposal.criterion == "test-pose"
    assert set(proposal.claims["criteria"]) == set(plan.assessment.criteria) - {"G"}


def test_claims_of_all_criteria_are_read_in_si(plan: ec.Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    ec.write_plan(plan, path)
    claims = ec.read_proposal(path, plan.study).claims["criteria"]
    assert claims == pytest.approx(plan.assessment.criteria, rel=1e-12)
    document = json.loads(path.read_text("utf-8"))
    document["criteria"] |= {"G": None, "A_mm": 1.0, "worst": 1.0, "future": "yes"}
    path.write_text(json.dumps(document), "utf-8")
    again = ec.read_proposal(path, plan.study).claims["criteria"]
    assert set(again) == set(claims) - {"G"}
    document["criteria"]["G"] = "19"
    path.write_text(json.dumps(document), "utf-8")
    with pytest.raises(PlanFileError, match="criteria, G: expected a finite number, found '19'"):
        ec.read_proposal(path, plan.study)
