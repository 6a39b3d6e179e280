"""Clearances: against Pinocchio and coal, solids of every kind, and what is left out."""

from __future__ import annotations

import tracemalloc
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
import trimesh

from elastocal.constraints import Clearance
from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.constraints.clearance import PLENTY
from elastocal.constraints.collision.chain import robot_solids
from elastocal.constraints.collision.coal_distance import Placements
from elastocal.constraints.collision.solid import bounding_capsule, solids_of
from elastocal.errors import InputError
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.robot.rotations import from_zyx_angles
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import kuka_kr270
from tests.arms import central_difference, random_rotation, random_transform
from tests.constraints.collision.oracle import CellOracle

KUKA = kuka_kr270()
TOOL = KUKA.tools["calibration"]
LIMITS = np.array([KUKA.lower, KUKA.upper])
BOXES = {
    "table": (np.array([1.2, 1.6, 0.7]), transform(None, (1.7, 0.0, 0.35))),
    "wall": (
        np.array([5.0, 0.1, 3.0]),
        transform(random_rotation(np.random.default_rng(3)), (0.0, 1.5, 1.5)),
    ),
}


def boxes() -> list[Shape]:
    return [Shape("box", size, pose, 0, name) for name, (size, pose) in BOXES.items()]


def configurations(count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(*LIMITS, (count, 6))


def watched(
    obstacles: list[Shape], rules: CollisionRules | None = None, robot: Robot = KUKA
) -> dict[str, Clearance]:
    limits = np.array([robot.lower, robot.upper])
    found = clearances(robot, TOOL, limits, obstacles, rules or CollisionRules())
    return {c.what: c for c in found}


def test_with_nothing_to_touch_there_is_all_the_room() -> None:
    """A clearance without pairs: never broken, and called by what it is about."""
    none = Clearance("table", replace(watched(boxes())["table"].pairs, index=()), 0.02)
    posture = Posture(KUKA, configurations(2))
    np.testing.assert_array_equal(none.room(posture), np.inf)
    assert none.names_at(posture) == ["clearance of table >= 20 mm"] * 2
    margin, pull = none.at(posture)
    assert (margin > 0.0).all()
    np.testing.assert_array_equal(pull(np.ones(2)), np.zeros((6, 2)))


def test_distances_are_those_of_pinocchio_and_coal() -> None:
    cell, oracle = watched(boxes()), CellOracle(KUKA, TOOL, BOXES, 0.02)
    q = configurations(60)
    posture = Posture(KUKA, q)
    touching = 0
    for name in BOXES:
        expected = np.array([oracle.obstacle(one, name) for one in q])
        assert cell[name].room(posture) == pytest.approx(expected - 0.02, abs=2e-6)
        touching += int((expected < 0.0).sum())
    left = {frozenset((x.first, x.second)) for x in cell["itself"].unwatched}
    # Joints at one place: the link before covers them, here all are watched.
    left |= {frozenset(p) for p in (("A4", "A6"), ("A5", "A6"), ("A6", "tool"), ("A5", "tool"))}
    expected = np.array([oracle.itself(one, left) for one in q])
    assert cell["itself"].room(posture) == pytest.approx(expected - 0.02, abs=2e-6)
    assert touching > 10, "the comparison saw nothing in collision"


def test_the_search_sees_the_same_where_it_matters() -> None:
    q = configurations(500)
    posture = Posture(KUKA, q)
    for constraint in watched(boxes()).values():
        capped = np.minimum(constraint.room(posture), PLENTY)
        assert constraint.at(posture)[0] == pytest.approx(capped, abs=1e-12)


def test_what_always_touches_is_left_out_and_listed() -> None:
    left = watched([])["itself"].unwatched
    told = {(x.first, x.second): x.why for x in left}
    assert told[("A1", "A2")] == "neighbours"
    assert told[("A4", "A5")] == "neighbours"
    assert ("A1", "A4") not in told
    assert ("A2", "A4") not in told, "the outer part of the forearm is watched"


def test_nothing_is_left_out_that_is_free_somewhere() -> None:
    """Links left out are nearer than the margin in every posture, by coal; all others watched."""
    itself, oracle = watched([])["itself"], CellOracle(KUKA, TOOL, {}, 0.02)
    names = [name for name, *_ in oracle.capsules(np.zeros(6))]
    every = {frozenset(pair) for pair in combinations(names, 2)}
    q = configurations(40, seed=2)
    always = [x for x in itself.unwatched if x.why in ("always-touch", "always-near")]
    for pair in ({x.first, x.second} for x in always):
        assert all(oracle.itself(one, every - {frozenset(pair)}) < 0.02 for one in q), pair
    kept = {itself.pair_name(p) for p in range(len(itself.pairs))}
    assert {"A5 from A1", "tool from A1", "A4 from A1", "tool from A3"} <= kept


def test_what_the_robot_stands_on_is_left_out_and_a_wall_in_its_way_is_not() -> None:
    floor = Shape("box", np.array([6.0, 6.0, 0.1]), transform(None, (0, 0, -0.05)), 0, "floor")
    room = Shape("box", np.full(3, 9.0), transform(None, (2.7, 3.1, -3.0)), 0, "rock")
    cell = watched([floor, room])
    assert [(x.first, x.why) for x in cell["floor"].unwatched] == [("A1", "stands-on-it")]
    assert len(cell["rock"].pairs) == 5
    assert not cell["rock"].unwatched


def test_on_a_rail_the_turntable_stands_on_the_floor_too() -> None:
    """Up to the first joint that turns: carriage and turntable, and not the arm on them."""
    joints = (
        Joint("rail", np.eye(4), np.array([1.0, 0, 0]), True, -1.0, 1.0),
        Joint("table", np.eye(4), np.array([0.0, 0, 1]), False, -1.0, 1.0),
        Joint("arm", transform(None, (0, 0, 0.1)), np.array([0.0, 0, 1]), False, -1.0, 1.0),
    )
    balls = tuple(
        Shape("sphere", np.array([0.2]), transform(None, (0, 0, 0.1 * (body < 3))), body)
        for body in (1, 2, 3)
    )
    floor = Shape("box", np.array([9.0, 9.0, 1.0]), transform(None, (0, 0, -0.5)), 0, "floor")
    found = watched([floor], robot=Robot("rail", joints, collisions=balls))["floor"]
    assert [x.first for x in found.unwatched] == ["rail", "table"]
    assert {found.pairs.of(p)[0].name for p in range(len(found.pairs))} >= {"arm"}


def test_ignored_pairs_are_not_watched() -> None:
    rules = CollisionRules(ignore=(("A4", "table"), ("tool", "A1")))
    cell = watched(boxes(), rules)
    names = [cell["table"].pair_name(i) for i in range(len(cell["table"].pairs))]
    assert "A4 from table" not in names
    assert all(name.endswith(" from table") for name in names)
    assert "A3 from table" in names
    assert "ignored" in {x.why for x in cell["itself"].unwatched}


def test_names_say_which_pair_is_nearest() -> None:
    q = np.radians([[0.0, -10.0, 60.0, 0.0, 0.0, 0.0]])
    constraint = watched(boxes())["table"]
    assert constraint.names_at(Posture(KUKA, q)) == ["clearance of A4 from table >= 20 mm"]


def with_shapes(shapes: list[Shape]) -> Robot:
    return Robot("shaped", KUKA.joints, KUKA.T_tip_flange, KUKA.tools, collisions=tuple(shapes))


def every_kind(tmp_path: Path) -> list[Shape]:
    rng = np.random.default_rng(5)
    mesh = tmp_path / "link.stl"
    trimesh.creation.icosphere(2, 0.4).export(mesh)
    sizes = {
        "box": [0.4, 0.3, 0.9],
        "cylinder": [0.2, 0.8],
        "sphere": [0.3],
        "capsule": [0.2, 0.6],
        "mesh": [0.5, 0.5, 2.0],
    }
    return [
        Shape(kind, np.array(size), random_transform(rng), 2 + i, kind, mesh)
        for i, (kind, size) in enumerate(sizes.items())
    ]


def test_gradients_of_solids_without_closed_form(tmp_path: Path) -> None:
    """By coal, whose distances are good to about 1e-7: differences can tell 1e-4."""
    obstacle = Shape("cylinder", np.array([0.4, 1.5]), transform(None, (1.0, 0.3, 1.0)), 0, "post")
    for shape in every_kind(tmp_path):
        robot = with_shapes([shape])
        constraint = watched([obstacle], CollisionRules(itself=False), robot)["post"]
        q = configurations(40)
        margin = constraint.margin(robot, q)
        q = q[margin < 0.04][:8]
        gradient = constraint.gradient(robot, q)
        expected = central_difference(lambda x: constraint.margin(robot, x), q, step=1e-3)  # noqa: B023
        agree = np.abs(gradient - expected).max(axis=1) < 2e-3
        assert agree.mean() > 0.7, shape.kind  # the others sit at an edge, where there is a kink
        assert len(q) > 3


def test_solids_of_every_kind_stay_inside_what_bounds_them(tmp_path: Path) -> None:
    """The sieve may never let a near pair through: bounds are below the distances of coal."""
    wall = Shape(
        "mesh", np.full(3, 1e-3), transform(None, (1, 1, 1)), 0, "wall", tmp_path / "w.ply"
    )
    trimesh.creation.box((2000.0, 100.0, 1500.0)).export(tmp_path / "w.ply")
    robot = with_shapes(every_kind(tmp_path))
    constraint = watched([wall], robot=robot)["wall"]
    posture = Posture(robot, configurations(50))
    everything = constraint.room(posture)
    places = Placements(posture)
    for i in range(len(constraint.pairs)):
        first, second = constraint.pairs.of(i)
        each = constraint.pairs.coal(i)(places, np.arange(posture.count))[0]
        assert (everything <= each - 0.02 + 1e-6).all(), first.name
    assert {second.name} == {"wall"}


def test_a_mesh_of_two_parts_is_two_solids_and_the_gap_is_free(tmp_path: Path) -> None:
    gate = trimesh.util.concatenate(
        [trimesh.creation.box((0.2, 0.2, 3.0), transform(None, (x, 0, 0))) for x in (-2.0, 2.0)]
    )
    gate.export(tmp_path / "gate.obj")
    slide = Joint("X", np.eye(4), np.array([0.0, 1.0, 0.0]), True, -1.0, 1.0)
    ball = Shape("sphere", np.array([0.5]), np.eye(4), 1, "ball")
    robot = Robot("slider", (slide,), collisions=(ball,))
    tool = Tool("none", np.zeros(3), np.zeros((1, 3)), ("M",), radius=0.01)
    shape = Shape("mesh", np.ones(3), np.eye(4), 0, "gate", tmp_path / "gate.obj")
    limits = np.array([robot.lower, robot.upper])
    (gap,) = clearances(robot, tool, limits, [shape], CollisionRules(itself=False, margin=0.0))
    assert gap.room(Posture(robot, np.zeros((1, 1)))) == pytest.approx([1.4], abs=1e-6)


def test_the_capsule_around_points_holds_them() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        points = rng.normal(size=(rng.integers(4, 40), 3)) * rng.uniform(0.01, 2.0, 3)
        segment, radius = bounding_capsule(points)
        along = segment[1] - segment[0]
        share = np.clip((points - segment[0]) @ along / max(along @ along, 1e-300), 0.0, 1.0)
        off = np.linalg.norm(points - segment[0] - share[:, None] * along, axis=1)
        assert off.max() <= radius * (1.0 + 1e-9)


def test_a_capsule_around_many_points_takes_room_in_proportion() -> None:
    points = np.random.default_rng(0).normal(size=(3000, 3))
    tracemalloc.start()
    bounding_capsule(points)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 50 * points.nbytes  # an orthogonal matrix of 3000 columns has 1000 times as much


def test_a_ram_is_carried_by_the_joint_that_slides() -> None:
    z = np.array([0.0, 0.0, 1.0])
    turn = Joint("J1", np.eye(4), z, False, -3.0, 3.0)
    ram = Joint("Z", transform(None, (0.5, 0.0, 0.0)), -z, True, 0.0, 0.3)
    robot = Robot("scara", (turn, ram))
    solid = next(s for s in robot_solids(robot) if s.name == "Z")
    ends = Posture(robot, np.array([[0.0, 0.2]])).point(np.array(solid.segment[0]), 2)
    assert ends[:, 0] == pytest.approx([0.5, 0.0, 0.1])  # 0.3 behind a tip that is 0.2 down
    assert forward_kinematics(robot, np.array([[0.0, 0.2]]))[0, :3, 3] == pytest.approx(
        [0.5, 0.0, -0.2]
    )


@pytest.mark.parametrize(
    ("rules", "names", "expected"),
    [
        (CollisionRules(ignore=(("A1", "A9"),)), ["table"], "nothing is called 'A9'"),
        (CollisionRules(), ["table", "table"], "two obstacles are called 'table'"),
        (CollisionRules(), ["A3"], "'A3' has the name of a part of the robot"),
        (CollisionRules(), ["tool"], "has the name of a part"),
    ],
)
def test_names_that_cannot_be_meant(rules: CollisionRules, names: list[str], expected: str) -> None:
    shapes = [Shape("sphere", np.array([0.1]), np.eye(4), 0, name) for name in names]
    with pytest.raises(InputError, match=expected):
        watched(shapes, rules)


def test_a_mesh_that_was_not_found_is_refused() -> None:
    shape = Shape("mesh", np.ones(3), np.eye(4), 2, "link2", None, "package://arm/link2.stl")
    with pytest.raises(InputError, match=r"'package://arm/link2.stl' of 'link2' was not found"):
        watched([], robot=with_shapes([shape]))


def test_capsules_around_links_are_on_the_safe_side(tmp_path: Path) -> None:
    robot, wall = with_shapes(every_kind(tmp_path)), boxes()[1]
    posture = Posture(robot, configurations(200))
    hulls = watched([wall], robot=robot)["wall"]
    capsules = watched([wall], CollisionRules(as_capsules=True), robot)["wall"]
    assert len(capsules.pairs) == len(hulls.pairs)
    difference = hulls.room(posture) - capsules.room(posture)
    assert difference.min() > -1e-6
    assert difference.max() > 0.01


def test_links_that_are_always_nearer_than_the_margin_are_left_out() -> None:
    """A plate 10 mm over the next but one link: no configuration could keep 20 mm."""
    z = np.array([0.0, 0.0, 1.0])
    joints = tuple(Joint(f"J{i}", np.eye(4), z, False, -3.0, 3.0) for i in range(1, 4))
    plates = tuple(
        Shape("cylinder", np.array([0.3, 0.02]), transform(None, (0, 0, h)), body, f"plate {body}")
        for body, h in ((1, 0.0), (3, 0.03))
    )
    robot = Robot("turntables", joints, collisions=plates)
    (left,) = watched([], robot=robot)["itself"].unwatched[:1]
    assert (left.first, left.second) == ("plate 1", "plate 3")
    assert left.why == "always-near"
    assert len(watched([], CollisionRules(margin=0.005), robot)["itself"].pairs)


@pytest.mark.parametrize(
    ("height", "why"), [(0.0395, "always-close"), (0.0475, ""), (0.03, "always-near")]
)
def test_links_whose_gap_hardly_changes_are_left_out(height: float, why: str) -> None:
    """A ball on a turntable over a plate that is not quite level: its gap changes by 6 mm."""
    z = np.array([0.0, 0.0, 1.0])
    joints = tuple(Joint(f"J{i}", np.eye(4), z, False, -3.0, 3.0) for i in range(1, 4))
    level = transform(from_zyx_angles(np.array([[0.0, 0.0, 0.03]]))[0], (0.0, 0.0, 0.0))
    plate = Shape("box", np.array([1.0, 1.0, 0.02]), level, 1, "plate")
    ball = Shape("sphere", np.array([0.01]), transform(None, (0.2, 0.0, height)), 3, "ball")
    robot = Robot("turntables", joints, collisions=(plate, ball))
    left = {(x.first, x.second): x.why for x in watched([], robot=robot)["itself"].unwatched}
    assert left.get(("plate", "ball"), "") == why


def test_parts_inside_other_parts_and_many_parts_do_not_multiply(tmp_path: Path) -> None:
    inner = trimesh.creation.box((0.1, 0.1, 0.1))
    outer = trimesh.creation.box((0.5, 0.5, 0.5))
    trimesh.util.concatenate([outer, inner]).export(tmp_path / "filled.stl")
    shape = Shape("mesh", np.ones(3), np.eye(4), 0, "filled", tmp_path / "filled.stl")
    assert len(solids_of(shape, "filled")) == 1
    row = [trimesh.creation.box((0.1, 0.1, 0.1), transform(None, (x, 0, 0))) for x in range(5)]
    trimesh.util.concatenate(row).export(tmp_path / "row.stl")
    cell = Shape("mesh", np.ones(3), np.eye(4), 0, "row", tmp_path / "row.stl")
    link = Shape("mesh", np.ones(3), np.eye(4), 1, "row", tmp_path / "row.stl")
    assert len(solids_of(cell, "row")) == 5, "an obstacle keeps its gaps"
    (whole,) = solids_of(link, "row")
    assert np.ptp(whole.vertices, axis=0) == pytest.approx([4.1, 0.1, 0.1])
