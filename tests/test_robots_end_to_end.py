"""The whole job on robots from files: plan, evaluate, simulate, identify, validate, compensate.

No line of code is written for any of them. Compliances are made up; what matters is that they come
back, and that the path is straight again when it is judged by the true arm.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import elastocal as ec
from elastocal.cli import app
from elastocal.study.study import Study
from tests.test_examples import ROOT

FOLDER = ROOT / "examples" / "robots"
ROBOTS = sorted(path.parent.name for path in FOLDER.glob("*/study.yaml"))


def run(*arguments: object) -> str:
    result = CliRunner().invoke(app, [str(a) for a in arguments])
    assert result.exit_code == 0, result.output
    return result.output


def made_up_truth(study: Study, path: Path) -> None:
    """Compliances under which the calibration load bends the arm by about a millimetre."""
    cases = study.space.load_cases(study.space.sample(50, np.random.default_rng(0)))
    rows = ec.regressor(study.arm, cases)
    sizes = 1e-3 / (np.median(np.abs(rows).max(axis=1), axis=0) * len(study.springs))
    units = ["m/N" if slides else "rad/(N.m)" for slides in study.springs.prismatic]
    entries = {
        name: {"value": float(size * (1.0 + 0.1 * i)), "unit": unit}
        for i, (name, size, unit) in enumerate(zip(study.springs.names, sizes, units, strict=True))
    }
    document = {"elastocal": 1, "kind": "model", "compliance": entries}
    path.write_text(json.dumps(document), encoding="utf-8")


def short_path(study: Study, path: Path) -> None:
    """A dozen points about the first test pose, with its force."""
    pose = study.test_poses[0]
    assert pose.case is not None
    robot = study.robot
    header = [f"{j.name} [{'mm' if j.prismatic else 'deg'}]" for j in robot.joints]
    lines = [",".join([*header, "Fx [N]", "Fy [N]", "Fz [N]"])]
    room = 0.02 * (study.limits[1] - study.limits[0])
    for share in np.linspace(-1.0, 1.0, 12):
        q = np.clip(pose.case.q[0] + share * room, study.limits[0], study.limits[1])
        cells = [*(robot.shown_scale * q), *pose.case.wrench[0, :3]]
        lines.append(",".join(f"{cell:.6f}" for cell in cells))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_the_whole_job(name: str, tmp_path: Path) -> None:
    study_path = FOLDER / name / "study.yaml"
    study = ec.read_study(study_path)
    truth, path = tmp_path / "truth.json", tmp_path / "path.csv"
    made_up_truth(study, truth)
    short_path(study, path)
    run("check", study_path)
    plan = tmp_path / "plan.json"
    run("plan", study_path, "-o", plan, "--seed", 1)
    document = json.loads(plan.read_text("utf-8"))
    assert document["certificate"]["efficiency"] > 0.95
    assert document["study"]["robot_sha256"] == study.robot.sha256
    assert "another" not in run("evaluate", study_path, plan)
    measured, model = tmp_path / "measured.csv", tmp_path / "model.json"
    run("simulate", study_path, plan, "--truth", truth, "-o", measured, "--seed", 2)
    run("identify", study_path, measured, "-o", model)
    found = json.loads(model.read_text("utf-8"))["compliance"]
    true = json.loads(truth.read_text("utf-8"))["compliance"]
    for joint, entry in true.items():
        off = abs(found[joint]["value"] - entry["value"]) / found[joint]["standard_error"]
        assert off < 4.5, joint
    assert "removed" in run("validate", study_path, model, measured)
    corrected = tmp_path / "corrected.csv"
    arguments = ("compensate", study_path, model, path, "-o", corrected, "--truth", truth)
    points = json.loads(run(*arguments, "--json"))["points"]
    before = np.array([point["before_mm"] for point in points])
    left = np.array([point["residual_mm"] for point in points])
    expected = np.sqrt(np.mean([point["rho0_mm"] ** 2 for point in points]))
    remaining = np.sqrt(np.mean(np.sum(left**2, axis=1)))
    assert remaining < 0.1 * np.sqrt(np.mean(np.sum(before**2, axis=1)))
    assert remaining < 4.0 * expected  # by the true arm, within what the model promises
