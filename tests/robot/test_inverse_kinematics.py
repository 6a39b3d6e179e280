"""Damped steps, and configurations that bring the tool to a pose."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastocal as ec
from elastocal.arrays import Array
from elastocal.robot.chain import transform
from elastocal.robot.damped_steps import damped_steps
from elastocal.robot.inverse_kinematics import follow, nearest_configuration
from tests.arms import random_chain

KUKA = ec.load_robot("kuka-kr270")
TCP = KUKA.tools["milling"].tcp
TEST_POSE = np.radians([0.0, -56.9, 89.3, 45.1, 76.0, 57.2])


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_regular_steps_are_those_of_least_squares(seed: int) -> None:
    rng = np.random.default_rng(seed)
    slides = np.zeros(7, dtype=bool)
    columns, wanted = rng.normal(size=(4, 6, 7)), rng.normal(size=(4, 6))
    steps = damped_steps(columns, wanted, slides)
    regular = ~steps.damped
    np.testing.assert_allclose(
        np.einsum("nij,nj->ni", columns, steps.step)[regular], wanted[regular], atol=1e-9
    )
    shortest = np.einsum("nij,nj->ni", np.linalg.pinv(columns), wanted)
    np.testing.assert_allclose(steps.step[regular], shortest[regular], atol=1e-9)


def test_a_lost_direction_is_named_and_gets_no_step() -> None:
    columns = np.diag([1.0, 2.0, 0.0])[None]
    steps = damped_steps(columns, np.array([[1.0, 1.0, 1.0]]), np.zeros(3, dtype=bool))
    assert steps.damped[0]
    np.testing.assert_allclose(np.abs(steps.lost[0]), [0, 0, 1, 0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(steps.step[0], [1.0, 0.5, 0.0], atol=1e-15)


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.sampled_from([3, 6, 7]))
def test_nearby_poses_are_reached(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, [False] * count)
    q = rng.uniform(-np.pi, np.pi, count)
    target = ec.forward_kinematics(robot, q[None])[0] @ transform(None, TCP)
    start = q + rng.uniform(-0.02, 0.02, count)
    near = damped_steps(
        ec.jacobian(robot, q[None], TCP)[:, : 6 if count >= 6 else 3],
        np.zeros((1, 6 if count >= 6 else 3)),
        robot.prismatic,
    )
    reached = nearest_configuration(robot, TCP, target, start)
    if near.damped[0]:
        return
    assert reached.found
    pose = ec.forward_kinematics(robot, reached.q[None])[0] @ transform(None, TCP)
    rows = slice(None) if count >= 6 else (slice(None, 3), 3)
    np.testing.assert_allclose(pose[rows], target[rows], atol=2e-9)


def test_joint_limits_hold_and_what_is_out_of_reach_is_said() -> None:
    target = ec.forward_kinematics(KUKA, TEST_POSE[None])[0] @ transform(None, TCP)
    far = target.copy()
    far[0, 3] += 5.0
    reached = nearest_configuration(KUKA, TCP, far, TEST_POSE)
    assert not reached.found
    assert reached.distance > 2.0
    assert ((reached.q >= KUKA.lower) & (reached.q <= KUKA.upper)).all()


def test_a_pose_beyond_one_joint_limit_is_not_found() -> None:
    q = TEST_POSE.copy()
    q[1] = np.radians(-139.9)
    target = ec.forward_kinematics(KUKA, q[None])[0] @ transform(None, TCP)
    assert nearest_configuration(KUKA, TCP, target, q).found
    q[1] = np.radians(-140.5)
    target = ec.forward_kinematics(KUKA, q[None])[0] @ transform(None, TCP)
    assert not nearest_configuration(KUKA, TCP, target, q).found


@pytest.mark.parametrize("turn", [2.0, 20.0, 60.0])
def test_larger_moves_stay_on_the_branch(turn: float) -> None:
    q = TEST_POSE + np.radians(turn) * np.array([0.5, -0.3, 0.3, 0.2, -0.3, 0.5])
    target = ec.forward_kinematics(KUKA, q[None])[0] @ transform(None, TCP)
    reached = nearest_configuration(KUKA, TCP, target, TEST_POSE)
    assert reached.found
    np.testing.assert_allclose(reached.q, q, atol=1e-8)


def poses(q: Array) -> Array:
    return ec.forward_kinematics(KUKA, q) @ transform(None, TCP)


def winding(count: int) -> Array:
    """A path in joint space that bends between the points that are searched first."""
    t = np.linspace(0.0, 3.0, count)[:, None]
    return TEST_POSE + 0.2 * np.sin(t * np.arange(1, 7)) * np.array([1, 0.5, 0.5, 1, 0.5, 1])


@pytest.mark.parametrize("count", [1, 2, 16, 17, 18, 100])
def test_a_path_is_followed_on_its_branch(count: int) -> None:
    q = winding(count)
    found, last = follow(KUKA, TCP, poses(q), TEST_POSE)
    assert last.found
    np.testing.assert_allclose(found, q, atol=1e-8)


def test_a_path_ends_at_the_first_pose_that_is_not_reached() -> None:
    q = winding(100)
    targets = poses(q)
    targets[37:, 0, 3] += 4.0
    found, last = follow(KUKA, TCP, targets, TEST_POSE)
    assert not last.found
    assert len(found) == 38
    np.testing.assert_allclose(found[:37], q[:37], atol=1e-8)


def test_a_jump_of_the_poses_is_followed_too() -> None:
    q = winding(60)
    q[25:, 0] += np.radians(40.0)
    found, last = follow(KUKA, TCP, poses(q), TEST_POSE)
    assert last.found
    np.testing.assert_allclose(found, q, atol=1e-8)


@pytest.mark.parametrize(("joint", "side"), [(1, -1.0), (4, 1.0)], ids=["A2 lower", "A5 upper"])
@pytest.mark.parametrize("beyond", [-0.004, 0.01])
def test_a_path_does_not_leave_the_limits_between_its_ends(
    beyond: float, joint: int, side: float
) -> None:
    """A joint swings by less than the slack from inside its range to its limit, or over it."""
    limit = (KUKA.lower if side < 0.0 else KUKA.upper)[joint]
    q = np.tile(TEST_POSE, (17, 1))
    swing = (0.005 + beyond) * np.sin(np.linspace(0.0, np.pi, 17))
    q[:, joint] = limit + side * (swing - 0.005)
    found, last = follow(KUKA, TCP, poses(q), q[0])
    assert ((found >= KUKA.lower) & (found <= KUKA.upper)).all()
    if beyond < 0.0:
        np.testing.assert_allclose(found, q, atol=1e-8)
        return
    assert not last.found
    reached = len(found) - 1
    assert reached == int(np.argmax(side * (q[:, joint] - limit) > 0.0))
    np.testing.assert_allclose(found[:reached], q[:reached], atol=1e-8)


def test_a_path_that_bends_is_followed_point_by_point() -> None:
    """Joint 5 swings there and back between the points that are searched first."""
    q = np.tile(TEST_POSE, (17, 1))
    q[:, 4] += 0.2 * np.sin(np.linspace(0.0, np.pi, 17))
    found, last = follow(KUKA, TCP, poses(q), TEST_POSE)
    assert last.found
    np.testing.assert_allclose(found, q, atol=1e-8)


def dense_path(count: int) -> tuple[Array, Array]:
    """Poses of a closed curve round the test pose, and configurations of every eighth by steps."""
    t = np.linspace(0.0, 2.0 * np.pi, count)
    pose = ec.forward_kinematics(KUKA, TEST_POSE[None])[0] @ transform(None, TCP)
    targets = np.tile(pose, (count, 1, 1))
    targets[:, 0, 3] += 0.2 * np.sin(t)
    targets[:, 1, 3] += 0.1 * np.sin(2.0 * t)
    return targets, follow(KUKA, TCP, targets[::8], TEST_POSE)[0]


def test_a_path_of_thousands_of_points_is_followed_as_point_by_point() -> None:
    targets, stepwise = dense_path(5001)
    q, last = follow(KUKA, TCP, targets, TEST_POSE)
    assert last.found
    assert len(q) == len(targets)
    np.testing.assert_allclose(q[::8], stepwise, rtol=0, atol=1e-9)
    reached = ec.forward_kinematics(KUKA, q) @ transform(None, TCP)
    np.testing.assert_allclose(reached, targets, rtol=0, atol=1e-10)


@pytest.mark.parametrize("where", [1, 17, 2500, 4992, 5000])
def test_a_point_out_of_reach_on_a_long_path_is_the_last_one(where: int) -> None:
    targets, _ = dense_path(5001)
    targets[where, 2, 3] += 9.0
    q, last = follow(KUKA, TCP, targets, TEST_POSE)
    assert not last.found
    assert len(q) == where + 1


def test_a_long_path_goes_on_after_a_jump() -> None:
    """Within a block and at once: found one after the other from there on."""
    targets, _ = dense_path(3001)
    targets[1005:, 2, 3] += 0.3
    q, last = follow(KUKA, TCP, targets, TEST_POSE)
    assert last.found
    reached = ec.forward_kinematics(KUKA, q) @ transform(None, TCP)
    np.testing.assert_allclose(reached, targets, rtol=0, atol=1e-10)
