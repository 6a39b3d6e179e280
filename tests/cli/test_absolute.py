"""`identify` and `validate` of absolute readings, from files to a model and back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.cli import app
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.study.absolute import arm_model
from tests.calibration.test_calibrate import campaign, truth_of

STUDY = """\
elastocal: 1
robot:
  name: arm
  convention: classic
  dh:
    - {joint: A1, d_mm: 400, a_mm: 200, alpha_deg: 90, mass_kg: 60, center_mm: [-100, 0, -200]}
    - {joint: A2, a_mm: 800, mass_kg: 40, center_mm: [-400, 0, 0]}
    - {joint: A3, a_mm: 100, alpha_deg: 90, mass_kg: 30, center_mm: [-50, 0, 0]}
    - {joint: A4, d_mm: 900, alpha_deg: -90, mass_kg: 10, center_mm: [0, 0, -450]}
    - {joint: A5, alpha_deg: 90, mass_kg: 5}
    - {joint: A6, d_mm: 200, mass_kg: 1, center_mm: [0, 0, -100]}
tools:
  balls:
    tcp_mm: [0, 0, 100]
    markers_mm: {T1: [100, 0, 100], T2: [-50, 120, 100]}
payloads:
  weight: {mass_kg: 40, center_mm: [0, 0, 200]}
identify: [base, tool, geometry, A2, A3]
instrument: {sigma_mm: 0.02}
"""


def ran(*words: str | Path) -> str:
    """What a command prints that ends well."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.stdout


def failed(*words: str | Path) -> str:
    """The sentence of a command that refuses."""
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 2, result.output
    return " ".join(result.output.split())


@pytest.fixture
def job(tmp_path: Path) -> Path:
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    study = read_absolute_study(tmp_path / "study.yaml")
    model, rng = arm_model(study), np.random.default_rng(1)
    truth = truth_of(rng, model)
    for name in ("fit", "other"):
        data = campaign(rng, model, truth, 30)
        lines = [
            "experiment,marker,payload,x [mm],y [mm],z [mm],"
            + ",".join(f"A{i} [rad]" for i in range(1, 7))
        ]
        for r in range(len(data)):
            i = data.case[r]
            numbers = [*(1e3 * data.value[r]), *data.cases.q[i]]
            load = data.payloads[0] if data.payload[i] == 0 else "none"
            marker = study.tool.marker_names[data.marker[r]]
            lines.append(f"{i},{marker},{load}," + ",".join(f"{v:.9f}" for v in numbers))
        (tmp_path / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert parameters_of(model, data)
    assert len(predicted(model, data, parameters_of(model, data), truth).error) == len(data)
    return tmp_path


def test_from_a_tracker_file_to_a_calibrated_robot(job: Path) -> None:
    study, model = job / "study.yaml", job / "model.json"
    said = ran("identify", study, job / "fit.csv", "-o", model)
    for words in ("base and tool", "+ zeros", "+ compliances", "not told by itself", "A2", "wrote"):
        assert words in said
    assert json.loads(model.read_text(encoding="utf-8"))["kind"] == "calibration"
    said = ran("validate", study, model, job / "other.csv")
    assert "not used" in said
    there = json.loads(ran("validate", study, model, job / "other.csv", "--json"))
    assert there["error_mm"] == pytest.approx(there["expected_mm"], rel=0.25)
    said = ran("validate", study, model, job / "other.csv", "--set-up", "10")
    assert "base and tool from 10 poses" in said


def test_programs_are_told_what_people_are(job: Path) -> None:
    said = ran("identify", job / "study.yaml", job / "fit.csv", "-o", job / "m.json", "--json")
    told = json.loads(said)
    names = [model["name"] for model in told["models"]]
    assert names == ["base and tool", "zeros", "lengths", "angles", "compliances"]
    assert told["proposed"] in names
    assert {"doubts", "remarks"} <= set(told)


def test_two_points_under_one_name_are_refused(job: Path) -> None:
    text = (job / "fit.csv").read_text(encoding="utf-8").replace(",T2,", ",T1,")
    (job / "twice.csv").write_text(text, encoding="utf-8")
    said = failed("identify", job / "study.yaml", job / "twice.csv", "-o", job / "m.json")
    assert "twice.csv, line 3" in said
    assert "is it another reflector, or another pose?" in said


def test_readings_of_the_fit_are_no_validation(job: Path) -> None:
    study, model = job / "study.yaml", job / "model.json"
    ran("identify", study, job / "fit.csv", "-o", model)
    assert "was made from these readings" in failed("validate", study, model, job / "fit.csv")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("A2, A3]", "A2, A9]", "'A9' is no block, joint or spring"),
        ("[base, tool", "[base, base, tool", "identify lists 'base' twice"),
        ("payloads:", "payload:", "unknown key 'payload'"),
        ("A2, A3]", "A2, compensator]", "but none is given in compensators"),
        (
            "payloads:",
            "compensators: {gas: {joint: A2, crank_mm: 300, reach_mm: 900}}\npayloads:",
            "identify must name 'compensator'",
        ),
        ("mass_kg: 40, center_mm: [0, 0, 200]}", "mass_kg: -4}", "mass_kg"),
        ("sigma_mm: 0.02", "sigma_mm: -1", "sigma_mm"),
    ],
)
def test_wrong_studies_get_a_sentence(job: Path, old: str, new: str, said: str) -> None:
    text = STUDY.replace(old, new)
    assert text != STUDY
    (job / "study.yaml").write_text(text, encoding="utf-8")
    assert said in failed("identify", job / "study.yaml", job / "fit.csv", "-o", job / "m.json")


def test_a_study_without_a_plan_is_described(job: Path) -> None:
    said = ran("check", job / "study.yaml")
    for words in (
        "A2",
        "compliance",
        "beta",
        "T1 [100, 0, 100]",
        "Payload weight: 40 kg",
        "Gravity",
    ):
        assert words in said
    told = json.loads(ran("check", job / "study.yaml", "--json"))
    assert told["reflectors"] == ["T1", "T2"]
    assert told["mass_kg"] == 146


def test_what_is_missing_to_plan_is_said(job: Path) -> None:
    assert "to plan, key 'count' is missing" in failed("plan", job / "study.yaml")
