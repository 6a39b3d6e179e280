"""What is watched if nothing is said: for every kind of robot, without packages or files."""

from __future__ import annotations

import re
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

import elastocal as ec
from elastocal.constraints.cell import (
    CollisionRules,
    clearances,
    default_clearances,
    stands_upright,
)
from elastocal.constraints.clearance import Clearance
from elastocal.constraints.watch import watch_of
from elastocal.errors import InputError
from elastocal.files.study.study_file import parse_study
from elastocal.planning.study_check import _doubts, check
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.robot.reach import reach_of
from elastocal.robot.rotations import from_zyx_angles
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import DHRow, from_dh, kuka_kr270
from elastocal.wording import worded
from tests.arms import Oracle
from tests.cli.test_bad_studies import GOOD
from tests.cli.test_not_watched import STUDY

QUIET = GOOD.replace("  collision: off\n  floor: off\n", "")
X, Y, Z = np.eye(3)
TOOL = Tool("rod", np.array([0.0, 0.0, 0.1]), np.array([[0.0, 0.0, 0.1]]), ("M",))


def study(text: str) -> ec.Study:
    return parse_study(text, Path("study.yaml"))


def upright(base: np.ndarray | None = None, axis: np.ndarray = Z) -> Robot:
    """Two links of 0.8 m on a turntable, the shoulder 0.5 m over it."""
    joints = (
        Joint("turn", np.eye(4) if base is None else base, axis, False, -3.0, 3.0),
        Joint("shoulder", transform(None, (0.0, 0.0, 0.5)), Y, False, -3.1, 3.1),
        Joint("elbow", transform(None, (0.8, 0.0, 0.0)), Y, False, -3.1, 3.1),
    )
    return Robot("arm", joints, transform(None, (0.8, 0.0, 0.0)))


@pytest.mark.parametrize("off", ["off", "Off", "false", "False", "no", "'off'", '"false"'])
def test_switched_off_by_name(off: str) -> None:
    both = watch_of(study(QUIET).constraints)
    assert (both.watched, both.unwatched) == (("floor", "itself"), ())
    neither = watch_of(study(QUIET + f"  collision: {off}\n  floor: {off}\n").constraints)
    assert (neither.watched, neither.unwatched) == ((), ("itself", "floor"))
    one = watch_of(study(QUIET + f"  collision: {off}\n").constraints)
    assert (one.watched, one.unwatched) == (("floor",), ("itself",))
    other = watch_of(study(QUIET + f"  floor: {off}\n").constraints)
    assert (other.watched, other.unwatched) == (("itself",), ("floor",))
    asked = watch_of(study(QUIET + "  collision: {self: false}\n").constraints)
    assert asked.unwatched == ("itself",)


@pytest.mark.parametrize("wrong", ["true", "on", "7", "0", "up", "[1]"])
def test_neither_off_nor_keys(wrong: str) -> None:
    found = {"true": "true", "on": "true", "up": "'up'", "[1]": r"\[1\]"}.get(wrong, wrong)
    may_be = {"collision": r"\{\}, which may have keys such as margin_mm: 20"}
    may_be["floor"] = r"\{z_mm: …\}, its height in the base frame"
    for key, section in may_be.items():
        said = rf"line 17: constraints.{key}: expected off or {section}, found {found}$"
        with pytest.raises(InputError, match=said):
            study(QUIET + f"  {key}: {wrong}\n")


@pytest.mark.parametrize(
    ("height", "below"),
    [(2000, "base, A1, on which the robot stands, are"), (340, "base, on which"), (100, "")],
)
def test_a_floor_over_the_robot_is_said(height: int, below: str) -> None:
    """The turntable of this robot is a column up to 675 mm; nothing stands on a floor above it."""
    found = study(QUIET + f"  floor: {{z_mm: {height}}}\n")
    said = [worded(d) for d in _doubts(found, 3.0) if d.code == "robot-below-floor"]
    (floor,) = (c for c in found.constraints if isinstance(c, Clearance) and c.what == "floor")
    assert ("below-it" in {left.why for left in floor.unwatched}) == (height == 2000)
    assert len(said) == bool(below)
    if said:
        assert said[0].startswith(below)
        assert said[0].endswith(
            f"wholly below the floor, which is {height} mm above the origin of the base: is it "
            "meant to be below, as in constraints: {floor: {z_mm: -300}}?"
        )


def test_the_floor_needs_its_height_and_may_be_elsewhere() -> None:
    with pytest.raises(InputError, match="'z_mm' is missing"):
        study(QUIET + "  floor: {}\n")
    (low,) = study(QUIET + "  collision: off\n  floor: {z_mm: -250}\n").constraints[-1:]
    assert isinstance(low, Clearance)
    assert low.height == -0.25


def test_an_obstacle_called_floor_takes_its_place() -> None:
    floor = "  obstacles: [{name: %s, box_mm: [9000, 9000, 100], center_mm: [0, 0, -350]}]\n"
    found = study(QUIET + floor % "Floor").constraints
    assert [c.what for c in found if isinstance(c, Clearance)] == ["Floor", "itself"]
    assert watch_of(found).unwatched == ()
    with pytest.raises(InputError, match="two obstacles are called 'floor'"):
        study(QUIET + floor % "floor" + "  floor: {z_mm: 0}\n")


def test_explicit_rules_keep_the_floor() -> None:
    found = study(QUIET + "  collision: {margin_mm: 50, ignore: [[A3, floor]]}\n").constraints
    floor = next(c for c in found if isinstance(c, Clearance) and c.height is not None)
    assert floor.keep == 0.05
    assert ("A3", "floor", "ignored") in [(u.first, u.second, u.why) for u in floor.unwatched]


@pytest.mark.parametrize(
    ("robot", "gravity", "expected"),
    [
        (upright(), 0.0, True),
        (upright(), -9.81, True),
        (upright(), 9.81, False),  # hangs from a ceiling, z down
        (upright(axis=-Z), 0.0, True),  # as KUKA counts A1
        (upright(transform(None, (0.3, 2.0, 0.2))), 0.0, True),
        (
            upright(transform(from_zyx_angles(np.array([[0.0, np.pi, 0.0]]))[0], (0, 0, 2.5))),
            0,
            False,
        ),
        (upright(transform(from_zyx_angles(np.array([[0.0, np.pi / 2, 0.0]]))[0])), 0, False),
        (upright(transform(from_zyx_angles(np.array([[0.0, 0.005, 0.0]]))[0])), 0, True),
        (upright(transform(None, (0.0, 0.0, -0.5))), 0.0, False),  # base at the shoulder
        (kuka_kr270(), 0.0, True),
    ],
)
def test_where_a_floor_is_assumed(robot: Robot, gravity: float, expected: bool) -> None:
    down = (0.0, 0.0, gravity)
    assert stands_upright(robot, down) == expected
    found = default_clearances(robot, TOOL, gravity=down)
    assert [c.what for c in found] == ["floor", "itself"][not expected :]
    assert watch_of(found).unwatched == (() if expected else ("floor",))


def test_sideways_gravity_is_no_floor() -> None:
    assert not stands_upright(upright(), (9.81, 0.0, 0.0))
    assert not stands_upright(upright(), (0.0, 5.0, -5.0))


def test_on_a_rail_the_first_axis_that_turns_counts() -> None:
    rail = Joint("rail", np.eye(4), X, True, -2.0, 2.0)
    on_it = Robot("railed", (rail, *upright().joints), upright().T_tip_flange)
    assert stands_upright(on_it)
    assert reach_of(on_it) == pytest.approx(reach_of(upright()), rel=0.1)
    assert not stands_upright(Robot("slider", (rail,)))


def test_links_and_tool_keep_from_the_floor_and_not_only_the_tool_point() -> None:
    """Elbow down: the tool is high, the elbow under the floor."""
    robot = upright()
    floor, _ = default_clearances(robot, TOOL)
    radius = 0.05 * reach_of(robot)
    q = np.array([[0.3, 1.0, -2.2], [0.0, -0.5, 1.4], [0.0, -1.0, 0.0]])
    elbow, flange = 0.5 - 0.8 * np.sin(q[:, 1]), forward_kinematics(robot, q)[:, 2, 3]
    tip = flange + 0.1 * np.cos(q[:, 1:].sum(axis=1))
    least = np.minimum(np.minimum(0.5, elbow), flange) - radius
    least = np.minimum(least, np.minimum(flange, tip) - TOOL.radius)
    assert floor.room(Posture(robot, q)) == pytest.approx(least - 0.02)
    assert all(name.endswith("from floor >= 20 mm") for name in floor.names_at(Posture(robot, q)))


def corners(kind: str, size: np.ndarray) -> np.ndarray:
    """(., 3) points of a box, a cylinder or the scaled ball that hold it."""
    if kind == "box":
        return 0.5 * size * (2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1.0)
    if kind == "mesh":
        return np.array(trimesh.creation.icosphere(1, 0.3).vertices) * size
    turn = np.linspace(0.0, 2.0 * np.pi, 20001)
    rim = size[0] * np.array([np.cos(turn), np.sin(turn)])
    half = np.full(20001, size[1] / 2.0)
    return np.hstack([[*rim, half], [*rim, -half]]).T


def test_hulls_keep_from_the_floor_by_their_lowest_corner(tmp_path: Path) -> None:
    """Shapes of every kind against their own corners, without coal."""
    rng = np.random.default_rng(3)
    trimesh.creation.icosphere(1, 0.3).export(tmp_path / "ball.stl")
    robot = upright()
    sizes = {
        "box": [0.3, 0.2, 0.5],
        "cylinder": [0.1, 0.6],
        "mesh": [1.0, 0.5, 1.5],
        "sphere": [0.2],
    }
    for kind, size in sizes.items():
        place = transform(from_zyx_angles(rng.normal(size=(1, 3)))[0], (0.3, 0.1, 0.0))
        shape = Shape(kind, np.array(size), place, 3, kind, tmp_path / "ball.stl")
        shaped = replace(robot, collisions=(shape,))
        rules = CollisionRules(itself=False, floor=0.1)
        tool = Tool("none", np.zeros(3), np.zeros((1, 3)), ("M",))
        (floor,) = clearances(shaped, tool, np.array([robot.lower, robot.upper]), (), rules)
        q = rng.uniform(robot.lower, robot.upper, (50, 3))
        posture = Posture(shaped, q)
        if kind == "sphere":
            lowest = posture.point(place[:3, 3], 3)[2] - 0.2
        else:
            points = corners(kind, np.array(size))
            placed = points @ place[:3, :3].T + place[:3, 3]
            frame = posture.bodies[3]
            lowest = ((placed @ frame[:3, 2]) + frame[3, 2]).min(axis=0)
        assert floor.room(posture) == pytest.approx(lowest - 0.12, abs=1e-6), kind
        step = 1e-6
        gradient = floor.gradient(shaped, q)
        for j in range(3):
            ahead, behind = q.copy(), q.copy()
            ahead[:, j] += step
            behind[:, j] -= step
            slope = (floor.margin(shaped, ahead) - floor.margin(shaped, behind)) / (2.0 * step)
            assert np.median(np.abs(gradient[:, j] - slope)) < 1e-6


def test_a_forearm_folded_onto_its_upper_arm_is_refused() -> None:
    robot = upright()
    _, itself = default_clearances(robot, TOOL)
    fold = np.radians([[0.0, -60.0, angle] for angle in (0.0, 90.0, 140.0, 155.0, 177.0)])
    folded = itself.room(Posture(robot, fold)) < 0.0
    assert folded.tolist() == [False, False, False, True, True]
    assert "clearance of elbow from shoulder" in itself.names_at(Posture(robot, fold[-1:]))[0]


CALIBRATED = (
    ("base", 0.1807, 0.0, 90.0, 0.0),
    ("shoulder", 412.3672, -0.6127, 0.013, 0.21),
    ("elbow", -412.3669, -0.5715, -0.012, -0.22),
    ("wrist 1", 0.1741, 0.0, 90.0, 0.0),
    ("wrist 2", 0.1198, 0.0, -90.0, 0.0),
    ("wrist 3", 0.1165, 0.0, 0.0, 0.0),
)


def cobot(shift: float = 1.0) -> Robot:
    """A cobot as its factory measured it: axes 2 and 3 nearly parallel, their normal far away."""
    rows = [
        DHRow(
            n,
            np.radians(t),
            d * (shift if abs(d) > 1.0 else 1.0),
            a,
            np.radians(alpha),
            False,
            1.0,
            -np.pi,
            np.pi,
        )
        for n, d, a, alpha, t in CALIBRATED
    ]
    return from_dh("cobot", rows, modified=False)


def test_a_calibrated_table_is_as_large_as_its_arm() -> None:
    robot, nominal = cobot(), cobot(0.0)
    assert reach_of(robot) == pytest.approx(reach_of(nominal), rel=0.1)
    assert np.linalg.norm(robot.links[:, :3, 3], axis=1).sum() < 2.0
    np.testing.assert_array_equal(nominal.shifts, 0.0)
    floor, itself = default_clearances(robot, TOOL)
    assert all(solid.reach < 1.0 for solid in itself.pairs.solids)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (500, 6))
    share = float((itself.margin(robot, q) > 0.0).mean())
    assert 0.4 < share < 0.95
    always, of = itself.hardly
    assert 2 * always < of
    arm = np.radians([[0.0, -60.0, 80.0, 0.0, 90.0, 0.0]])
    assert floor.margin(robot, arm) > 0.0


def test_moved_frames_are_the_same_arm() -> None:
    robot, q = cobot(), np.random.default_rng(1).uniform(-np.pi, np.pi, (20, 6))
    assert np.abs(robot.shifts).max() > 400.0
    oracle = Oracle(robot)
    posture = Posture(robot, q)
    assert forward_kinematics(robot, q) == pytest.approx(
        np.array([oracle.forward(one) for one in q]), abs=1e-9
    )
    away = np.linalg.norm(posture.origins, axis=0).max()
    assert away < 2.0, "no axis has its origin hundreds of metres away"


@pytest.mark.parametrize("gone", [("coal",), ("coal", "trimesh")])
def test_no_package_is_needed(gone: tuple[str, ...], tmp_path: Path, monkeypatch) -> None:
    for name in gone:
        monkeypatch.setitem(sys.modules, name, None)
    trimesh.creation.box((0.3, 0.2, 0.8)).export(tmp_path / "link.stl")
    shapes = (
        Shape("mesh", np.ones(3), transform(None, (0.4, 0, 0)), 2, "upper", tmp_path / "link.stl"),
        Shape("mesh", np.ones(3), np.eye(4), 3, "fore", None, "package://arm/fore.stl"),
        Shape("cylinder", np.array([0.1, 0.5]), transform(None, (0, 0, 0.25)), 1, "post"),
    )
    robot = replace(upright(), collisions=shapes)
    found = default_clearances(robot, TOOL)
    assert [c.what for c in found] == ["floor", "itself"]
    told = {doubt.code: doubt.about for doubt in watch_of(found).made_do}
    lost = ("fore",) if len(gone) == 1 else ("upper", "fore")
    assert told == {"shapes-as-capsules": (), "chain-as-capsules": lost}
    watched = {solid.name for solid in found[0].pairs.solids}
    assert watched == {
        "post",
        "tool",
        "floor",
        *({"upper"} if len(gone) == 1 else {"shoulder"}),
        "elbow",
    }
    with pytest.raises(InputError):
        clearances(robot, TOOL, np.array([robot.lower, robot.upper]), (), CollisionRules())


def test_a_link_without_a_shape_is_watched_along_the_chain() -> None:
    shapes = tuple(
        Shape("cylinder", np.array([0.1, 0.5]), transform(None, (0, 0, 0.25)), body, name)
        for body, name in ((1, "post"), (3, "fore"))
    )
    found = default_clearances(replace(upright(), collisions=shapes), TOOL)
    told = {doubt.code: doubt.about for doubt in watch_of(found).made_do}
    assert told["chain-as-capsules"] == ("shoulder",)
    assert {"post", "fore", "shoulder"} < {solid.name for solid in found[1].pairs.solids}


@pytest.mark.parametrize(
    ("body", "size", "said"),
    [
        (3, (100.0, 400.0), "link 'fore' has a shape 400 m large, and the robot reaches "),
        (3, (20.0, 80.0), "link 'fore' has a shape 80 m large, and the robot reaches "),
        (0, (150.0, 300.0), "link 'fore' has a shape 300 m large, and the robot reaches "),
    ],
)
def test_shapes_in_millimetres_are_said_and_refused_where_asked_for(
    body: int, size: tuple[float, float], said: str
) -> None:
    robot = replace(
        upright(), collisions=(Shape("cylinder", np.array(size), np.eye(4), body, "fore"),)
    )
    found = default_clearances(robot, TOOL)
    (doubt,) = (d for d in watch_of(found).doubts if d.code == "odd-size")
    assert worded(doubt).startswith(said)
    assert "robot files are in metres; are they millimetres" in worded(doubt)
    assert "fore" not in {solid.name for one in found for solid in one.pairs.solids}
    with pytest.raises(InputError, match=re.escape(said)):
        clearances(robot, TOOL, np.array([robot.lower, robot.upper]), (), CollisionRules())


def test_a_turntable_may_have_a_shape() -> None:
    """Its flange stays where it is: that is no reach to compare a shape with."""
    table = Robot("table", (Joint("C", transform(None, (0, 0, 0.5)), Z, False, -3.0, 3.0),))
    assert reach_of(table) == pytest.approx(0.0)
    plate = Shape("cylinder", np.array([1.5, 0.1]), transform(None, (0, 0, 0.1)), 1, "plate")
    found = default_clearances(replace(table, collisions=(plate,)), TOOL)
    assert not any(d.code == "odd-size" for d in watch_of(found).doubts)


def test_a_wide_floor_and_a_long_rail_may_belong_to_a_base() -> None:
    shapes = (
        Shape("box", np.array([100.0, 100.0, 0.01]), transform(None, (0, 0, -2.0)), 0, "hall"),
        Shape("box", np.array([60.0, 0.1, 0.1]), transform(None, (0, 3, 0)), 0, "rail"),
    )
    found = default_clearances(replace(upright(), collisions=shapes), TOOL)
    assert not any(d.code == "odd-size" for d in watch_of(found).doubts)
    assert {"hall", "rail"} <= {solid.name for one in found for solid in one.pairs.solids}


@pytest.mark.parametrize(
    ("side", "said"),
    [
        (200.0, "has a shape 346 m large"),
        (0.0002, "has a shape of 0.3464 mm"),
    ],
)
def test_meshes_of_odd_sizes_are_said_with_the_reach(
    side: float, said: str, tmp_path: Path
) -> None:
    trimesh.creation.box((side, side, side)).export(tmp_path / "m.stl")
    shape = Shape("mesh", np.ones(3), np.eye(4), 3, "fore", tmp_path / "m.stl")
    found = default_clearances(replace(upright(), collisions=(shape,)), TOOL)
    (doubt,) = (d for d in watch_of(found).doubts if d.code == "odd-size")
    assert said in worded(doubt)


def test_most_pairs_that_always_touch_are_a_warning() -> None:
    fat = CollisionRules(link_radius=1.3)
    robot = kuka_kr270()
    found = clearances(
        robot, robot.tools["calibration"], np.array([robot.lower, robot.upper]), (), fat
    )
    assert [doubt.code for doubt in watch_of(found).doubts] == ["hardly-watched"]
    thin = study(QUIET)
    assert not watch_of(thin.constraints).doubts
    made = study(QUIET + "  collision: {link_radius_mm: 1300}\n")
    assert "hardly-watched" in {doubt.code for doubt in ec.check(made).doubts}


def test_home_is_free_if_nobody_says_where_it_is() -> None:
    robot = cobot(0.0)
    base = study(QUIET)
    cell = default_clearances(robot, TOOL)
    plain = replace(base, limits=base.limits)
    np.testing.assert_array_equal(plain.pace.home, 0.0)
    arm = ec.ElasticArm(robot, ec.joint_springs(robot, ["shoulder", "elbow"]), TOOL)
    case = ec.LoadCases([[0.1, -1.0, 1.0, 0.2, 1.0, 0.0]], [[0.0, 0.0, -100.0, 0.0, 0.0, 0.0]])
    parts = {
        "robot": robot,
        "springs": arm.springs,
        "test_poses": (ec.test_pose(arm, case, 1.0, "task"),),
        "experiments": ec.Experiments(TOOL, ec.FixedVector([0.0, 0.0, -100.0]), 4),
        "instrument": ec.Isotropic(3e-5),
    }
    np.testing.assert_array_equal(ec.Study(**parts).pace.home, 0.0)
    watched = ec.Study(**parts, constraints=cell)
    turned = np.degrees(watched.pace.home)
    assert turned == pytest.approx(30.0 * np.round(turned / 30.0))
    assert turned.any()
    assert min(float(c.margin(robot, watched.pace.home[None])[0]) for c in cell) >= 0.0


def test_a_task_below_the_floor_is_said() -> None:
    assert "pose-below-floor" not in {doubt.code for doubt in ec.check(study(QUIET)).doubts}
    made = study(QUIET + "  floor: {z_mm: 5000}\n  collision: off\n")
    (pose,) = made.test_poses
    assert pose.cases is not None
    assert pose.tool is not None
    tcp = Posture(made.robot, pose.cases.q).point(pose.tool.tcp)
    below = [d for d in _doubts(made, 3.0) if d.code == "pose-below-floor"]
    assert [(d.about, d.numbers["by"]) for d in below] == [
        ((pose.name,), pytest.approx(5.0 - float(tcp[2, 0]), abs=1e-6))
    ]


def test_check_names_the_parts_that_refuse_most() -> None:
    """A ball over the reach of all but the last link; a height is a constraint without parts."""
    ball = "  obstacles: [{name: ball, sphere_radius_mm: 300, center_mm: [0, 0, 2800]}]\n"
    rules = "  collision: {self: false}\n  floor: off\n"
    found = check(study(STUDY + "constraints:\n" + ball + rules))
    assert (found.bottleneck, found.within, found.within_share) == (
        "clearance from ball >= 20 mm",
        "clearance of J3 from ball >= 20 mm",
        1.0,
    )
    off = "  collision: off\n  floor: off\n"
    found = check(study(STUDY + "constraints:\n  workspace: {min_z_mm: 800}\n" + off))
    assert (found.within, found.within_share) == ("", 0.0)
    assert 0.0 < found.feasible_share < 1.0
