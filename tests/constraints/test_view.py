"""What a tracker sees: margins against plain geometry, plans re-checked by another route."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from typer.testing import CliRunner

import elastocal as ec
from elastocal.cli import app
from elastocal.constraints import AcceptanceCone, HeadAzimuth, HeadElevation, LineOfSight
from elastocal.constraints.collision.chain import robot_solids
from elastocal.constraints.collision.solid import capsule, solids_of
from elastocal.constraints.line_of_sight import NEAR_MARKER, PLENTY
from elastocal.design.exact import Effort
from elastocal.files.study.study_file import parse_study
from elastocal.measuring.instrument import Isotropic
from elastocal.planning.assessment import assess
from elastocal.planning.visibility import visibility
from elastocal.robot.chain import transform
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import kuka_kr270
from tests.arms import Oracle, central_difference

STUDY = """\
elastocal: 1
name: KR 270 before a tracker
robot: kuka-kr270
identify: [A2, A3, A4, A5, A6]
tools:
  milling: {tcp_mm: [986, 0, 0]}
  calibration:
    load_point_mm: [611.5, 0, -460]
    markers_mm: {M1: [611.5, 0, -460], M2: [611.5, 200, -300]}
    marker_axes: {M1: [1, 0, 0], M2: [1, 0.3, 0]}
    acceptance_deg: {M1: 60, M2: 50}
test_poses:
  - {tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}
experiments:
  tool: calibration
  force_N: [0, 0, -2500]
  count: 12
  max_configurations: 3
instrument:
  tracker:
    preset: leica-at500
    position_mm: [3500, -1000, 1200]
    range_mm: [1500, 6000]
    elevation_deg: [-30, 40]
    azimuth_deg: [90, 240]
constraints:
  workspace: {min_z_mm: 800, min_radius_mm: 600}
  elevation: {axis: z, max_deg: 30}
  obstacles:
    - {name: pillar, box_mm: [300, 300, 3000], center_mm: [2500, -900, 1500]}
  collision: {self: no}
  floor: off
"""
OPEN = "\n".join(
    line
    for line in STUDY.replace("leica-at500", "leica-at500\n    line_of_sight: no").splitlines()
    if not any(key in line for key in ("marker_axes", "acceptance", "range_mm", "elevation_deg"))
    and not any(key in line for key in ("azimuth", "obstacles", "pillar"))
)
POSITION = np.array([3.5, -1.0, 1.2])
LIGHT = Effort(batch=32, generations=3, patience=2, islands=1)
POINT = np.array([0.6115, 0.0, -0.460])


def study(text: str = STUDY) -> ec.Study:
    return parse_study(text, Path("view.yaml"))


@pytest.fixture(scope="module")
def planned() -> ec.Plan:
    return ec.plan(study(), seed=0, effort=LIGHT)


def test_a_plan_is_seen_by_an_independent_route(planned: ec.Plan) -> None:
    """Markers and axes by Pinocchio, angles by plain trigonometry, the beam sampled densely."""
    oracle = Oracle(planned.study.robot)
    tool = planned.study.experiments.tool
    axes = {"M1": np.array([1.0, 0.0, 0.0]), "M2": np.array([1.0, 0.3, 0.0])}
    limits = {"M1": 60.0, "M2": 50.0}
    for q in planned.load_cases.q:
        T = oracle.forward(q)
        for name, marker in zip(tool.marker_names, tool.markers, strict=True):
            beam = T[:3, :3] @ marker + T[:3, 3] - POSITION
            length = np.linalg.norm(beam)
            assert 1.5 - 1e-6 <= length <= 6.0 + 1e-6
            axis = T[:3, :3] @ axes[name]
            off = np.degrees(np.arctan2(np.linalg.norm(np.cross(axis, -beam)), axis @ -beam))
            assert off <= limits[name] + 1e-3
            rise = np.degrees(np.arctan2(beam[2], np.hypot(beam[0], beam[1])))
            assert -30.0 - 1e-3 <= rise <= 40.0 + 1e-3
            azimuth = np.degrees(np.arctan2(beam[1], beam[0])) % 360.0
            assert 90.0 - 1e-3 <= azimuth <= 240.0 + 1e-3
            along = POSITION + np.linspace(0.0, 1.0 - NEAR_MARKER / length, 2000)[:, None] * beam
            off_box = np.maximum(np.abs(along - [2.5, -0.9, 1.5]) - [0.15, 0.15, 1.5], 0.0)
            assert np.linalg.norm(off_box, axis=1).min() >= 0.01 - 1e-5


def test_the_beam_is_clear_of_the_links_by_an_independent_route(planned: ec.Plan) -> None:
    """Frames of the joints by Pinocchio, capsules sampled along their axes."""
    robot, tool = planned.study.robot, planned.study.experiments.tool
    model, data = Oracle(robot).model, None
    data = model.createData()
    solids = [s for s in robot_solids(robot) if s.body < len(robot.joints)]
    for q in planned.load_cases.q:
        pin.forwardKinematics(model, data, q)
        posture = Posture(robot, q[None])
        for marker in tool.markers:
            end = posture.point(marker)[:, 0]
            beam = end - POSITION
            share = np.linspace(0.0, 1.0 - NEAR_MARKER / np.linalg.norm(beam), 400)
            along = POSITION + share[:, None] * beam
            for solid in solids:
                a, b = (posture.point(p, solid.body)[:, 0] for p in solid.segment)
                origin = data.oMi[solid.body].translation if solid.body else np.zeros(3)
                assert posture.bodies[solid.body][3, :, 0] == pytest.approx(origin, abs=1e-9)
                axis = a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a)
                gap = np.linalg.norm(along[:, None] - axis[None], axis=2).min()
                assert gap - solid.radius >= 0.01 - 1e-3


def test_evaluate_refuses_a_plan_made_without_the_view_and_says_what_is_seen(
    planned: ec.Plan, tmp_path: Path
) -> None:
    """The negative control: the same cell without limits of the tracker, axes and pillar."""
    blind = study(OPEN)
    made = ec.plan(blind, seed=0, effort=LIGHT)
    assert not assess(blind, made.load_cases, made.repeats).violations
    path = tmp_path / "view.yaml"
    path.write_text(STUDY, encoding="utf-8")
    ec.write_plan(planned, tmp_path / "seeing.json")
    ec.write_plan(made, tmp_path / "blind.json")
    plans = [str(tmp_path / name) for name in ("seeing.json", "blind.json")]
    done = CliRunner().invoke(app, ["evaluate", str(path), *plans, "--random", "0"])
    assert done.exit_code == 3
    assert "blind.json: load case" in done.output
    assert "acceptance of M" in done.output
    assert "What the tracker sees in seeing.json" in done.output
    seeing, unseeing = done.output.split("What the tracker sees in blind.json")
    assert "no: " not in seeing.split("What the tracker sees in seeing.json")[1]
    assert "no: " in unseeing


def test_check_says_how_often_a_marker_is_seen(tmp_path: Path) -> None:
    path = tmp_path / "view.yaml"
    path.write_text(STUDY, encoding="utf-8")
    shown = CliRunner().invoke(app, ["check", str(path)]).output
    assert "The tracker sees M2 in" in shown
    share = json.loads(CliRunner().invoke(app, ["check", str(path), "--json"]).stdout)["seen_share"]
    assert 0.0 < share["M2"] < 1.0


def test_a_plan_for_the_instrument_is_better_than_one_for_noise_alike_everywhere() -> None:
    """KR 270 with a tracker 3 m before it: the same view for both, the noise of one."""
    text = STUDY.replace("[3500, -1000, 1200]", "[3000, 0, 1200]").replace("[1500,", "[1000,")
    for marker in (", M2: [611.5, 200, -300]", ", M2: [1, 0.3, 0]", ", M2: 50"):
        text = text.replace(marker, "")
    aware = study(text.split("  obstacles")[0])
    alike = replace(aware, instrument=Isotropic(aware.sigma))
    ours = ec.plan(aware, seed=0, effort=LIGHT)
    theirs = ec.plan(alike, seed=0, effort=LIGHT)
    worth = assess(aware, theirs.load_cases, theirs.repeats)
    assert not worth.violations
    assert ours.assessment.rho0 < 0.85 * worth.rho0
    assert ours.assessment.rho0 < 1.05 * ours.certificate.lower_bound
    assert ours.certificate.lower_bound < ours.assessment.rho0


@pytest.mark.parametrize("kind", ["capsule", "sphere", "box"])
def test_line_of_sight_is_the_distance_of_a_sampled_beam(kind: str) -> None:
    """Solids in the cell, beam and capsule sampled; gradients where the beam is blocked too."""
    robot, rng = kuka_kr270(), np.random.default_rng(1)
    q = rng.uniform(robot.lower, robot.upper, (60, 6))
    size = {"capsule": [0.2, 1.0], "sphere": [0.4], "box": [0.5, 0.7, 0.9]}[kind]
    pose = transform(pin.rpy.rpyToMatrix(0.3, 0.7, -0.4), (2.0, -0.5, 1.3))
    shape = Shape(kind, np.array(size), pose, 0, "thing")
    sight = LineOfSight("sight", "M1", POINT, POSITION, solids_of(shape, "thing"), robot)
    room = sight.room(Posture(robot, q))
    posture = Posture(robot, q)
    for i in range(len(q)):
        beam = posture.point(POINT)[:, i] - POSITION
        share = np.linspace(0.0, 1.0 - NEAR_MARKER / np.linalg.norm(beam), 4000)
        along = (POSITION + share[:, None] * beam - pose[:3, 3]) @ pose[:3, :3]
        if kind == "box":
            over = np.abs(along) - np.array(size) / 2.0
            gap = np.linalg.norm(np.maximum(over, 0.0), axis=1)
        else:
            half = size[1] / 2.0 if kind == "capsule" else 0.0
            along[:, 2] -= np.clip(along[:, 2], -half, half)
            gap = np.linalg.norm(along, axis=1) - size[0]
        if gap.min() > 1e-3:
            assert room[i] == pytest.approx(gap.min() - 0.01, abs=2e-4)
        else:
            assert room[i] <= 0.0
    assert (room < -0.01).sum() >= 3
    near = np.flatnonzero((room < 0.9 * PLENTY) & (np.abs(room + 0.01) > 1e-3))
    gradient = sight.gradient(robot, q[near])
    expected = central_difference(lambda x: sight.room(Posture(robot, x)), q[near], step=1e-5)
    # The depth in a box has kinks, where another face is nearest: most gradients, not all.
    same = np.isclose(gradient, expected, rtol=1e-5, atol=1e-6).all(axis=1)
    assert same.mean() > 0.9


def test_what_holds_the_marker_or_the_head_is_not_in_the_way() -> None:
    robot = kuka_kr270()
    flange = robot.links[-1]
    holder = capsule("tool", 6, flange[:3, 3], flange[:3, :3] @ POINT + flange[:3, 3], 0.03)
    stand = capsule("stand", 0, POSITION - [0, 0, 1.2], POSITION, 0.1)
    other = capsule("post", 0, np.array([2.0, 0, 0]), np.array([2.0, 0, 2]), 0.1)
    sight = LineOfSight("sight", "M1", POINT, POSITION, [holder, stand, other], robot)
    assert [solid.name for solid in sight.solids] == ["post"]
    assert sight.around_head == ("stand",)


def test_an_arm_between_tracker_and_marker_is_named() -> None:
    """Home: the marker hangs before the robot, the tracker stands behind it."""
    robot = kuka_kr270()
    behind = np.array([-3.0, 0.0, 1.9])
    sight = LineOfSight("sight to M1", "M1", POINT, behind, robot_solids(robot), robot)
    posture = Posture(robot, np.radians([[0.0, -90.0, 90.0, 0.0, 0.0, 0.0]]))
    assert sight.room(posture)[0] < 0.0
    assert sight.names_at(posture)[0].startswith("sight to M1 past A")


def test_the_head_turns_past_half_a_turn() -> None:
    """A range of azimuths that crosses 180°: its margin is measured from the middle."""
    robot = kuka_kr270()
    posture = Posture(robot, np.zeros((1, 6)))
    at = posture.point(POINT)[:, 0]
    straight = HeadAzimuth(
        "a", "M1", POINT, at + np.array([2.0, 0.0, 0.0]), np.radians(150), np.radians(210)
    )
    assert straight.room(posture)[0] == pytest.approx(np.radians(30.0))
    outside = HeadAzimuth(
        "a", "M1", POINT, at - np.array([2.0, 0.0, 0.0]), np.radians(150), np.radians(210)
    )
    assert outside.room(posture)[0] == pytest.approx(np.radians(-150.0))
    level = HeadElevation("e", "M1", POINT, at - np.array([1.0, 0.0, 1.0]), 0.0, upper=True)
    assert level.room(posture)[0] == pytest.approx(np.radians(-45.0))


def test_a_beam_with_nothing_in_the_way_has_plenty_of_room() -> None:
    """No solids, or weights of zero: no gradient; far solids are not measured by the search."""
    robot, rng = kuka_kr270(), np.random.default_rng(3)
    posture = Posture(robot, rng.uniform(robot.lower, robot.upper, (5, 6)))
    empty = LineOfSight("sight", "M1", POINT, POSITION, (), robot)
    margin, pull = empty.at(posture)
    np.testing.assert_array_equal(margin, PLENTY)
    np.testing.assert_array_equal(pull(np.ones(5)), np.zeros((6, 5)))
    np.testing.assert_array_equal(empty.room(posture), np.inf)
    assert empty.names_at(posture) == ["sight"] * 5
    ball = Shape("sphere", np.array([0.4]), transform(None, (2.0, -0.5, 1.3)), 0, "ball")
    sight = LineOfSight("sight", "M1", POINT, POSITION, solids_of(ball, "ball"), robot)
    np.testing.assert_array_equal(sight.at(posture)[1](np.zeros(5)), np.zeros((6, 5)))
    both = np.minimum(sight.room(posture), PLENTY)
    np.testing.assert_allclose(sight.at(posture)[0], both, atol=1e-12)


@pytest.mark.parametrize(("beam", "room"), [(-170, 20), (170, 20), (-140, -10), (140, -10)])
def test_a_range_of_azimuths_goes_on_past_half_a_turn(beam: float, room: float) -> None:
    """150° to 210°, with the beam on either side of ±180°, inside and outside."""
    robot = kuka_kr270()
    posture = Posture(robot, np.zeros((1, 6)))
    way = np.array([np.cos(np.radians(beam)), np.sin(np.radians(beam)), 0.3])
    head = posture.point(POINT)[:, 0] - 2.0 * way
    azimuth = HeadAzimuth("a", "M1", POINT, head, np.radians(150), np.radians(210))
    assert azimuth.room(posture)[0] == pytest.approx(np.radians(room))


def test_acceptance_is_the_angle_at_the_marker() -> None:
    robot = kuka_kr270()
    posture = Posture(robot, np.zeros((1, 6)))
    at = posture.point(POINT)[:, 0]  # flange axes are those of the base there
    ahead = AcceptanceCone(
        "c", "M1", POINT, at + np.array([2.0, 0.0, 0.0]), [1, 0, 0], np.radians(30)
    )
    assert ahead.room(posture)[0] == pytest.approx(np.radians(30.0), abs=1e-6)
    aside = AcceptanceCone(
        "c", "M1", POINT, at + np.array([1.0, 1.0, 0.0]), [1, 0, 0], np.radians(30)
    )
    assert aside.room(posture)[0] == pytest.approx(np.radians(-15.0))


def test_acceptance_is_finite_where_beam_and_axis_align_to_the_last_digit() -> None:
    """The cosine may be a little over one, toward the tracker and away from it."""
    robot = kuka_kr270()
    posture = Posture(robot, np.zeros((1, 6)))
    at = posture.point(POINT)[:, 0]
    for way in np.random.default_rng(0).normal(size=(200, 3)):
        for sign, room in ((1.0, 0.5), (-1.0, 0.5 - np.pi)):
            cone = AcceptanceCone("c", "M1", POINT, at + way, sign * way, 0.5)
            assert cone.room(posture)[0] == pytest.approx(room, abs=1e-7)


def test_seen_says_what_is_broken() -> None:
    cell = study()
    away = np.radians([[180.0, -60.0, 60.0, 0.0, 0.0, 0.0]])
    view = visibility(cell.space, away)
    assert view is not None
    assert not view.seen[0, 0]
    assert view.broken[0][0]
    blind = replace(cell, instrument=Isotropic(3e-5))
    assert visibility(blind.space, away) is None


def test_a_marker_is_judged_by_its_own_conditions() -> None:
    """Two reflectors at one place, M2 turned away: M1 is seen all the same."""
    cell = study()
    at, q = Posture(cell.robot, np.zeros((1, 6))), np.zeros((1, 6))
    head = cell.instrument.position  # type: ignore[attr-defined]
    towards = head - at.point(POINT)[:, 0]
    tool = replace(
        cell.experiments.tool, markers=np.array([POINT, POINT]), marker_names=("M1", "M2")
    )
    cones = tuple(
        AcceptanceCone(f"acceptance of {name}", name, POINT, head, sign * towards, 0.5)
        for name, sign in (("M1", 1.0), ("M2", -1.0))
    )
    space = replace(cell.space, arm=replace(cell.arm, tool=tool), constraints=cones)
    view = visibility(space, q)
    assert view is not None
    np.testing.assert_array_equal(view.seen, [[True], [False]])
    assert view.broken == (("",), ("acceptance of M2",))
