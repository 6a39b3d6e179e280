"""Motions: nothing between samples is missed, ways around are free, what is blocked is named."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from elastocal.constraints import HalfSpace
from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.errors import InfeasibleError, InputError
from elastocal.measuring.instrument import Isotropic
from elastocal.motion.margins import (
    TOLERANCE,
    motion_margins,
    motion_violations,
    relative_speed,
)
from elastocal.motion.pace import Pace, for_robot
from elastocal.motion.via_points import (
    UnreachableError,
    _connected,
    detours,
    refuse_home,
    way_around,
)
from elastocal.planning.assessment import broken_on_the_way
from elastocal.programs.approach import Approach
from elastocal.programs.campaign_program import campaign_program
from elastocal.programs.robot_program import Move
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import kuka_kr270
from elastocal.study.study import Experiments, Study, test_pose
from tests.arms import random_chain
from tests.constraints.collision.oracle import CellOracle

KUKA = kuka_kr270()
BOXES = {
    "table": (np.array([1.2, 1.6, 0.7]), transform(None, (1.7, 0.0, 0.35))),
    "wall": (np.array([5.0, 0.1, 3.0]), transform(None, (0.0, 1.5, 1.5))),
}
HOME = np.radians([0.0, -120.0, 120.0, 0.0, 0.0, 0.0])


def study_of(robot: Robot, tool: Tool, shapes: list[Shape], home: np.ndarray, **rules) -> Study:
    limits = np.array([robot.lower, robot.upper])
    springs = joint_springs(robot)
    wrench = np.array([[300.0, 200.0, -1000.0, 0.0, 0.0, 0.0]])
    pose = test_pose(ElasticArm(robot, springs, tool), LoadCases(home[None], wrench), 1.0, "task")
    found = clearances(robot, tool, limits, shapes, CollisionRules(**rules))
    return Study(
        robot,
        springs,
        (pose,),
        Experiments(tool, FixedVector(wrench[0, :3]), 4),
        Isotropic(3e-5),
        constraints=found,
        pace=for_robot(Pace(home=home), robot, limits),
    )


def kuka_study(**rules) -> Study:
    shapes = [Shape("box", size, pose, 0, name) for name, (size, pose) in BOXES.items()]
    return study_of(KUKA, KUKA.tools["calibration"], shapes, HOME, **rules)


def free_configurations(study: Study, count: int, seed: int) -> np.ndarray:
    q = np.random.default_rng(seed).uniform(*study.limits, (20 * count, len(study.robot.joints)))
    posture = Posture(study.robot, q)
    room = np.min([c.room(posture) for c in study.motion_space.clearances], axis=0)
    return q[room > 0.0][:count]


def test_margins_are_those_of_dense_samples_by_pinocchio_and_coal() -> None:
    study = kuka_study()
    oracle = CellOracle(KUKA, KUKA.tools["calibration"], BOXES, 0.02)
    left = {
        frozenset((x.first, x.second)) for c in study.motion_space.clearances for x in c.unwatched
    }
    left |= {frozenset(p) for p in (("A4", "A6"), ("A5", "A6"), ("A6", "tool"))}
    q = free_configurations(study, 24, 3)
    found = motion_margins(study.motion_space, q[:12], q[12:], enough=0.3)
    assert 0 < found.free.sum() < 12, "the comparison sees motions of one kind only"
    for i in range(12):
        way = q[i] + np.linspace(0.0, 1.0, 400)[:, None] * (q[12 + i] - q[i])
        dense = min(min(oracle.obstacle(one, name) for name in BOXES) for one in way)
        dense = min(dense, *(oracle.itself(one, left) for one in way)) - 0.01
        if found.margin[i] < 0.3:
            assert found.margin[i] <= dense + 1e-6, "a sample is nearer than the least margin"
            spacing = float(np.abs(q[12 + i] - q[i]).sum()) * 4.0 / 400
            assert found.margin[i] >= dense - TOLERANCE - spacing
        else:
            assert dense > 0.29


def test_a_wire_between_two_samples_is_not_missed() -> None:
    wire = Shape("capsule", np.array([5e-4, 3.0]), transform(None, (2.2, 0.0, 1.5)), 0, "wire")
    study = study_of(KUKA, KUKA.tools["calibration"], [wire], HOME, itself=False, margin=0.001)
    q = np.radians([[-60.0, -90.0, 90.0, 0.0, 0.0, 0.0], [60.0, -30.0, 30.0, 0.0, 0.0, 0.0]])
    start, goal = q[1].copy(), q[1].copy()
    start[0] = -start[0]
    found = motion_margins(study.motion_space, start[None], goal[None])
    assert not found.free[0]
    assert found.pairs[0][0] == "wire"
    assert found.distance[0] < 0.0


def test_nothing_moves_faster_than_the_bound() -> None:
    for seed, slides in ((0, [False] * 6), (1, [True, False, False, True, False, False])):
        rng = np.random.default_rng(seed)
        robot = random_chain(rng, slides)
        robot = replace(
            robot, joints=tuple(replace(j, lower=-2.0, upper=2.0) for j in robot.joints)
        )
        tool = Tool("t", rng.normal(size=3), rng.normal(size=(2, 3)), ("A", "B"))
        shapes = [Shape("box", np.ones(3), transform(None, (3.0, 0, 0)), 0, "box")]
        limits = np.array([robot.lower, robot.upper])
        for clearance in clearances(robot, tool, limits, shapes, CollisionRules()):
            starts, goals = rng.uniform(-2.0, 2.0, (2, 30, 6))
            speed = relative_speed(robot, clearance.pairs, starts, goals)
            for pair in range(len(clearance.pairs)):
                only = replace(clearance.pairs, index=(clearance.pairs.index[pair],))
                one = type(clearance)("x", only, 0.0)
                share = rng.uniform(0.0, 1.0, (2, 30))
                a, b = (starts + s[:, None] * (goals - starts) for s in share)
                moved = one.room(Posture(robot, a)) - one.room(Posture(robot, b))
                bound = speed[pair] * np.abs(share[0] - share[1])
                assert (np.abs(moved) <= bound + 1e-9).all()


def test_a_decision_is_the_sign_of_the_margin() -> None:
    study = kuka_study()
    q = free_configurations(study, 60, 3)
    whole = motion_margins(study.motion_space, q[:30], q[30:], enough=0.0)
    quick = motion_margins(study.motion_space, q[:30], q[30:], enough=0.0, decide=True)
    assert np.array_equal(whole.free, quick.free)
    assert 0 < whole.free.sum() < 30


def test_ways_around_are_free_by_the_oracle() -> None:
    study = kuka_study()
    oracle = CellOracle(KUKA, KUKA.tools["calibration"], BOXES, 0.02)
    q = free_configurations(study, 40, 5)
    blocked = np.flatnonzero(~motion_margins(study.motion_space, q[:20], q[20:]).free)[:3]
    assert len(blocked) == 3
    for i in blocked:
        via = way_around(study.motion_space, q[i], q[20 + i], np.random.default_rng(0))
        assert via is not None
        stops = np.vstack([q[i], via, q[20 + i]])
        for a, b in pairwise(stops):
            for one in a + np.linspace(0.0, 1.0, 120)[:, None] * (b - a):
                assert min(oracle.obstacle(one, name) for name in BOXES) > 0.0099


# A ball on two slides in the plane: ways around walls can be seen on paper.


def slider(walls: list[tuple[str, tuple[float, float], tuple[float, float]]]) -> Study:
    """Walls are (name, centre, sides)."""
    x, y = (Joint(n, np.eye(4), np.eye(3)[i], True, -1.0, 1.0) for i, n in enumerate("XY"))
    ball = Shape("sphere", np.array([0.1]), np.eye(4), 2, "ball")
    tool = Tool("none", np.zeros(3), np.zeros((1, 3)), ("M",))
    shapes = [
        Shape("box", np.array([*sides, 1.0]), transform(None, (*centre, 0.0)), 0, name)
        for name, centre, sides in walls
    ]
    robot = Robot("slider", (x, y), collisions=(ball,))
    return study_of(robot, tool, shapes, np.array([-0.8, -0.8]), itself=False)


GOAL = np.array([[0.8, 0.0]])


def test_a_free_plan_needs_no_via_points() -> None:
    study = slider([("post", (0.0, 0.8), (0.1, 0.1))])
    assert detours(study.motion_space, GOAL) == ()
    assert motion_violations(study.motion_space, GOAL) == ()


def test_a_wall_with_a_way_round_it() -> None:
    study = slider([("wall", (0.0, -0.2), (0.1, 1.5))])
    doubt = motion_violations(study.motion_space, GOAL)[0]
    assert (doubt.code, doubt.because) == ("motion-blocked", ("wall", "ball"))
    assert doubt.numbers["distance"] < 0.0
    via = detours(study.motion_space, GOAL)
    assert [len(points) for points in via] == [len(via[0]), len(via[1])]
    assert len(via[0]) >= 1
    assert motion_violations(study.motion_space, GOAL, via) == ()


def test_a_maze_needs_more_than_one_via_point() -> None:
    walls = [
        ("first", (-0.5, -0.3), (0.1, 1.4)),
        ("second", (0.0, 0.3), (0.1, 1.4)),
        ("third", (0.5, -0.3), (0.1, 1.4)),
    ]
    study = slider(walls)
    via = detours(study.motion_space, GOAL)
    assert len(via[0]) >= 3
    assert motion_violations(study.motion_space, GOAL, via) == ()


def test_what_blocks_all_ways_is_named() -> None:
    study = slider([("curtain", (0.0, 0.0), (0.1, 3.0))])
    with pytest.raises(InfeasibleError) as error:
        detours(study.motion_space, GOAL)
    (doubt,) = error.value.doubts
    assert (doubt.code, doubt.because) == ("no-way", ("curtain", "ball"))
    assert (doubt.numbers["leg"], doubt.numbers["share"]) == (0, 0.5)
    assert doubt.numbers["distance"] == pytest.approx(-0.15)
    assert "from home to configuration 1: the straight one hits curtain" in str(error.value)


WALL = ("wall", (0.0, -0.2), (0.1, 1.5))


def box_gap(points: np.ndarray, sides: tuple[float, float], centre: tuple[float, float]) -> float:
    """Least distance of the ball from a box along a dense row of points."""
    off = np.maximum(np.abs(points - centre) - np.array(sides) / 2.0, 0.0)
    return float(np.linalg.norm(off, axis=1).min()) - 0.1


def test_the_shortest_way_over_one_point_is_taken() -> None:
    """Of the same random points, judged here by dense samples and timed by the slowest slide."""
    study = slider([WALL])
    home, speed = study.pace.home, study.pace.speed
    draws = np.random.default_rng([0, 0]).uniform(-1.0, 1.0, (200, 2))
    times = []
    for via in draws:
        legs = [(home, via), (via, GOAL[0])]
        rows = [a + np.linspace(0.0, 1.0, 400)[:, None] * (b - a) for a, b in legs]
        free = min(box_gap(row, (0.1, 1.5), (0.0, -0.2)) for row in rows) > 0.01
        took = sum(float((np.abs(b - a) / speed).max()) for a, b in legs)
        times.append(took if free else np.inf)
    via = detours(study.motion_space, GOAL)[0]
    np.testing.assert_allclose(via, draws[[int(np.argmin(times))]])


def test_ways_around_hold_what_holds_everywhere() -> None:
    """Via points are no lower than the study allows, whether one is enough or trees are grown."""
    low = HalfSpace("height", np.zeros(3), np.array([0.0, -1.0, 0.0]), -0.8)
    free = slider([WALL])
    bounded = replace(free, constraints=(*free.constraints, low))
    assert bounded.motion_space.holding == (low,)
    heights: list[list[float]] = [[], []]
    for seed in range(5):
        for study, found in zip((free, bounded), heights, strict=True):
            found += [
                h for part in detours(study.motion_space, GOAL, seed=seed) for h in part[:, 1]
            ]
            trees = _connected(
                study.motion_space, study.pace.home, GOAL[0], np.random.default_rng(seed)
            )
            found += [] if trees is None else [q[1] for q in trees]
    assert max(heights[0]) > 0.85
    assert max(heights[1]) <= 0.8
    assert len(heights[1]) > 20


def known_ways(
    monkeypatch: pytest.MonkeyPatch, ways: dict[tuple[str, str], list[list[float]]]
) -> None:
    """The search finds these ways and no others; places are H, and configurations by their x."""
    places = {"H": -0.8, "A": 0.85, "B": 0.5}

    def found(space: object, start: np.ndarray, goal: np.ndarray, rng: object) -> object:
        for (a, b), way in ways.items():
            if np.isclose([start[0], goal[0]], [places[a], places[b]], atol=0.06).all():
                return np.array(way)
        return None

    monkeypatch.setattr("elastocal.motion.via_points.way_around", found)


def test_home_the_way_it_came(monkeypatch: pytest.MonkeyPatch) -> None:
    forth = [[-0.5, 0.7], [0.5, 0.75]]
    known_ways(monkeypatch, {("H", "A"): forth})
    study = slider([WALL])
    via = detours(study.motion_space, GOAL)
    np.testing.assert_array_equal(via[0], forth)
    np.testing.assert_array_equal(via[1], forth[::-1])
    assert motion_violations(study.motion_space, GOAL, via) == ()


def test_over_home_where_no_other_way_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """From A to B the way leads back home; home from B as from home to B, not by A again."""
    q = np.array([[0.85, 0.0], [0.5, 0.0]])
    to_a, to_b = [[-0.5, 0.8], [0.85, 0.8]], [[-0.5, 0.75], [0.5, 0.75]]
    known_ways(monkeypatch, {("H", "A"): to_a, ("H", "B"): to_b})
    study = slider([WALL, ("post", (0.675, -0.2), (0.02, 1.5))])
    via = detours(study.motion_space, q)
    home = study.pace.home.tolist()
    assert [points.tolist() for points in via] == [to_a, [*to_a[::-1], home, *to_b], to_b[::-1]]
    assert motion_violations(study.motion_space, q, via) == ()


def test_ways_that_are_not_free_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever the search says: the motions are judged again."""
    known_ways(monkeypatch, {("H", "A"): [[0.0, -0.9]], ("A", "H"): [[0.0, 0.8]]})
    with pytest.raises(InfeasibleError, match="home to configuration 1, part 1 of 2, hits wall"):
        detours(slider([WALL]).motion_space, GOAL)
    known_ways(monkeypatch, {("H", "A"): [[0.0, 0.8]], ("A", "H"): [[0.0, 0.8]]})
    q = np.array([[0.8, 0.0], [-0.3, 0.3]])
    with pytest.raises(UnreachableError, match="from configuration 1 to configuration 2") as error:
        detours(slider([WALL]).motion_space, q)
    np.testing.assert_array_equal(error.value.q, q[1])


def test_a_home_in_collision_is_refused() -> None:
    study = slider([("pile", (-0.8, -0.8), (0.3, 0.3))])
    with pytest.raises(InfeasibleError) as error:
        refuse_home(study.motion_space)
    (doubt,) = error.value.doubts
    assert (doubt.code, doubt.because) == ("home-blocked", ("pile", "ball"))
    assert doubt.about == ("home_mm",)
    assert doubt.numbers["distance"] == pytest.approx(-0.25)
    refuse_home(slider([]).motion_space)


def test_near_passes_say_what_is_to_be_kept() -> None:
    study = slider([("wall", (0.0, -0.505), (0.1, 0.2))])
    study = replace(study, pace=replace(study.pace, home=np.array([-0.8, -0.3])))
    doubt = motion_violations(study.motion_space, np.array([[0.8, -0.3]]))[0]
    assert doubt.because == ("wall", "ball")
    assert (doubt.numbers["leg"], doubt.numbers["share"]) == (0, 0.5)
    assert doubt.numbers["distance"] == pytest.approx(0.005)
    assert doubt.numbers["keep"] == pytest.approx(0.01)


def test_programs_pass_the_via_points_and_refuse_to_leave_them_out() -> None:
    study = slider([("wall", (0.0, -0.2), (0.1, 1.5))])
    cases = LoadCases(GOAL, np.array([[300.0, 200.0, -1000.0, 0.0, 0.0, 0.0]]))
    repeats = np.array([2])
    via = detours(study.motion_space, GOAL)
    program = campaign_program(study, cases, repeats, home=study.pace.home, via=via)
    names = [program.target_names[s.target] for s in program.steps if isinstance(s, Move)]
    there = [f"V{i + 1}" for i in range(len(via[0]))]
    back = [f"V{len(via[0]) + i + 1}" for i in range(len(via[1]))]
    assert names == ["H0", *there, "AP1", "P1", "AP1", "P1", *back, "H0"]
    with pytest.raises(InfeasibleError) as error:
        campaign_program(study, cases, repeats, home=study.pace.home)
    (doubt,) = error.value.doubts
    assert (doubt.about, doubt.because) == (("H0", "AP1"), ("wall", "ball"))
    campaign_program(study, cases, repeats)  # it starts where the robot stands


def test_via_points_keep_what_motions_keep() -> None:
    """15 mm from a wall one may pass, with 20 mm to be kept by configurations; 5 mm is too near."""
    study = slider([("wall", (0.0, -0.2), (0.1, 1.5))])
    none = np.zeros((0, 2))
    for gap, kept in ((0.015, True), (0.005, False)):
        via = np.array([[-0.15 - gap, -0.8], [-0.15 - gap, 0.5]])
        must, rest = broken_on_the_way(study, [via, none])
        assert [len(must), len(rest)] == [0 if kept else 2, 0]
        assert all(doubt.because == ("clearance of ball from wall >= 10 mm",) for doubt in must)
        assert all(doubt.numbers["by"] == pytest.approx(0.005) for doubt in must)
    near = replace(study.pace, home=np.array([-0.165, -0.8]))
    cases = LoadCases(GOAL, np.array([[300.0, 200.0, -1000.0, 0.0, 0.0, 0.0]]))
    via = detours(replace(study, pace=near).motion_space, GOAL)
    program = campaign_program(study, cases, np.array([1]), home=near.home, via=via)
    assert not any("Home breaks" in note for note in program.notes)


def test_where_both_sides_are_narrow_the_approach_keeps_what_motions_keep() -> None:
    """A corridor with 0.5 mm more than configurations must keep, and an approach of 1 mm."""
    sides, x = (0.1, 1.0), 0.15 + 0.0205
    study = slider([("left", (-x, 0.0), sides), ("right", (x, 0.0), sides)])
    wide = slider([("left", (-x, 0.0), sides), ("right", (x + 0.001, 0.0), sides)])
    cases = LoadCases(np.zeros((1, 2)), np.array([[300.0, 200.0, -1000.0, 0.0, 0.0, 0.0]]))
    for one, expected in ((study, [-1e-3, -1e-3]), (wide, [1e-3, -1e-3])):
        home = one.pace.home
        via = detours(one.motion_space, cases.q)
        program = campaign_program(one, cases, np.array([1]), home=home, via=via)
        np.testing.assert_allclose(program.targets[1], expected, atol=1e-12)
    with pytest.raises(InputError, match=r"within clearance of ball from left >= 10 mm"):
        campaign_program(study, cases, np.array([1]), approach=Approach(length=0.012))
