"""Joint ranges beyond a closed value: what is closed is known on paper, and what only looks so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.motion.pace import Pace, for_robot
from elastocal.motion.space import MotionSpace
from elastocal.motion.within_reach import out_of_reach, reachable_limits
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.shapes import Shape

NO_TOOL = Tool("none", np.zeros(3), np.zeros((1, 3)), ("M",), radius=1e-3)
TIP = np.array([1.0, 0.0, 0.0])


def space_of(
    robot: Robot, shapes: list[Shape], home: np.ndarray, tool: Tool = NO_TOOL
) -> MotionSpace:
    """Kept from the shapes while moving: 10 mm."""
    limits = np.array([robot.lower, robot.upper])
    found = clearances(robot, tool, limits, shapes, CollisionRules(itself=False))
    return MotionSpace(robot, limits, for_robot(Pace(home=home), robot, limits), found)


def swing(
    home: float, posts: list[float], *, lower: float = -6.0, upper: float = 6.0
) -> MotionSpace:
    """An arm of 1 m, 100 mm thick on every side, among balls of 100 mm at some angles [rad]."""
    turn = Joint("J1", np.eye(4), np.array([0.0, 0.0, 1.0]), False, lower, upper)
    hub = Shape("sphere", np.array([0.01]), np.eye(4), 1, "hub")
    arm = Tool("arm", TIP, TIP[None], ("M",), radius=0.1)
    around = [
        Shape("sphere", np.array([0.1]), transform(None, (np.cos(a), np.sin(a), 0.0)), 0, f"P{i}")
        for i, a in enumerate(posts)
    ]
    return space_of(Robot("swing", (turn,), collisions=(hub,)), around, np.array([home]), arm)


HALF = 2.0 * np.arcsin(0.21 / 2.0)  # a post closes so much to both sides of its angle [rad]


@pytest.mark.parametrize("home", [0.0, 0.9, -2.0])
def test_a_post_closes_the_way_round_it_both_ways(home: float) -> None:
    """It stands at 1.5 rad, and a turn before that."""
    lower, upper = reachable_limits(swing(home, [1.5]))[:, 0]
    assert abs(lower - (1.5 - 2.0 * np.pi)) < HALF
    assert abs(upper - 1.5) < HALF


def test_only_the_nearest_post_on_each_side_matters() -> None:
    lower, upper = reachable_limits(swing(0.0, [1.0, 2.0, -1.2]))[:, 0]
    assert abs(lower + 1.2) < HALF
    assert abs(upper - 1.0) < HALF


def test_what_has_nothing_free_beyond_is_no_news() -> None:
    """The post stands at the end of the range: limits stay as they are, and nothing is said."""
    space = swing(0.0, [1.5], lower=-1.0, upper=1.55)
    np.testing.assert_array_equal(reachable_limits(space), space.limits)
    assert out_of_reach(space) == ()


def slider(*walls: tuple[tuple[float, float], tuple[float, float]]) -> MotionSpace:
    """A ball of 100 mm on two slides of 2 m; walls are (centre, sides)."""
    x, y = (Joint(n, np.eye(4), np.eye(3)[i], True, -1.0, 1.0) for i, n in enumerate("XY"))
    ball = Shape("sphere", np.array([0.1]), np.eye(4), 2, "ball")
    shapes = [
        Shape("box", np.array([*sides, 1.0]), transform(None, (*centre, 0.0)), 0, f"W{i}")
        for i, (centre, sides) in enumerate(walls)
    ]
    return space_of(Robot("slider", (x, y), collisions=(ball,)), shapes, np.array([-0.8, -0.8]))


def test_a_curtain_closes_one_slide_and_not_the_other() -> None:
    space = slider(((0.0, 0.0), (0.1, 3.0)))
    limits = reachable_limits(space)
    assert abs(limits[1, 0]) < 0.16  # half the curtain, the ball and the margin
    limits[1, 0] = 1.0
    np.testing.assert_array_equal(limits, space.limits)
    (doubt,) = out_of_reach(space)
    assert (doubt.code, doubt.about, doubt.unit) == ("out-of-reach", ("X",), "m")
    assert doubt.numbers["lower"] == -1.0


@pytest.mark.parametrize(
    "walls",
    [
        [((0.0, -0.2), (0.1, 1.5))],  # a way round it
        [((0.0, -0.62), (0.1, 1.0)), ((0.0, 0.62), (0.1, 1.0))],  # a gap of 20 mm for the ball
        [((-0.3, -0.3), (0.1, 1.4)), ((0.3, 0.3), (0.1, 1.4))],  # a maze
    ],
)
def test_a_way_however_narrow_leaves_the_limits_as_they_are(walls: list) -> None:
    space = slider(*walls)
    np.testing.assert_array_equal(reachable_limits(space), space.limits)


def test_nothing_is_closed_where_nothing_is_watched() -> None:
    space = replace(slider(((0.0, 0.0), (0.1, 3.0))), clearances=())
    np.testing.assert_array_equal(reachable_limits(space), space.limits)


def test_a_room_that_no_joint_value_closes_is_left_in() -> None:
    """Four walls around a room: every value of X and of Y is free somewhere else."""
    walls = [
        ((0.3 + dx, 0.3 + dy), (0.1 + 0.6 * (dx == 0), 0.1 + 0.6 * (dy == 0)))
        for dx, dy in ((0.3, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.0, -0.3))
    ]
    space = slider(*walls)
    np.testing.assert_array_equal(reachable_limits(space), space.limits)
