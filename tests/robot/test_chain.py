"""Kinematics against Pinocchio, robots from tables, and what a wrong description is told."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.errors import InputError
from elastocal.robot import sources as robots
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.joint_room import outside
from elastocal.robot.posture import forward_kinematics, jacobian
from elastocal.robot.sources import DHRow, from_dh, kuka_kr270, three_link
from tests.arms import Oracle, random_chain, random_transform

ROUNDING = 1e-12  # a chain of ten joints with links of a metre multiplies 1e-16 by less than 100

chains = st.tuples(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=9))
reproducible = settings(max_examples=40)


@reproducible
@given(chains)
def test_forward_kinematics_agrees_with_pinocchio(chain: tuple[int, list[bool]]) -> None:
    rng = np.random.default_rng(chain[0])
    robot = random_chain(rng, chain[1])
    oracle = Oracle(robot)
    q = rng.uniform(-3.0, 3.0, (5, len(robot.joints)))
    expected = np.array([oracle.forward(one) for one in q])
    assert forward_kinematics(robot, q) == pytest.approx(expected, abs=ROUNDING)


@reproducible
@given(chains)
def test_jacobian_agrees_with_pinocchio(chain: tuple[int, list[bool]]) -> None:
    rng = np.random.default_rng(chain[0])
    robot = random_chain(rng, chain[1])
    oracle = Oracle(robot)
    q = rng.uniform(-3.0, 3.0, (5, len(robot.joints)))
    point = rng.uniform(-1.0, 1.0, 3)
    frame = oracle.at(point)
    expected = np.array([oracle.jacobian(one, frame) for one in q])
    assert jacobian(robot, q, point) == pytest.approx(expected, abs=ROUNDING)
    expected = np.array([oracle.jacobian(one, oracle.flange) for one in q])
    assert jacobian(robot, q) == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.parametrize("count", [0, 1, 7])
def test_a_batch_is_a_loop(count: int) -> None:
    rng = np.random.default_rng(1)
    robot = random_chain(rng, [False, True, False, False])
    q = rng.uniform(-3.0, 3.0, (count, 4))
    poses = [forward_kinematics(robot, one[None])[0] for one in q]
    jacobians = [jacobian(robot, one[None])[0] for one in q]
    assert forward_kinematics(robot, q).shape == (count, 4, 4)
    assert jacobian(robot, q).shape == (count, 6, 4)
    assert np.allclose(
        forward_kinematics(robot, q), np.reshape(poses, (count, 4, 4)), rtol=0, atol=1e-15
    )
    assert np.allclose(jacobian(robot, q), np.reshape(jacobians, (count, 6, 4)), rtol=0, atol=1e-15)


def test_the_three_link_arm_is_that_of_the_paper() -> None:
    """Eq. (23)."""
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (20, 3))
    l1, l2, l3 = 0.75, 1.25, 1.10
    reach = l2 * np.cos(q[:, 1]) + l3 * np.cos(q[:, 1] + q[:, 2])
    height = l1 + l2 * np.sin(q[:, 1]) + l3 * np.sin(q[:, 1] + q[:, 2])
    expected = np.column_stack([reach * np.cos(q[:, 0]), reach * np.sin(q[:, 0]), height])
    assert forward_kinematics(three_link(), q)[:, :3, 3] == pytest.approx(expected, abs=1e-15)


def test_the_kuka_at_home_has_both_arms_stretched_forward() -> None:
    home = forward_kinematics(kuka_kr270(), np.zeros((1, 6)))[0]
    assert home[:3, :3] == pytest.approx(np.eye(3), abs=1e-15)
    assert home[:3, 3] == pytest.approx([0.350 + 1.250 + 1.100, 0.0, 0.750 - 0.055], abs=1e-15)


def kuka_by_modified_dh() -> Robot:
    """The KR-270 as a table of modified DH parameters."""
    quarter = np.pi / 2
    table = [  # alpha, a, d, theta
        (np.pi, 0.0, -0.750, 0.0),
        (quarter, 0.350, 0.0, 0.0),
        (0.0, 1.250, 0.0, -quarter),
        (quarter, -0.055, -1.100, 0.0),
        (-quarter, 0.0, 0.0, 0.0),
        (quarter, 0.0, 0.0, np.pi),
    ]
    rows = [
        DHRow(f"A{i + 1}", theta=theta, d=d, a=a, alpha=alpha)
        for i, (alpha, a, d, theta) in enumerate(table)
    ]
    return from_dh("kuka by table", rows, modified=True)


def test_the_kuka_by_modified_dh_is_the_built_in_one() -> None:
    """Its last frame is turned: flange x is -z6, flange z is -x6."""
    q = np.random.default_rng(2).uniform(-3.0, 3.0, (20, 6))
    turn = np.array([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0], [-1.0, 0.0, 0.0]])
    by_table = forward_kinematics(kuka_by_modified_dh(), q) @ transform(turn)
    assert by_table == pytest.approx(forward_kinematics(kuka_kr270(), q), abs=ROUNDING)


def screw_product(order: str, theta: float, d: float, a: float, alpha: float) -> np.ndarray:
    """Product of the four elementary moves of a DH row, written out."""
    ct, s_t, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
    moves = {
        "z": np.array([[ct, -s_t, 0, 0], [s_t, ct, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1.0]]),
        "d": transform(None, (0, 0, d)),
        "a": transform(None, (a, 0, 0)),
        "x": np.array([[1, 0, 0, 0], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1.0]]),
    }
    product = np.eye(4)
    for letter in order:
        product = product @ moves[letter]
    return product


@pytest.mark.parametrize(("modified", "order"), [(False, "zdax"), (True, "xazd")])
def test_dh_tables_against_the_explicit_product(modified: bool, order: str) -> None:
    """Classic: turn and shift z, then x; modified: x, then z. With slides and reversed signs."""
    rng = np.random.default_rng(3)
    rows = [
        DHRow(f"J{i}", *rng.uniform(-1.5, 1.5, 4), prismatic=i % 3 == 1, sign=(-1.0) ** (i // 2))
        for i in range(5)
    ]
    robot = from_dh("table", rows, modified=modified)
    q = rng.uniform(-2.0, 2.0, (10, 5))
    for one, pose in zip(q, forward_kinematics(robot, q), strict=True):
        expected = np.eye(4)
        for row, value in zip(rows, one, strict=True):
            moved = row.sign * value
            theta = row.theta + (0.0 if row.prismatic else moved)
            d = row.d + (moved if row.prismatic else 0.0)
            expected = expected @ screw_product(order, theta, d, row.a, row.alpha)
        assert pose == pytest.approx(expected, abs=ROUNDING)


def test_joint_values_of_a_table_keep_their_limits() -> None:
    row = DHRow("J1", 0.1, 0.2, 0.3, 0.4, lower=-1.0, upper=2.0)
    robot = from_dh("table", [row], modified=False)
    assert robot.lower == pytest.approx([-1.0])
    assert robot.upper == pytest.approx([2.0])


def test_an_axis_is_used_by_its_direction_alone() -> None:
    short = Robot("short", (Joint("J1", np.eye(4), np.array([0.0, 0.0, 1e-3])),))
    long = Robot("long", (Joint("J1", np.eye(4), np.array([0.0, 0.0, 1e3])),))
    q = np.array([[0.7]])
    assert np.array_equal(forward_kinematics(short, q), forward_kinematics(long, q))


def test_arrays_of_frozen_values_cannot_be_written() -> None:
    robot = kuka_kr270()
    joint, tool = robot.joints[0], robot.tools["milling"]
    for array in (
        robot.links,
        robot.T_tip_flange,
        joint.axis,
        joint.T_parent_joint,
        tool.load_point,
        tool.markers,
        tool.tcp,
    ):
        assert array is not None
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_a_robot_does_not_change_with_the_arrays_it_was_made_from() -> None:
    rng = np.random.default_rng(4)
    place, axis = random_transform(rng), rng.normal(size=3)
    robot = Robot("kept", (Joint("J1", place, axis),))
    before = forward_kinematics(robot, np.array([[0.3]]))
    place[:], axis[:] = 0.0, 0.0
    assert np.array_equal(forward_kinematics(robot, np.array([[0.3]])), before)


@pytest.mark.parametrize(
    ("T", "axis", "limits", "message"),
    [
        (np.eye(3), [0, 0, 1], (-1, 1), "joint 'J1': its transform must be a finite 4x4 matrix"),
        (np.full((4, 4), np.nan), [0, 0, 1], (-1, 1), "'J1': its transform must be a finite 4x4"),
        (np.eye(4), [0, 0, 0], (-1, 1), "joint 'J1': its axis must be a non-zero vector"),
        (np.eye(4), [0, np.nan, 1], (-1, 1), "joint 'J1': its axis must be a non-zero vector"),
        (np.eye(4), [0, 1], (-1, 1), "joint 'J1': its axis must be a non-zero vector"),
        (np.eye(4), [0, 0, 1], (1, -2), "limit 57.2958 must be below the upper limit -114.592 °"),
        (np.eye(4), [0, 0, 1], (1, 1), "limit 57.2958 must be below the upper limit 57.2958 °"),
        (np.eye(4), [0, 0, 1], (np.nan, 1), "'J1': the lower limit nan must be below"),
    ],
)
def test_a_wrong_joint_is_refused_by_name(
    T: np.ndarray, axis: list[float], limits: tuple[float, float], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Joint("J1", T, np.array(axis, dtype=float), False, *limits)


def test_a_wrong_robot_is_refused() -> None:
    joint = Joint("A1", np.eye(4), np.array([0.0, 0.0, 1.0]))
    with pytest.raises(InputError, match="robot 'empty': it has no joints"):
        Robot("empty", ())
    with pytest.raises(InputError, match="robot 'twice': joint name 'A1' is used twice"):
        Robot("twice", (joint, joint))
    with pytest.raises(InputError, match="'kuka-kr270' has no joint 'A7'; its joints are A1, A2,"):
        kuka_kr270().index(["A1", "A7"])
    with pytest.raises(InputError, match="no built-in robot 'kuka'; there are kuka-kr270, three-"):
        robots.load("kuka")


def test_a_tool_names_every_marker() -> None:
    with pytest.raises(InputError, match="tool 'probe': 2 markers, 1 names"):
        Tool("probe", np.zeros(3), np.zeros((2, 3)), ("M1",))


def test_the_tcp_of_a_tool_is_its_load_point_unless_told_otherwise() -> None:
    point = np.array([0.1, 0.2, 0.3])
    assert Tool("plain", point, np.zeros((0, 3)), ()).tcp == pytest.approx(point)
    assert Tool("own", point, np.zeros((0, 3)), (), 2 * point).tcp == pytest.approx(2 * point)


@pytest.mark.parametrize("name", robots.BUILTIN)
def test_every_built_in_robot_loads_under_its_own_name(name: str) -> None:
    robot = robots.load(name)
    assert robot.name == name
    assert np.all(robot.lower < robot.upper)
    assert robot.tools


def test_a_value_outside_says_which_one_is_inside() -> None:
    shoulder = Joint("J2", np.eye(4), np.array([0.0, 0.0, 1.0]), False, *np.radians([47.0, 313.0]))
    said = "J2 at 0°, outside its limits 47 to 313°, whose middle is 180°"
    assert outside(shoulder, 0.0) == said
    assert outside(shoulder, np.radians(-90)).endswith("; the same place is at 270°")
    assert outside(shoulder, np.radians(180)) == ""
    rail = Joint("E1", np.eye(4), np.array([0.0, 0.0, 1.0]), True, 0.1, 0.5)
    assert (
        outside(rail, 0.0) == "E1 at 0 mm, outside its limits 100 to 500 mm, whose middle is 300 mm"
    )
