"""What the robot and its surroundings are drawn with."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.drawing.shape_solids import solid_of
from elastocal.drawing.skeleton import skeletons
from elastocal.drawing.solids import Mesh
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import kuka_kr270
from elastocal.robot.sources.urdf import from_urdf
from elastocal.viewer.frames import rigid_frames
from elastocal.viewer.parts import chain_parts, robot_parts, tool_parts
from elastocal.viewer.readout import Room, read_out
from elastocal.viewer.subject import Subject
from elastocal.viewer.surroundings import (
    apertures,
    beams,
    cones,
    floors,
    ghost,
    obstacles,
    reach,
    tracker_solid,
    walls,
)
from tests.robot.sources.oracle import zoo
from tests.viewer.examples import example, kr270, tracked


def volume(solid: Mesh) -> float:
    """Signed volume: positive if every triangle looks outwards."""
    a, b, c = (solid.vertices[solid.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize(
    ("kind", "size", "exact"),
    [
        ("box", [0.2, 0.4, 0.6], 0.2 * 0.4 * 0.6),
        ("sphere", [0.3], 4 / 3 * np.pi * 0.3**3),
        ("cylinder", [0.2, 0.5], np.pi * 0.2**2 * 0.5),
        ("capsule", [0.2, 0.5], np.pi * 0.2**2 * 0.5 + 4 / 3 * np.pi * 0.2**3),
    ],
)
def test_shapes_have_their_volume_where_they_stand(
    kind: str, size: list[float], exact: float
) -> None:
    pose = np.eye(4)
    pose[:3, :3] = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    pose[:3, 3] = [1.0, -2.0, 3.0]
    solid = solid_of(Shape(kind, np.array(size), pose, 0))
    assert volume(solid) == pytest.approx(exact, rel=0.03)
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    assert 0.5 * (low + high) == pytest.approx(pose[:3, 3], abs=0.01)


def test_a_mesh_is_drawn_as_it_is(tmp_path: Path) -> None:
    corner = "v 0 0 0\nv 1000 0 0\nv 0 1000 0\nv 0 0 1000\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    file = tmp_path / "corner.obj"
    file.write_text(corner)
    shape = Shape("mesh", np.full(3, 1e-3), np.eye(4), 1, "link", file, "corner.obj")
    assert volume(solid_of(shape)) == pytest.approx(1.0 / 6.0)
    robot = replace(kuka_kr270(), visuals=(shape,))
    parts, remarks = robot_parts(robot)
    assert [part.body for part in parts] == [1]
    assert remarks == ()


def test_what_cannot_be_drawn_is_replaced_and_said(tmp_path: Path) -> None:
    file = tmp_path / "arm.dae"
    file.write_text("<COLLADA/>")
    lost = Shape("mesh", np.ones(3), np.eye(4), 1, "arm", file, "package://arm/visual/arm.dae")
    gone = Shape("mesh", np.ones(3), np.eye(4), 2, "hand", None, "hand.stl")
    simple = Shape("box", np.ones(3), np.eye(4), 1, "arm")
    parts, remarks = robot_parts(replace(kuka_kr270(), visuals=(lost, gone), collisions=(simple,)))
    assert {part.body for part in parts} == {1, 2}
    assert len(remarks) == 1
    assert "2 of 2 shapes" in remarks[0]
    assert "arm.dae" in remarks[0]
    assert "/" not in remarks[0]


@pytest.mark.parametrize("name", ["gantry-5", "rail-arm", "scara-700", "arm-7r"])
def test_robots_from_files_are_drawn_with_their_own_shapes(name: str) -> None:
    robot = example(name).study.robot
    parts, remarks = robot_parts(robot)
    assert len(parts) == len(robot.visuals)
    assert remarks == ()


@pytest.mark.parametrize(
    ("urdf", "base", "tip"),
    [
        ("robots/talos_left_arm.urdf", "arm_left_1_link", "gripper_left_base_link"),
        ("urdf/ur5_robot.urdf", "base_link", "tool0"),
    ],
)
def test_robots_with_meshes(urdf: str, base: str, tip: str) -> None:
    """Meshes of either format, STL and COLLADA, are drawn."""
    path = zoo(urdf)
    folder = next(up for up in path.parents if up.name == "example-robot-data")
    robot = from_urdf(path, base=base, tip=tip, packages={"example-robot-data": folder})
    parts, remarks = robot_parts(robot)
    assert len(parts) == len(robot.visuals)
    assert not remarks
    assert sum(len(part.solid.triangles) for part in parts) > 5000
    frames = rigid_frames(robot, np.zeros(len(robot.joints)))
    for part in parts:
        middle = part.solid.vertices.mean(axis=0)
        at = frames[part.body][:3, :3] @ middle + frames[part.body][:3, 3]
        assert np.linalg.norm(at) < 1.5  # not in millimetres


@pytest.mark.parametrize("name", ["kuka-kr270", "gantry-5", "rail-arm", "arm-7r"])
def test_a_chain_of_tubes_joins_the_joints(name: str) -> None:
    robot = kuka_kr270() if name == "kuka-kr270" else example(name).study.robot
    q = np.clip(np.full(len(robot.joints), 0.4), robot.lower, robot.upper)
    frames = rigid_frames(robot, q)
    points = []
    for part in chain_parts(robot):
        vertices = part.solid.vertices
        assert np.isfinite(vertices).all()
        frame = frames[part.body]
        points.append(vertices @ frame[:3, :3].T + frame[:3, 3])
    posture = Posture(robot, q[None])
    drawn = np.vstack(points)
    for body in [*posture.bodies[1:], posture.bodies[-1]]:
        assert np.linalg.norm(drawn - body[3, :, 0], axis=1).min() < 0.25


def test_tools_reach_to_their_points() -> None:
    robot = kuka_kr270()
    for tool in robot.tools.values():
        parts = tool_parts(robot, tool)
        assert {part.body for part in parts} == {7}
        drawn = np.vstack([part.solid.vertices for part in parts])
        assert np.isfinite(drawn).all()
        for point in (tool.tcp, tool.load_point, *tool.markers):
            assert np.linalg.norm(drawn - point, axis=1).min() < 0.08


def test_the_ghost_of_a_test_pose_stands_where_the_robot_would() -> None:
    subject = kr270()
    stop = subject.stops[-1]
    solid = ghost(subject, stop)
    skeleton = skeletons(subject.study.robot, stop.tool, stop.q[None])[0]
    assert np.isfinite(solid.vertices).all()
    for point in (*skeleton.arm, skeleton.tcp):
        assert np.linalg.norm(solid.vertices - point, axis=1).min() < 0.06


def _first(subject: Subject) -> tuple[Array, tuple[Room, ...]]:
    stop = subject.stops[0]
    return stop.q, read_out(subject, stop.tool, stop.q, stop.wrench).rooms


def test_beams_go_from_the_tracker_to_every_marker() -> None:
    subject = tracked()
    q, rooms = _first(subject)
    tool = subject.study.experiments.tool
    found = beams(subject, tool, q, rooms)
    assert [beam.marker for beam in found] == ["M1", "M2"]
    posture = Posture(subject.study.robot, q[None])
    for beam, marker in zip(found, tool.markers, strict=True):
        assert beam.ends[0] == pytest.approx([4.5, 0.0, 1.5])
        assert beam.ends[1] == pytest.approx(posture.point(marker)[:, 0])
    broken = (Room("acceptance of M1", -0.1, "rad", "M1"), Room("range of M2", 0.1, "m", "M2"))
    assert [beam.seen for beam in beams(subject, tool, q, broken)] == [False, True]


def test_a_cone_is_met_where_its_margin_says_so() -> None:
    subject = tracked()
    tool, robot = subject.study.experiments.tool, subject.study.robot
    rng = np.random.default_rng(1)
    met = []
    for q in rng.uniform(*subject.study.limits, (200, 6)):
        (cone,) = cones(subject, tool, q)
        posture = Posture(robot, q[None])
        tip = posture.point(tool.markers[0])[:, 0]
        assert cone.solid.vertices[0] == pytest.approx(tip)
        rays = cone.solid.vertices[1:] - tip
        axis = posture.direction(np.array([1.0, 0.0, 0.0]))[:, 0]
        angles = np.degrees(np.arccos(rays @ axis / np.linalg.norm(rays, axis=1)))
        assert angles == pytest.approx(40.0)
        to_tracker = np.array([4.5, 0.0, 1.5]) - tip
        off = np.degrees(np.arccos(to_tracker @ axis / np.linalg.norm(to_tracker)))
        assert cone.met == (off <= 40.0)
        met.append(cone.met)
    assert 0 < sum(met) < 200


def test_another_tool_has_no_beams_cones_or_apertures() -> None:
    subject = kr270()
    stop = subject.stops[-1]
    assert beams(subject, stop.tool, stop.q, ()) == ()
    assert cones(subject, stop.tool, stop.q) == ()
    assert apertures(subject, stop.tool, stop.q) == ()
    first = subject.stops[0]
    assert [s.name for s in apertures(subject, first.tool, first.q)] == [
        "elevation of flange z <= 30°"
    ]


def test_walls_are_drawn_once_and_obstacles_as_what_they_are() -> None:
    assert [shape.name for shape in obstacles(tracked())] == ["table"]
    (both,) = walls(tracked())
    assert both.name == "height of M1/M2 >= 500 mm"
    assert len(walls(kr270())) == 2


def test_the_floor_that_is_watched_is_drawn_where_it_is() -> None:
    subject, height = kr270(), -0.35
    assert not floors(subject)
    study = subject.study
    rules = replace(CollisionRules(), floor=height, itself=False)
    tool = study.experiments.tool
    (floor,) = clearances(study.robot, tool, study.limits, (), rules)
    below = replace(subject, study=replace(study, constraints=(*study.constraints, floor)))
    assert floors(below) == [height]
    assert reach(below)[0][2] < height < reach(subject)[0][2]
    drawn = {surface.name: surface for surface in walls(below)}["floor"]
    assert drawn.solid.vertices[:, 2] == pytest.approx(np.full(4, height), abs=1e-12)
    assert np.ptp(drawn.solid.vertices, axis=0)[:2].min() > 1.0
    assert drawn.label.tolist() in drawn.outlines[0].tolist()


def test_everything_fits_into_the_box() -> None:
    for subject in (kr270(), tracked(), example("rail-arm")):
        low, high, size = reach(subject)
        assert size > 0.0
        for stop in subject.stops:
            skeleton = skeletons(subject.study.robot, stop.tool, stop.q[None])[0]
            assert (skeleton.points >= low).all()
            assert (skeleton.points <= high).all()


def test_a_tracker_stands_on_the_floor() -> None:
    solid = tracker_solid(np.array([3.0, 1.0, 1.4]), -0.2, 2.0)
    assert solid.vertices[:, 2].min() == pytest.approx(-0.2, abs=0.03)
    assert solid.vertices[:, 2].max() == pytest.approx(1.4 + 0.06, abs=1e-6)
    low = tracker_solid(np.array([3.0, 1.0, 0.1]), 0.0, 2.0)
    assert np.isfinite(low.vertices).all()
