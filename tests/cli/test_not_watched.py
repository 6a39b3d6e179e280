"""What is not watched is said wherever a plan is shown, from the constraints alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.programs.writers import WRITERS, export
from elastocal.report import html
from elastocal.report.contents import Contents
from elastocal.viewer.readout_html import heading_html
from elastocal.viewer.subject import Subject, stops_of
from tests.cli.test_commands import run
from tests.kr270 import kr270_study, published_cases

STUDY = """\
elastocal: 1
name: arm
robot: three-link
test_poses:
  - {tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 3}
instrument: {sigma_mm: 0.1}
"""
SAID = {
    "": "Watched for collisions: floor; the robot against itself.",
    "constraints: {collision: off}\n": "Watched for collisions: floor. Not watched: the robot",
    "constraints: {floor: off}\n": "Watched for collisions: the robot against itself. Not watched",
    "constraints: {collision: off, floor: off}\n": "Not watched: the robot against itself; floor",
}


def flat(text: str) -> str:
    return " ".join(text.split())


@pytest.mark.parametrize("keys", SAID)
def test_on_every_screen(keys: str, tmp_path: Path) -> None:
    study, plan, said = tmp_path / "arm.yaml", tmp_path / "plan.json", SAID[keys]
    study.write_text(STUDY + keys, "utf-8")
    checked = flat(run("check", study).stdout)
    assert said in checked
    hints = ["collision: {}" in checked.split("Not watched")[-1], "floor: {z_mm: …}" in checked]
    assert hints == ["collision: off" in keys, "floor: off" in keys]
    assert said in flat(run("plan", study, "--out", plan).stdout)
    assert said in flat(run("evaluate", study, plan, "--random", "0").stdout)
    exported = run("export", plan, "--to", "csv", "--out", tmp_path)
    assert said in flat(exported.stdout)
    (program,) = (path for path in tmp_path.glob("*.csv") if path.stem != "plan")
    text = program.read_text("utf-8").replace("# ", "").replace(";", ",")
    assert said.replace(";", ",") in flat(text)
    report = tmp_path / "report.html"
    run("report", plan, "--study", study, "--out", report, "--quick")
    assert report.read_text("utf-8").count(said) >= 2


@pytest.mark.parametrize("controller", WRITERS)
def test_in_every_header_and_in_the_live_view_of_a_study_made_in_python(controller: str) -> None:
    """No file, no keys: what is said follows from the list of constraints."""
    study, cases = kr270_study(), published_cases(2)
    bare = replace(study, constraints=())
    watched = replace(study, constraints=ec.default_clearances(study.robot, study.experiments.tool))
    for what, said in (
        (bare, "Not watched: the robot against itself; floor."),
        (watched, "Watched for collisions: floor; the robot against itself."),
    ):
        subject = Subject(what, stops_of(what, cases, np.array([1, 1])))
        assert said in heading_html(subject, ())
        program = ec.campaign_program(what, cases, np.array([1, 1]))
        text = next(iter(export(program, controller).values()))
        wanted = said
        for sign in (";", "!", "#", ":", ","):  # signs of comments, in the sentence too
            text, wanted = text.replace(sign, " "), wanted.replace(sign, " ")
        lines = (line.lstrip(" 0123456789") for line in text.splitlines())
        assert flat(wanted) in flat(" ".join(lines))


def test_the_report_of_a_plan_without_a_file() -> None:
    study = kr270_study()
    cell = ec.default_clearances(study.robot, study.experiments.tool)
    study = replace(study, constraints=(*study.constraints, *cell))
    plan = ec.plan(study, effort=ec.Effort(batch=12, generations=2, patience=1, islands=1))
    assert "Not watched" not in html(Contents(plan))
    bare = html(Contents(replace(plan, study=replace(study, constraints=()))))
    assert "Not watched: the robot against itself; floor." in bare
