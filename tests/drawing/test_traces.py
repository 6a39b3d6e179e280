"""Paths as lines: in the picture of `check`, in reports and in the live view."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.drawing.check_picture import check_picture
from elastocal.drawing.traces import trace
from elastocal.files.study.study_file import parse_study
from elastocal.report.contents import Contents
from elastocal.report.planned_stage import planned_stage
from elastocal.report.scene import scene
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath
from elastocal.terminal.plans import show_plan
from elastocal.terminal.studies import show_check
from elastocal.viewer.subject import Subject, stops_of
from elastocal.viewer.surroundings import reach, traces
from tests.drawing.test_check_picture import words
from tests.files.study.test_test_poses import HEAD, KR270, POSE, TAIL
from tests.report.examples import kuka_plan, visible

PATH = f"  - {{name: cut, path: path.csv, tool: milling, {POSE}}}"
JUDGED = f"  - {{name: rest, tool: milling, {POSE}, force_N: [0, 280, -180], weight: 0}}"


def study() -> Study:
    return parse_study(HEAD + PATH + "\n" + JUDGED + TAIL, KR270 / "study.yaml")


def planned() -> ec.Plan:
    """The published plan, judged along the path."""
    plan, along = kuka_plan(), study()
    worth = ec.assess(along, plan.load_cases, plan.repeats)
    return replace(plan, study=along, assessment=worth)


def test_a_trace_is_where_the_tool_is() -> None:
    along = study()
    path, pose = along.test_poses
    assert isinstance(path, TestPath)
    line = trace(along.robot, path)
    frames = ec.forward_kinematics(along.robot, path.cases.q)
    np.testing.assert_allclose(
        line, frames[:, :3, :3] @ path.tool.tcp + frames[:, :3, 3], atol=1e-12
    )
    assert trace(along.robot, pose).shape == (0, 3)
    long = replace(
        path,
        cases=ec.LoadCases(*(np.repeat(a, 9, axis=0) for a in (path.cases.q, path.cases.wrench))),
        regressors=np.repeat(path.regressors, 9, axis=0),
        points=(),
    )
    short = trace(along.robot, long)
    assert len(short) == 400
    np.testing.assert_allclose(short[[0, -1]], line[[0, -1]], atol=1e-12)


def test_the_picture_of_check_has_the_line() -> None:
    picture = check_picture(study())
    assert words(picture, "title") == [
        "Home: every joint at zero",
        "Test path cut",
        "Test pose rest",
    ]
    assert picture.count('class="trace"') == 1
    assert picture.count("the robot at its first point") == 1


def test_the_report_shows_the_line_and_the_worst_point() -> None:
    plan = planned()
    stage = planned_stage(plan)
    assert [len(figure.trace) for figure in stage.tests] == [200, 0]
    lines = [
        t
        for t in scene(plan, stage)["data"]
        if t["meta"]["role"] == "test" and t.get("mode") == "lines"
    ]
    assert len(lines) == 1
    page = visible(ec.html(Contents(plan)))
    worst = plan.assessment.worst_points[0]
    assert worst is not None
    assert "along the 200 points of cut" in page
    assert f"point {worst.name} of 200" in page
    assert "judged only" in page


def test_the_live_view_has_the_line_and_begins_where_it_begins() -> None:
    along = study()
    stops = stops_of(along)
    assert [s.label for s in stops if s.kind == "test"] == [
        "test path cut, first of 200 points",
        "test pose rest",
    ]
    subject = Subject(along, stops)
    (line,) = traces(subject)
    low, high, _ = reach(subject)
    assert (line >= low).all()
    assert (line <= high).all()


def test_the_screen_names_path_and_worst_point(capsys: pytest.CaptureFixture[str]) -> None:
    along, plan = study(), planned()
    show_check(along, ec.check(along))
    show_plan(plan)
    said = " ".join(capsys.readouterr().out.split())
    assert "Test path 'cut' (weight 1): 200 points from q = " in said
    assert "force of 332.9 N at 'milling'" in said
    assert "Test pose 'rest' (judged only)" in said
    worst = plan.assessment.worst_points[0]
    assert worst is not None
    assert f"cut (200 points) 100 % {1e6 * plan.assessment.rho0:.4g} µm" in said
    assert f"{1e6 * worst.rho0:.4g} µm {worst.name}" in said
    assert "along the 200 points of cut" in said


def test_what_is_odd_in_a_path_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = (KR270 / "path.csv").read_text("utf-8").splitlines()
    names = [name + ("note" if i == 0 else "x") for i, name in enumerate([""] * len(lines))]
    (tmp_path / "path.csv").write_text(
        "\n".join(f"{a},{b}" for a, b in zip(lines, names, strict=True)) + "\n", encoding="utf-8"
    )
    odd = parse_study(HEAD + PATH + TAIL, tmp_path / "study.yaml")
    show_check(odd, ec.check(odd))
    assert "Note: path.csv: columns not read: note." in " ".join(capsys.readouterr().out.split())
