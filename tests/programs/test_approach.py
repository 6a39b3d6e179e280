"""Approach points: the same side for every axis, inside limits and constraints."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.constraints import Distinct, HalfSpace
from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.errors import InputError
from elastocal.programs.approach import approaches
from elastocal.robot.chain import Tool, transform
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.shapes import Shape
from tests.programs.writers.campaigns import arm


def limits_of(n: int, size: float = 1.0) -> np.ndarray:
    return np.array([-size * np.ones(n), size * np.ones(n)])


def test_every_axis_comes_from_below() -> None:
    q = np.array([[0.1, 0.2, 0.3], [-0.5, 0.0, 0.9]])
    amount = np.array([0.01, 0.02, 0.001])
    points, same = approaches(arm("RRP"), q, amount, limits_of(3))
    np.testing.assert_allclose(points, q - amount)
    assert same


def test_an_axis_at_its_lower_limit_comes_from_above_everywhere() -> None:
    q = np.array([[0.1, -1.0, 0.3], [-0.5, 0.0, 0.9]])
    points, same = approaches(arm("RRR"), q, np.full(3, 0.01), limits_of(3))
    np.testing.assert_allclose(points - q, [[-0.01, 0.01, -0.01]] * 2)
    assert same


def test_an_axis_at_both_limits_has_its_side_by_pose() -> None:
    q = np.array([[0.1, -1.0, 0.3], [-0.5, 1.0, 0.9]])
    points, same = approaches(arm("RRR"), q, np.full(3, 0.01), limits_of(3))
    np.testing.assert_allclose(points - q, [[-0.01, 0.01, -0.01], [-0.01, -0.01, -0.01]])
    assert not same


def test_no_approach_is_the_pose_itself() -> None:
    q = np.array([[0.1, -1.0, 1.0]])
    points, same = approaches(arm("RRR"), q, np.zeros(3), limits_of(3))
    np.testing.assert_array_equal(points, q)
    assert same


def test_no_room_names_the_joint() -> None:
    limits = limits_of(3)
    limits[:, 1] = [-0.004, 0.004]
    with pytest.raises(InputError, match=r"configuration 1 .*'J2' has only 0.22.* 0.573"):
        approaches(arm("RRR"), np.zeros((1, 3)), np.full(3, 0.01), limits)


def lowest(height: float) -> HalfSpace:
    """The flange must not be below `height`."""
    return HalfSpace("height of the flange", np.zeros(3), np.array([0.0, 0, 1]), height)


def test_constraints_hold_at_the_approach_point() -> None:
    robot, q = arm("RRR"), np.array([[0.1, 0.4, 0.3]])
    amount, limits = np.full(3, 0.01), limits_of(3)
    height = forward_kinematics(robot, q)[0, 2, 3]
    rise, _ = approaches(robot, q, amount, limits)
    sign = np.sign(forward_kinematics(robot, rise)[0, 2, 3] - height)
    # The bound that the unhindered approach breaks: from below, or from above.
    tight = HalfSpace("touching", np.zeros(3), np.array([0.0, 0, -sign]), -sign * height)
    assert tight.margin(robot, rise)[0] < -1e-3
    points, same = approaches(robot, q, amount, limits, [tight])
    assert tight.margin(robot, points)[0] >= -1e-5
    np.testing.assert_allclose(np.abs(points - q), 0.01 * np.ones((1, 3)))
    assert same


def test_a_constraint_in_the_way_is_named() -> None:
    robot, q = arm("R"), np.array([[0.0]])
    with pytest.raises(InputError, match=r"within height of the flange; .* 0 for none$"):
        approaches(robot, q, np.array([0.01]), limits_of(1), [lowest(10.0)])


def test_two_parts_in_the_way_are_named() -> None:
    """The flange in a ball: a joint margin would not help, so it is not advised."""
    robot, q = arm("RR"), np.array([[0.0, 0.0]])
    at = forward_kinematics(robot, q)[0, :3, 3]
    ball = Shape("sphere", [0.5], transform(None, at), 0, "ball")
    tool = Tool("rod", np.array([0.0, 0.0, 0.1]), np.array([[0.0, 0.0, 0.1]]), ("M",))
    (cell,) = clearances(robot, tool, limits_of(2), [ball], CollisionRules(itself=False))
    with pytest.raises(InputError, match=r"within clearance of \w+ from ball .* 0 for none$"):
        approaches(robot, q, np.full(2, 0.01), limits_of(2), [cell])


def test_each_pose_has_a_side_that_its_own_constraints_allow() -> None:
    """Two poses at opposite limits, so no common side, and one beside a place that is ruled out."""
    robot, q = arm("R"), np.array([[-1.0], [1.0], [0.3]])
    ruled_out = Distinct("not there", np.array([0.29]), np.ones(1), 0.005)
    points, same = approaches(robot, q, np.array([0.01]), limits_of(1), [ruled_out])
    np.testing.assert_allclose(points[:, 0], [-0.99, 0.99, 0.31])
    assert not same


def test_more_axes_than_can_be_tried_are_refused_in_a_sentence() -> None:
    """Thirteen axes at their lower limits must all come from above: more than 4096 ways."""
    limits = limits_of(13)
    with pytest.raises(InputError, match="configuration 1 cannot be approached within a joint"):
        approaches(arm("R" * 13), limits[:1], np.full(13, 0.01), limits)
    points, same = approaches(arm("R" * 12), limits[:1, :12], np.full(12, 0.01), limits[:, :12])
    np.testing.assert_allclose(points, -0.99 * np.ones((1, 12)))
    assert same


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(1, 5),
    kinds=st.text("RP", min_size=1, max_size=7),
)
def test_amounts_are_whole_and_inside(seed: int, count: int, kinds: str) -> None:
    rng = np.random.default_rng(seed)
    n = len(kinds)
    q = rng.uniform(-1.0, 1.0, (count, n))
    q = np.where(rng.uniform(size=q.shape) < 0.3, np.sign(q), q)
    amount = rng.uniform(0.0, 0.2, n)
    points, same = approaches(arm(kinds), q, amount, limits_of(n))
    np.testing.assert_allclose(np.abs(points - q), np.tile(amount, (count, 1)), atol=1e-12)
    assert (np.abs(points) <= 1.0 + 1e-9).all()
    assert not same or len(np.unique(np.sign(points - q), axis=0)) == 1


def test_an_axis_that_does_not_move_is_not_approached() -> None:
    q = np.array([[0.1, 0.2, 0.3]])
    points, same = approaches(arm("RRP"), q, np.zeros(3), limits_of(3))
    np.testing.assert_array_equal(points, q)
    assert same
    none, same = approaches(arm("RRP"), np.zeros((0, 3)), np.full(3, 0.01), limits_of(3))
    assert none.shape == (0, 3)
    assert same
