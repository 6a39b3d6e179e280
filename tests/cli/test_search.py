"""`identify` looks for what else explains the readings, says it and writes it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.files.measurements.measurement_file import write_measurements
from elastocal.files.study.study_file import read_study
from elastocal.robot.posture import Posture, flange_axes
from elastocal.study.study import Study
from tests.campaigns import FREE_FORCES, NAMES, arm, measured, sideways

TRUTH = np.array([0.623, 0.302, 0.406, 3.002, 3.303, 2.365]) * 1e-6


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A study, and readings taken with a tool that shifted by 2 mm under load."""
    (tmp_path / "study.yaml").write_text(FREE_FORCES)
    data = measured(arm(("A1", *NAMES)), sideways(24), TRUTH, rng=np.random.default_rng(1))
    shift = flange_axes(Posture(arm().robot, data.cases.q)) @ [0.0, 0.0, 2e-3]
    data = replace(data, deflection=data.deflection + shift)
    write_measurements(data, study(tmp_path).robot, tmp_path / "readings.csv")
    return tmp_path


def study(folder: Path) -> Study:
    return read_study(folder / "study.yaml")


def run(folder: Path, *words: str) -> str:
    files = [str(folder / word) if "." in word else word for word in words]
    result = CliRunner().invoke(app, ["identify", *files])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_what_is_missing_is_said_and_written(folder: Path) -> None:
    shown = run(folder, "study.yaml", "readings.csv", "-o", "a.json", "--sigma", "estimated")
    assert "a tool shifted between the readings" in " ".join(shown.split())
    document = json.loads((folder / "a.json").read_text())["diagnostics"]
    (first, *_) = document["candidates"]
    assert first["kind"] == "tool-shift"
    assert first["missing"]
    assert first["size_SI"] == pytest.approx([0.0, 0.0, 2e-3], abs=1e-4)
    assert "model-lacks" in {doubt["code"] for doubt in document["doubts"]}
    assert any("a tool shifted" in remark for remark in document["remarks"])


def test_the_search_can_be_left_out(folder: Path) -> None:
    given = ["study.yaml", "readings.csv", "--sigma", "estimated", "--no-search"]
    shown = run(folder, *given, "-o", "b.json")
    assert "a tool shifted" not in " ".join(shown.split())
    assert "candidates" not in json.loads((folder / "b.json").read_text())["diagnostics"]


def test_another_convention_is_named(folder: Path) -> None:
    text = FREE_FORCES.replace("identify:", "controller: {signs: {A3: -1, A5: -1}}\nidentify:")
    data = measured(arm(("A1", *NAMES)), sideways(24), TRUTH, rng=np.random.default_rng(1))
    write_measurements(data, study(folder).robot, folder / "plain.csv")
    (folder / "other.yaml").write_text(text)
    mapping = folder / "map.yaml"
    joints = "".join(f'  "A{i} [deg]": "A{i} [deg]"\n' for i in range(1, 7))
    lines = (folder / "plain.csv").read_text().splitlines()
    head = next(line for line in lines if not line.startswith("#"))
    rest = [column for column in head.split(",") if not column.startswith("A")]
    columns = "".join(f'  "{c}": "{c}"\n' for c in rest)
    mapping.write_text(f"elastocal: 1\njoints: controller\ncolumns:\n{joints}{columns}")
    given = ["other.yaml", "plain.csv", "--mapping", "map.yaml", "--sigma", "estimated"]
    shown = " ".join(run(folder, *given, "-o", "c.json").split())
    assert "another one fits best" in shown
    assert "the joint values are taken the other way" in shown  # they are those of the model
    document = json.loads((folder / "c.json").read_text())["diagnostics"]
    assert document["other_convention"]["model"] == 1
    assert "candidates" not in document
