"""Plan files: what is written is read back, and judged anew."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import PlanFileError
from elastocal.files.plans.certificate_section import read_certified_design
from tests.files.campaign import study

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
    found = read_certified_design(tmp_path / "plan.json", plan.study.robot)
    made = plan.certificate
    assert found is not None
    assert made.support is not None
    assert made.weights is not None
    assert made.peak is not None
    np.testing.assert_allclose(found.support.q, made.support.q, atol=1e-12)
    np.testing.assert_allclose(found.weights, made.weights / made.weights.sum(), rtol=1e-12)
    np.testing.assert_allclose(found.peak.q, made.peak.q, atol=1e-12)
    np.testing.assert_array_equal(found.peak.wrench, made.peak.wrench)
    assert read_certified_design(tmp_path / "plan.csv", plan.study.robot) is None


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
        found = read_certified_design(path, plan.study.robot)
        assert found is not None
        np.testing.assert_allclose(found.weights, [0.75, 0.25])
    else:
        with pytest.raises(PlanFileError, match="must be shares of 1"):
            read_certified_design(path, plan.study.robot)
    del document["certificate"]["continuous_design"]
    path.write_text(json.dumps(document), "utf-8")
    assert read_certified_design(path, plan.study.robot) is None


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
