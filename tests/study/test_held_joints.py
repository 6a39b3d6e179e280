"""A joint that is held at a value: in planning, on paper and on the cell."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.constraints import HeldJoint
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.files.study.study_file import parse_study
from elastocal.motion import via_points
from elastocal.planning.assessment import assess
from elastocal.planning.plain_values import simplify
from elastocal.programs.campaign_program import campaign_program
from elastocal.report import html
from elastocal.report.charts.ranges import range_chart
from elastocal.report.contents import Contents
from elastocal.study.study import Study
from elastocal.wording import worded
from tests.paper.problems import kr270
from tests.paper.published import A0
from tests.test_examples import ROOT

LIGHT = ec.Effort(batch=12, generations=2, patience=1, islands=1)
TEXT = """
elastocal: 1
name: planar arm
robot: three-link
test_poses:
  - {name: task, tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 3}
instrument: {sigma_mm: 0.1}
constraints:
  joint_limits_deg: {J1: [10, 10], J2: [-90, 90]}
  joint_margin_deg: 2
  collision: off
  floor: off
"""


def study(constraints: str = "") -> Study:
    text = TEXT.split("constraints:")[0] + constraints if constraints else TEXT
    return parse_study(text, Path("study.yaml"))


@pytest.fixture(scope="module")
def plan() -> ec.Plan:
    return ec.plan(study(), effort=LIGHT)


def test_equal_limits_hold_a_joint_and_no_margin_is_taken_from_them() -> None:
    found = study()
    assert found.held.tolist() == [True, False, False]
    np.testing.assert_allclose(np.degrees(found.limits[:, :2]), [[10.0, -88.0], [10.0, 88.0]])
    kinds = [type(c).__name__ for c in found.joint_limits]
    assert kinds == ["HeldJoint", *["JointLimit"] * 4]
    assert found.pace.home[0] == pytest.approx(np.radians(10.0))


def test_a_plan_keeps_it_and_says_nothing_of_it(plan: ec.Plan) -> None:
    """Neither free nor the nearest constraint, which it would always be."""
    np.testing.assert_array_equal(plan.load_cases.q[:, 0], study().limits[0, 0])
    assert plan.free_joints == ()
    assert plan.turns_with_load == ""
    assert not plan.assessment.violations
    assert all(near.name.startswith(("J2", "J3")) for near in plan.assessment.nearest)
    free = ec.plan(
        study("constraints:\n  joint_margin_deg: 2\n  collision: off\n  floor: off\n"), effort=LIGHT
    )
    assert free.turns_with_load == "J1"
    assert plan.assessment.rho0 >= free.certificate.lower_bound * (1.0 - 1e-9)


def test_load_cases_elsewhere_are_refused(plan: ec.Plan) -> None:
    q = np.array(plan.load_cases.q)
    q[1, 0] += np.radians(0.5)
    q[2, 0] += 0.9e-5
    worth = assess(plan.study, LoadCases(q, plan.load_cases.wrench), plan.repeats)
    assert [worded(doubt) for doubt in worth.violations] == ["load case 2 breaks J1 = 10° by 0.5°"]
    assert [near.name for near in worth.nearest].count("J1 = 10°") == 1
    assert worth.nearest[1].margin == pytest.approx(-np.radians(0.5))


def test_if_nothing_else_limits_it_is_the_nearest() -> None:
    base = study()
    box = np.array(base.limits)
    box[:, 1:] = box[:1, 1:] + 1.0
    all_held = replace(base, limits=np.tile(box[0], (2, 1)))
    cases = LoadCases(box[:1], [[0.0, 100.0, 0.0, 0.0, 0.0, 0.0]])
    assert assess(all_held, cases, np.array([1])).nearest[0].name == "J1 = 10°"


def test_a_held_joint_is_not_free_even_where_it_changes_nothing() -> None:
    """A1 under a hung weight."""
    hung = kr270(A0)
    cases = hung.space.load_cases(hung.space.sample(3, np.random.default_rng(0)))
    assert simplify(hung.space, cases).free == ("A1",)
    box = np.array(hung.limits)
    box[:, 0] = 0.4
    held = replace(hung, limits=box)
    q = np.array(cases.q)
    q[:, 0] = 0.4
    plain = simplify(held.space, LoadCases(q, cases.wrench))
    assert plain.free == ()
    np.testing.assert_array_equal(plain.cases.q[:, 0], 0.4)


def test_a_sliding_joint_is_held_in_millimetres() -> None:
    path = ROOT / "examples" / "robots" / "rail-arm" / "study.yaml"
    text = path.read_text("utf-8").replace("E1: [-2500, 2500]", "E1: [1200, 1200]")
    text = text.replace("joint_limits_mm:", "joint_margin_mm: 5\n  joint_limits_mm:")
    rail = parse_study(text, path)
    assert rail.limits[:, 0].tolist() == [1.2, 1.2]
    assert isinstance(rail.joint_limits[0], HeldJoint)
    assert rail.joint_limits[0].name == "E1 = 1200 mm"
    sample = rail.space.sample(20, np.random.default_rng(0))
    assert (sample[:, 0] == 1.2).all()


def test_the_program_does_not_move_it(plan: ec.Plan) -> None:
    """Every axis is approached from the same side, but for the one that stays."""
    program = campaign_program(plan.study, plan.load_cases, plan.repeats)
    np.testing.assert_array_equal(program.targets[:, 0], plan.load_cases.q[0, 0])
    assert np.ptp(program.targets[:, 1]) > 0.0
    home = np.radians([25.0, 60.0, 0.0])
    moved = campaign_program(plan.study, plan.load_cases, plan.repeats, home=home)
    assert "Home breaks J1 = 10° by 15°." in moved.notes
    home[0] = np.radians(10.0)
    kept = campaign_program(plan.study, plan.load_cases, plan.repeats, home=home)
    assert not any("Home breaks" in note for note in kept.notes)


def test_the_report_says_where_it_is_held(plan: ec.Plan) -> None:
    page = html(Contents(plan))
    assert len(re.findall("held at 10.00°", page)) == 2  # drawn for two widths
    for width in (360.0, 720.0):
        assert "nan" not in range_chart(plan, width)


def test_where_every_joint_is_held_trees_do_not_grow() -> None:
    """The search for a way around must end: no edge has a length."""
    base = study()
    space = replace(base.motion_space, limits=np.tile([0.1, 0.2, 0.3], (2, 1)))
    start, goal, rng = np.zeros(3), np.array([0.1, 0.2, 0.3]), np.random.default_rng(0)
    assert via_points._connected(space, start, goal, rng) is None
    assert via_points._connected(base.motion_space, start, goal, rng) is not None


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ("joint_limits_deg: {J1: [1, 0]}", "must be below the upper one, 0, or equal to it"),
        ("joint_limits_deg: {J1: [400, 400]}", "go beyond those of the robot"),
        ("joint_limits_deg: {J1: [-2, 2]}\n  joint_margin_deg: 2", "the margin leaves joint 'J1'"),
        ("joint_limits_deg: {J1: [-2, 2]}\n  joint_margin_deg: 3", "no room left"),
    ],
)
def test_what_is_no_range_is_refused(limits: str, message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        study(f"constraints:\n  {limits}\n")
