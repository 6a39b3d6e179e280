"""Measurement files that cannot be: every command that reads them refuses, and writes nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.files.measurements.measurement_file import write_measurements
from tests.campaigns import hung, measured
from tests.cli.test_commands import run

STUDY = """\
elastocal: 1
robot: kuka-kr270
identify: [A2, A3]
test_poses:
  - {tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}
experiments: {tool: calibration, force_N: [0, 0, -2500], count: 12}
instrument: {sigma_mm: 0.01}
"""
TRUTH = np.array([3e-7, 4e-7])


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "study.yaml").write_text(STUDY)
    study = ec.read_study(tmp_path / "study.yaml")
    rng = np.random.default_rng(0)
    data = measured(study.arm, hung(8), TRUTH, rng=rng, linear=True, noise=1e-5)
    write_measurements(data, study.robot, tmp_path / "good.csv")
    text = (tmp_path / "good.csv").read_text()
    (tmp_path / "degrees.csv").write_text(text.replace("[deg]", "[rad]"))
    (tmp_path / "kilo.csv").write_text(text.replace("Fz [N]", "Fz [kN]"))
    (tmp_path / "metres.csv").write_text(text.replace("[mm]", "[m]"))
    (tmp_path / "frame.csv").write_text(text.replace("dx [mm],dy [mm],dz", "dz [mm],dx [mm],dy"))
    head, *rows = text.splitlines()[1:]
    for name, same in (("zeros", "0,0,0"), ("copies", "1.5,0,-2.25")):
        written = [head, *(",".join([*row.split(",")[:-3], same]) for row in rows)]
        (tmp_path / f"{name}.csv").write_text("\n".join(written) + "\n")
    made = run(
        "identify", tmp_path / "study.yaml", tmp_path / "good.csv", "-o", tmp_path / "m.json"
    )
    assert made.exit_code == 0, made.output
    made = run("plan", tmp_path / "study.yaml", "-o", tmp_path / "plan.json", "--count", "2")
    assert made.exit_code == 0, made.output
    return tmp_path


READINGS = {
    "degrees": "no robot stands there",
    "kilo": "no robot bears that",
    "metres": "no arm bends so far",
    "zeros": "8 of 8 deflections under load are exactly zero",
    "copies": "all 8 deflections are the same to the last digit, under 8 different load cases",
}


@pytest.mark.parametrize("name", READINGS)
def test_every_command_refuses_what_cannot_be(name: str, folder: Path) -> None:
    study, data = folder / "study.yaml", folder / f"{name}.csv"
    out, page = folder / "new.json", folder / "r.html"
    plan, model = folder / "plan.json", folder / "m.json"
    for command in (
        ("identify", study, data, "-o", out),
        ("validate", study, model, data),
        ("evaluate", study, data, "--random", "0"),
        ("plan", study, "--after", data, "-o", out),
        ("report", plan, "--quick", "--measurements", data, "-o", page),
        ("report", plan, "--quick", "--model", model, "--validation", data, "-o", page),
        ("check", study, "--measurements", data),
    ):  # fmt: skip
        shown = run(*command)
        assert shown.exit_code == 2, command
        assert f"{name}.csv: {READINGS[name]}" in shown.stderr, command
        assert shown.stderr.count("\n") == 1, command
    assert not out.exists()
    assert not page.exists()


def test_what_no_springs_explain_gives_no_model(folder: Path) -> None:
    """Deflections in the frame of a tracker."""
    study, data, out = folder / "study.yaml", folder / "frame.csv", folder / "new.json"
    shown = run("identify", study, data, "-o", out)
    assert shown.exit_code == 2
    assert "no springs explain these readings" in shown.stderr
    assert not out.exists()
    page = folder / "r.html"
    shown = run("report", folder / "plan.json", "--quick", "--measurements", data, "-o", page)
    assert shown.exit_code == 2
    assert "no springs explain these readings" in shown.stderr
    assert not page.exists()
    assert run("identify", study, data, "-o", out, "--sigma", "estimated").exit_code == 0
    assert out.exists()
    shown = run("validate", study, out, data)
    assert shown.exit_code == 0, shown.output


def test_what_was_understood_is_shown_before_it_is_refused(folder: Path) -> None:
    shown = run("check", folder / "study.yaml", "--measurements", folder / "degrees.csv")
    said = " ".join(shown.stdout.split())
    assert "8 readings of 8 experiments" in said
    assert "were degrees meant?" in said
