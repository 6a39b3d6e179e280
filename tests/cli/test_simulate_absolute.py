"""`simulate` with a study of absolute readings: a campaign, and another one on the same arm."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.files.measurements.positions_file import read_positions
from elastocal.files.models.calibration_file import read_calibration
from elastocal.files.models.model_file import read_model
from elastocal.files.models.true_arm import true_frames_in
from elastocal.files.study.absolute_file import read_absolute_study
from tests.kr270 import FOLDER

STUDY = """\
elastocal: 1
robot: kuka-kr270
identify: [base, tool, geometry, A2, A3, A4, A5, A6]
tools:
  balls: {tcp_mm: [600, 0, -400], markers_mm: {M1: [600, 0, -400], M2: [500, 100, -300]}}
payloads:
  weight: {mass_kg: 250, center_mm: [600, 0, -400]}
experiments: {tool: balls, payload: [none, weight], count: 40}
instrument: {sigma_mm: 0.03}
constraints: {collision: off, floor: off}
test_poses:
  - {q_deg: [0, -57, 89, 45, 76, 57], force_N: [0, 0, -500]}
"""
HEADER = "A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg],Fx [N],Fy [N],Fz [N],repeats"
WEIGHT = -250 * 9.80665


def run(*words: str) -> Any:
    """A command, in the folder of the test."""
    return CliRunner().invoke(app, list(words))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    (tmp_path / "truth.json").write_text((FOLDER / "truth.json").read_text("utf-8"), "utf-8")
    rng = np.random.default_rng(0)
    low, high = [-150, -130, -100, -170, -110, -170], [150, -10, 140, 170, 110, 170]
    q = rng.uniform(low, high, (40, 6))
    rows = [
        ",".join(f"{x:.3f}" for x in row) + f",0,0,{WEIGHT if i % 2 else 0},1"
        for i, row in enumerate(q)
    ]
    (tmp_path / "poses.csv").write_text("\n".join([HEADER, *rows, ""]), encoding="utf-8")
    return tmp_path


def test_a_campaign_and_another_on_the_same_arm(folder: Path) -> None:
    study = read_absolute_study(folder / "study.yaml")
    done = run("simulate", "study.yaml", "poses.csv", "--truth", "truth.json")
    assert done.exit_code == 0, done.output
    assert "40 poses, 80 readings" in done.output
    first = read_positions(folder / "positions.csv", study)
    assert first.payload.tolist() == [-1, 0] * 20
    frames = true_frames_in(folder / "positions_truth.json", study.robot)
    assert frames is not None
    assert 1e-4 < np.abs(frames[:, :3, 3]).max() < 2e-3
    given = read_model(folder / "truth.json", study.robot)
    kept = read_model(folder / "positions_truth.json", study.robot)
    assert kept.compliance == pytest.approx(given.compliance)

    done = run("identify", "study.yaml", "positions.csv")
    assert done.exit_code == 0, done.output
    robot = read_calibration(folder / "model.json", study.robot)
    springs = robot.parameters.of("compliance")
    error = np.sqrt(np.diagonal(robot.covariance))[springs]
    assert (np.abs(robot.state.compliance - given.compliance[1:]) < 4.5 * error).all()

    on = ["--truth", "positions_truth.json", "--seed", "5", "-o", "again.csv"]
    assert run("simulate", "study.yaml", "poses.csv", *on).exit_code == 0
    assert not (folder / "again_truth.json").exists()
    again = read_positions(folder / "again.csv", study)
    assert np.abs(again.value - first.value).max() > 0.1  # the tracker stands elsewhere
    check = ["again.csv", "--set-up", "10", "--json"]
    said = json.loads(run("validate", "study.yaml", "model.json", *check).output)
    assert said["error_mm"] < 1.3 * said["expected_mm"]
    assert said["expected_mm"] < 0.1


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--linear"], "--linear does not go with absolute readings"),
        (["--campaigns", "5"], "--campaigns does not go with absolute readings"),
    ],
)
def test_what_does_not_go_is_refused(folder: Path, options: list[str], sentence: str) -> None:
    done = run("simulate", "study.yaml", "poses.csv", "--truth", "truth.json", *options)
    assert done.exit_code == 2
    assert sentence in done.output
    assert not (folder / "positions.csv").exists()


def test_a_force_that_is_no_payload_is_refused(folder: Path) -> None:
    text = (folder / "poses.csv").read_text("utf-8").replace(f"{WEIGHT}", "-700.5")
    (folder / "poses.csv").write_text(text, encoding="utf-8")
    done = run("simulate", "study.yaml", "poses.csv", "--truth", "truth.json")
    assert done.exit_code == 2


def test_compensators_hold_weight_and_are_kept_with_the_arm(folder: Path) -> None:
    text = STUDY.replace("A5, A6]", "A5, A6, compensator]") + (
        "compensators:\n  gas: {joint: A2, crank_mm: 220, reach_mm: 760, rest_mm: 400}\n"
    )
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    done = run("simulate", "study.yaml", "poses.csv", "--truth", "truth.json")
    assert done.exit_code == 0, done.output
    kept = json.loads((folder / "positions_truth.json").read_text("utf-8"))
    assert kept["true_compensators_N_per_mm"]["gas"] > 1.0

    on = ["--truth", "positions_truth.json", "--force"]
    assert run("simulate", "study.yaml", "poses.csv", *on, "-o", "again.csv").exit_code == 0
    del kept["true_compensators_N_per_mm"]
    (folder / "positions_truth.json").write_text(json.dumps(kept), encoding="utf-8")
    done = run("simulate", "study.yaml", "poses.csv", *on)
    assert done.exit_code == 2
    assert "the stiffness of gas" in " ".join(done.output.split())
    kept["true_compensators_N_per_mm"] = {"coil": 3.0}
    (folder / "positions_truth.json").write_text(json.dumps(kept), encoding="utf-8")
    done = run("simulate", "study.yaml", "poses.csv", *on)
    assert done.exit_code == 2
    assert "the compensators of the study, gas; odd is 'coil'" in " ".join(done.output.split())


def test_frames_of_another_arm_are_refused(folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text("utf-8"))
    truth["true_frames"] = {"A1": {"shift_mm": [0, 0, 0], "turn_mrad": [0, 0, 0]}}
    (folder / "truth.json").write_text(json.dumps(truth), encoding="utf-8")
    done = run("simulate", "study.yaml", "poses.csv", "--truth", "truth.json")
    assert done.exit_code == 2
    assert "expected one frame for each of A1" in " ".join(done.output.split())
