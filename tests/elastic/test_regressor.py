"""The regressor against Pinocchio, its gradient against central differences, and invariances."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import Regressor, cartesian_stiffness, deflection, regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged, subset
from elastocal.errors import InputError
from elastocal.robot.chain import Robot, Tool, transform
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.robot.sources import kuka_kr270
from tests.arms import (
    Oracle,
    central_difference,
    chain_with_springs,
    random_chain,
    random_rotation,
    random_tool,
    random_transform,
)
from tests.paper.published import MACHINING_CONFIGURATION, MACHINING_FORCE
from tests.robot.test_chain import kuka_by_modified_dh

# Entries are products of two arms of up to 10 m and wrenches of order 1.
ROUNDING = 1e-12
GRADIENT = 1e-8  # relative; the five-point stencil itself is good to about 1e-11

chains = st.tuples(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=8))
reproducible = settings(max_examples=40)


def random_cases(rng: np.random.Generator, robot: Robot, count: int) -> LoadCases:
    q = rng.uniform(-3.0, 3.0, (count, len(robot.joints)))
    return LoadCases(q, rng.normal(size=(count, 6)))


def close(actual: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    """Equal within `tolerance` of the largest entry."""
    assert actual.shape == expected.shape
    assert np.abs(actual - expected).max(initial=0.0) <= tolerance * np.abs(expected).max(
        initial=1.0
    )


@reproducible
@given(chains, st.integers(1, 3))
def test_regressor_agrees_with_pinocchio(chain: tuple[int, list[bool]], markers: int) -> None:
    """Position rows of several markers and rotation rows, forces and moments, any joints."""
    rng = np.random.default_rng(chain[0])
    robot, tool = random_chain(rng, chain[1]), random_tool(rng, markers)
    oracle, cases = Oracle(robot), random_cases(rng, robot, 3)
    expected = np.array(
        [oracle.regressor(q, w, tool) for q, w in zip(cases.q, cases.wrench, strict=True)]
    )
    springs = joint_springs(robot)
    close(regressor(ElasticArm(robot, springs, tool), cases, rotation=True), expected, ROUNDING)
    close(regressor(ElasticArm(robot, springs, tool), cases), expected[:, :-3], ROUNDING)


@reproducible
@given(chains)
def test_a_subset_of_joints_gives_their_columns(chain: tuple[int, list[bool]]) -> None:
    rng = np.random.default_rng(chain[0])
    robot, tool = random_chain(rng, chain[1]), random_tool(rng, 2)
    cases = random_cases(rng, robot, 2)
    count = int(rng.integers(1, len(robot.joints) + 1))
    chosen = np.sort(rng.choice(len(robot.joints), count, replace=False))
    springs = joint_springs(robot, [robot.joint_names[i] for i in chosen])
    full = regressor(ElasticArm(robot, joint_springs(robot), tool), cases, rotation=True)
    assert springs.names == tuple(robot.joint_names[i] for i in chosen)
    close(
        regressor(ElasticArm(robot, springs, tool), cases, rotation=True), full[:, :, chosen], 1e-15
    )


def random_springs(rng: np.random.Generator, robot: Robot, count: int) -> VirtualJoints:
    """Springs anywhere in the chain, the base and the flange body included."""
    return VirtualJoints(
        names=tuple(f"S{j}" for j in range(count)),
        body=np.sort(rng.integers(0, len(robot.joints) + 1, count)),
        axis=(axis := rng.normal(size=(count, 3))) / np.linalg.norm(axis, axis=1, keepdims=True),
        origin=rng.uniform(-1, 1, (count, 3)),
        prismatic=rng.random(count) < 0.4,
    )


@reproducible
@given(chains)
def test_springs_anywhere_in_the_chain_agree_with_pinocchio(
    chain: tuple[int, list[bool]],
) -> None:
    """Link and base compliances: the same chain with the springs as joints held at zero."""
    rng = np.random.default_rng(chain[0])
    robot, tool = random_chain(rng, chain[1]), random_tool(rng, 2)
    springs = random_springs(rng, robot, 6)
    longer, virtual, actuated = chain_with_springs(robot, springs)
    oracle, cases = Oracle(longer), random_cases(rng, robot, 3)
    for q, wrench, block in zip(
        cases.q,
        cases.wrench,
        regressor(ElasticArm(robot, springs, tool), cases, rotation=True),
        strict=True,
    ):
        held = np.zeros(len(longer.joints))
        held[actuated] = q
        close(block, oracle.regressor(held, wrench, tool)[:, virtual], ROUNDING)


def test_a_joint_spring_is_a_spring_at_the_place_of_the_joint() -> None:
    """The short cut for joint springs, which reuses the joint axes, changes nothing."""
    rng = np.random.default_rng(5)
    robot, tool = random_chain(rng, [False, True, False, False]), random_tool(rng, 1)
    cases, springs = random_cases(rng, robot, 4), joint_springs(robot)
    general = replace(springs, joint=np.array([], dtype=np.int64))
    close(
        regressor(ElasticArm(robot, general, tool), cases),
        regressor(ElasticArm(robot, springs, tool), cases),
        1e-14,
    )


def test_springs_in_joints_and_elsewhere_together() -> None:
    """A base that gives way under springs in joints: as if none were in a joint."""
    rng = np.random.default_rng(6)
    robot, tool = random_chain(rng, [False, True, False, False]), random_tool(rng, 2)
    mixed = merged(random_springs(rng, robot, 3), subset(joint_springs(robot), ["J1", "J2", "J4"]))
    assert (mixed.joint >= 0).sum() == 3
    general = replace(mixed, joint=np.array([], dtype=np.int64))
    cases = random_cases(rng, robot, 4)
    close(
        regressor(ElasticArm(robot, mixed, tool), cases, rotation=True),
        regressor(ElasticArm(robot, general, tool), cases, rotation=True),
        1e-14,
    )


def check_gradient(
    rng: np.random.Generator,
    robot: Robot,
    springs: VirtualJoints,
    tool: Tool,
    *,
    rotation: bool,
    with_moment: bool,
) -> None:
    """`Regressor.pull` in q and in the wrench against central differences of the rows."""
    cases, n = random_cases(rng, robot, 3), len(robot.joints)
    wrench = cases.wrench.copy()
    wrench[:, 3:] *= with_moment
    count = 3 * len(tool.markers) + 3 * rotation
    cotangent = rng.normal(size=(count, len(springs), 3))

    def scalar(x: np.ndarray) -> np.ndarray:
        posture = Posture(robot, x[:, :n])
        values = Regressor(
            ElasticArm(robot, springs, tool), posture, x[:, n:], rotation=rotation
        ).rows
        return (values * cotangent).sum(axis=(0, 1))

    at = Regressor(
        ElasticArm(robot, springs, tool), Posture(robot, cases.q), wrench, rotation=rotation
    )
    pulled = np.concatenate(at.pull(cotangent)).T
    x = np.hstack([cases.q, wrench])
    expected = central_difference(scalar, x)
    scale = 1.0 + np.abs(expected).max()
    assert np.abs(pulled - expected).max() <= GRADIENT * scale


@reproducible
@given(chains, st.integers(1, 3), st.booleans(), st.booleans())
def test_gradient_of_the_regressor(
    chain: tuple[int, list[bool]], markers: int, rotation: bool, with_moment: bool
) -> None:
    rng = np.random.default_rng(chain[0])
    robot, tool = random_chain(rng, chain[1]), random_tool(rng, markers)
    check_gradient(
        rng, robot, joint_springs(robot), tool, rotation=rotation, with_moment=with_moment
    )


@reproducible
@given(chains, st.booleans())
def test_gradient_with_springs_anywhere_in_the_chain(
    chain: tuple[int, list[bool]], rotation: bool
) -> None:
    rng = np.random.default_rng(chain[0])
    robot, tool = random_chain(rng, chain[1]), random_tool(rng, 2)
    springs = random_springs(rng, robot, 5)
    check_gradient(rng, robot, springs, tool, rotation=rotation, with_moment=True)


def test_gradient_where_the_marker_is_the_load_point() -> None:
    """As with the paper's tools: one point then carries both contributions."""
    rng = np.random.default_rng(6)
    robot, point = kuka_kr270(), rng.uniform(-1, 1, 3)
    markers = np.array([point, rng.uniform(-1, 1, 3), point])
    tool = Tool("shared", point, markers, ("M1", "M2", "M3"))
    springs = joint_springs(robot, ["A2", "A4", "A5"])
    check_gradient(rng, robot, springs, tool, rotation=True, with_moment=True)


@pytest.mark.parametrize("order", [["J1", "J3"], ["J3", "J1"]])
def test_gradient_does_not_depend_on_the_order_of_the_names(order: list[str]) -> None:
    rng = np.random.default_rng(7)
    robot, tool = random_chain(rng, [False] * 4), random_tool(rng, 1)
    springs = joint_springs(robot, order)
    check_gradient(rng, robot, springs, tool, rotation=True, with_moment=True)


@pytest.mark.parametrize("count", [0, 1, 7])
def test_a_batch_is_a_loop(count: int) -> None:
    rng = np.random.default_rng(8)
    robot, tool = random_chain(rng, [False, True, False]), random_tool(rng, 2)
    springs = joint_springs(robot)
    cases = random_cases(rng, robot, count)
    batch = regressor(ElasticArm(robot, springs, tool), cases, rotation=True)
    assert batch.shape == (count, 9, 3)
    cotangent = rng.normal(size=(9, 3, count))
    q_bar, wrench_bar = Regressor(
        ElasticArm(robot, springs, tool), Posture(robot, cases.q), cases.wrench, rotation=True
    ).pull(cotangent)
    assert q_bar.shape == (3, count)
    assert wrench_bar.shape == (6, count)
    for i in range(count):
        one = LoadCases(cases.q[i : i + 1], cases.wrench[i : i + 1])
        close(regressor(ElasticArm(robot, springs, tool), one, rotation=True)[0], batch[i], 1e-15)
        single = Regressor(
            ElasticArm(robot, springs, tool), Posture(robot, one.q), one.wrench, rotation=True
        )
        q_one, wrench_one = single.pull(cotangent[:, :, i : i + 1])
        close(q_one[:, 0], q_bar[:, i], 1e-14)
        close(wrench_one[:, 0], wrench_bar[:, i], 1e-14)


def test_deflection_is_the_regressor_times_the_compliances() -> None:
    """Paper eq. (2): J k Jᵀ W, the Jacobians by Pinocchio."""
    rng = np.random.default_rng(9)
    robot, tool = random_chain(rng, [False, False, True, False]), random_tool(rng, 2)
    cases, compliance = random_cases(rng, robot, 3), rng.uniform(0.5, 2.0, 4)
    oracle, found = (
        Oracle(robot),
        deflection(ElasticArm(robot, joint_springs(robot), tool), compliance, cases),
    )
    assert found.shape == (3, 9)
    for q, wrench, moved in zip(cases.q, cases.wrench, found, strict=True):
        generalised = oracle.jacobian(q, oracle.at(tool.load_point)).T @ wrench
        jacobians = [oracle.jacobian(q, oracle.at(marker)) for marker in tool.markers]
        twist = np.vstack([jacobians[0][:3], jacobians[1][:3], jacobians[0][3:]])
        close(moved, twist @ (compliance * generalised), ROUNDING)


def test_deflections_are_reciprocal() -> None:
    """w2 · Δt(w1) = w1 · Δt(w2), if deflection is read where the wrench acts (Betti)."""
    rng = np.random.default_rng(10)
    robot = random_chain(rng, [False, False, True, False, False, False])
    point = rng.uniform(-1, 1, 3)
    tool = Tool("tip", point, point[None], ("M1",))
    q, compliance = rng.uniform(-3, 3, (1, 6)), rng.uniform(0.5, 2.0, 6)
    first, second = rng.normal(size=(2, 6))

    def under(wrench: np.ndarray) -> np.ndarray:
        cases = LoadCases(q, wrench[None])
        return deflection(ElasticArm(robot, joint_springs(robot), tool), compliance, cases)[0]

    assert second @ under(first) == pytest.approx(first @ under(second), rel=1e-12)
    assert first @ under(first) > 0.0


def test_cartesian_stiffness_undoes_the_deflection() -> None:
    """Paper eq. (1): symmetric, positive definite, and K_C Δt = W with the Jacobian of Pinocchio
    inverted as the paper writes it."""
    rng = np.random.default_rng(11)
    robot, point = random_chain(rng, [False, False, True, False, False, False]), np.ones(3)
    q, compliance = rng.uniform(-3, 3, (4, 6)), rng.uniform(0.5, 2.0, 6)
    oracle = Oracle(robot)
    frame = oracle.at(point)
    for one, stiffness in zip(q, cartesian_stiffness(robot, compliance, q, point), strict=True):
        inverse = np.linalg.inv(oracle.jacobian(one, frame))
        expected = inverse.T @ np.diag(1.0 / compliance) @ inverse
        # Inverting loses the square of the condition number of the Jacobian, here below 1e3.
        close(stiffness, expected, 1e-8)
        assert np.linalg.eigvalsh(stiffness + stiffness.T)[0] > 0.0


def test_stiffness_of_an_arm_that_cannot_move_in_all_directions_is_refused() -> None:
    robot = kuka_kr270()
    with pytest.raises(InputError, match="infinite in some direction in configuration 2"):
        # With A5 at zero the axes of A4 and A6 coincide.
        cartesian_stiffness(
            robot, np.ones(6), np.array([np.full(6, 0.5), np.zeros(6)]), np.zeros(3)
        )


def turned_base(robot: Robot, base: np.ndarray) -> Robot:
    first = replace(robot.joints[0], T_parent_joint=base @ robot.joints[0].T_parent_joint)
    return Robot(robot.name, (first, *robot.joints[1:]), robot.T_tip_flange, robot.tools)


def test_turning_the_base_with_the_wrench_turns_the_deflections_only() -> None:
    """So AᵀA, and with it every criterion, does not notice."""
    rng = np.random.default_rng(10)
    robot, tool = random_chain(rng, [False] * 5), random_tool(rng, 2)
    cases, rotation = random_cases(rng, robot, 4), random_rotation(rng)
    turned = turned_base(robot, transform(rotation, rng.uniform(-1, 1, 3)))
    wrench = np.hstack([cases.wrench[:, :3] @ rotation.T, cases.wrench[:, 3:] @ rotation.T])
    before = regressor(ElasticArm(robot, joint_springs(robot), tool), cases)
    after = regressor(ElasticArm(turned, joint_springs(turned), tool), LoadCases(cases.q, wrench))
    blocks = np.kron(np.eye(2), rotation)
    close(after, blocks @ before, 1e-13)


def test_the_kuka_by_modified_dh_has_the_same_regressor() -> None:
    """A0 of the machining pose, from the table; the tool is given in the turned last frame."""
    robot, by_table = kuka_kr270(), kuka_by_modified_dh()
    turn = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])
    milling = robot.tools["milling"]
    same = Tool("milling", turn @ milling.load_point, milling.markers @ turn.T, ("TCP",))
    case = LoadCases(
        np.radians([MACHINING_CONFIGURATION]), np.append(MACHINING_FORCE, np.zeros(3))[None]
    )
    close(
        regressor(ElasticArm(by_table, joint_springs(by_table), same), case),
        regressor(ElasticArm(robot, joint_springs(robot), milling), case),
        1e-13,
    )


def test_springs_of_unknown_joints_are_refused() -> None:
    with pytest.raises(InputError, match="'kuka-kr270' has no joint 'J2'; its joints are A1, A2"):
        joint_springs(kuka_kr270(), ["A2", "J2"])


@pytest.mark.parametrize(
    ("q", "wrench", "message"),
    [
        (np.zeros(6), np.zeros((1, 6)), "found \\(6,\\) and \\(1, 6\\)"),
        (np.zeros((2, 6)), np.zeros((1, 6)), "found \\(2, 6\\) and \\(1, 6\\)"),
        (np.zeros((1, 6)), np.zeros((1, 3)), "found \\(1, 6\\) and \\(1, 3\\)"),
        (np.full((1, 6), np.nan), np.zeros((1, 6)), "found NaN or infinity"),
        (np.zeros((1, 6)), np.full((1, 6), np.inf), "found NaN or infinity"),
    ],
)
def test_wrong_load_cases_are_refused(q: np.ndarray, wrench: np.ndarray, message: str) -> None:
    with pytest.raises(InputError, match=message):
        LoadCases(q, wrench)


def test_load_cases_and_springs_cannot_be_written() -> None:
    cases = LoadCases(np.zeros((1, 6)), np.zeros((1, 6)))
    springs = joint_springs(kuka_kr270())
    for array in (cases.q, cases.wrench, springs.axis, springs.origin, springs.body):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


def test_posture_points_and_bodies_move_with_the_chain() -> None:
    """Points given in a body's frame: body 0 is the base, the last is the flange."""
    rng = np.random.default_rng(11)
    robot = random_chain(rng, [False, True, False])
    q = rng.uniform(-3, 3, (4, 3))
    posture, local = Posture(robot, q), rng.normal(size=3)
    poses = forward_kinematics(robot, q)
    expected = poses[:, :3, :3] @ local + poses[:, :3, 3]
    close(posture.point(local).T, expected, 1e-14)
    close(posture.direction(local).T, poses[:, :3, :3] @ local, 1e-14)
    close(posture.point(local, 0).T, np.tile(local, (4, 1)), 0.0)
    assert random_transform(rng).shape == (4, 4)
