"""Every constraint: gradient against central differences, margin against plain geometry."""

from __future__ import annotations

import inspect
from dataclasses import replace

import numpy as np
import pytest

from elastocal import constraints
from elastocal.constraints import (
    AcceptanceCone,
    BeamRange,
    Clearance,
    Constraint,
    Distinct,
    Elevation,
    HalfSpace,
    HeadAzimuth,
    HeadElevation,
    HeldJoint,
    JointLimit,
    LineOfSight,
    MinRadius,
    Tilt,
)
from elastocal.constraints.cell import CollisionRules, clearances, default_clearances
from elastocal.robot.chain import Robot, transform
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import kuka_kr270, three_link
from tests.arms import central_difference, random_chain

POINT = np.array([0.6115, 0.0, -0.460])  # marker of the calibration tool
CONSTRAINTS: dict[str, Constraint] = {
    "lower joint limit": JointLimit("A3 >= -119°", 2, np.radians(-119.0), upper=False, unit="rad"),
    "upper joint limit": JointLimit("A5 <= 122.5°", 4, np.radians(122.5), upper=True, unit="rad"),
    "held joint": HeldJoint("A2 = 20°", 1, np.radians(20.0), unit="rad"),
    "height": HalfSpace("height", POINT, [0, 0, 1], 0.8),
    "oblique half-space": HalfSpace("wall", POINT, [1.0, -2.0, 0.5], -3.0),
    "radius": MinRadius("radius", POINT, 0.6),
    "elevation": Elevation("elevation", [0, 0, 1], np.radians(30.0)),
    "elevation of an oblique axis": Elevation("elevation", [1.0, 2.0, -0.5], 0.7),
    "tilt": Tilt("tilt", [0, 0, 1], [0, 0, -1], np.radians(40.0)),
    "tilt of an oblique axis": Tilt("tilt", [0.3, 1.0, 0.2], [1.0, 1.0, 0.0], 1.0),
    "measured before": Distinct("apart", np.full(6, 0.3), [0, 1, 1, 1, 1, 1], 0.02),
}
GRADIENT = 1e-8


def cell() -> tuple[Clearance, ...]:
    robot = kuka_kr270()
    obstacles = [
        Shape("box", np.array([1.2, 1.6, 0.7]), transform(None, (1.7, 0.25, 0.35)), 0, "table"),
        Shape("sphere", np.array([0.9]), transform(None, (0.5, 2.15, 1.1)), 0, "tank"),
        Shape("capsule", np.array([0.3, 3.0]), transform(None, (-1.5, 0.4, 1.4)), 0, "post"),
    ]
    limits = np.array([robot.lower, robot.upper])
    rules = CollisionRules(floor=0.9, link_radius=0.1617)
    return clearances(robot, robot.tools["calibration"], limits, obstacles, rules)


CONSTRAINTS |= {constraint.name: constraint for constraint in cell()}


def shells() -> dict[str, Constraint]:
    """What stands in for the shapes of a robot: faces near them, within capsules and a box."""
    robot = kuka_kr270()
    sizes = {0: [1.0, 0.8, 0.4], 1: [0.7, 0.6, 0.9], 2: [1.5, 0.4, 0.3], 3: [0.5, 0.8, 0.4]}
    shapes = [
        Shape("box", np.array(size), transform(None, (0.1, 0.0, 0.2)), body, f"link {body}")
        for body, size in sizes.items()
    ]
    post = Shape("cylinder", np.array([0.2, 1.1]), transform(None, (0.0, 0.1, 0.3)), 4, "link 4")
    shaped = replace(robot, collisions=(*shapes, post))
    found = default_clearances(shaped, robot.tools["calibration"])
    assert all(clearance.pairs.faced.any() for clearance in found)
    return {f"{clearance.name}, shells": clearance for clearance in found}


CONSTRAINTS |= shells()

TRACKER = np.array([3.2, -0.8, 1.3])


def sight() -> LineOfSight:
    """Past everything in the cell above, and what the robot has of itself."""
    solids = {id(s): s for c in cell() for s in c.pairs.solids if s.kind != "plane"}
    robot = kuka_kr270()
    return LineOfSight("line of sight", "M1", POINT, TRACKER, list(solids.values()), robot)


CONSTRAINTS |= {
    "range, least": BeamRange("range", "M1", POINT, TRACKER, 1.0, upper=False),
    "range, largest": BeamRange("range", "M1", POINT, TRACKER, 4.0, upper=True),
    "acceptance": AcceptanceCone("acceptance", "M1", POINT, TRACKER, [1.0, 0.2, -0.4], 0.6),
    "head elevation": HeadElevation("elevation", "M1", POINT, TRACKER, 0.7, upper=True),
    "head elevation, least": HeadElevation("elevation", "M1", POINT, TRACKER, -0.5, upper=False),
    "head azimuth": HeadAzimuth("azimuth", "M1", POINT, TRACKER, 2.0, 4.0),
    "line of sight": sight(),
}


def configurations(count: int) -> np.ndarray:
    return np.random.default_rng(0).uniform(-2.5, 2.5, (count, 6))


def test_every_kind_of_constraint_is_tested_here() -> None:
    kinds = {
        value
        for value in vars(constraints).values()
        if inspect.isclass(value) and issubclass(value, Constraint) and value is not Constraint
    }
    assert {type(constraint) for constraint in CONSTRAINTS.values()} == kinds


@pytest.mark.parametrize("name", CONSTRAINTS)
def test_gradient_of_the_margin(name: str) -> None:
    constraint, robot, q = CONSTRAINTS[name], kuka_kr270(), configurations(20)
    gradient = constraint.gradient(robot, q)
    expected = central_difference(lambda x: constraint.margin(robot, x), q)
    assert gradient == pytest.approx(expected, abs=GRADIENT * (1.0 + np.abs(expected).max()))


@pytest.mark.parametrize("name", [n for n in CONSTRAINTS if "joint" not in n])
def test_gradient_of_the_margin_of_an_arm_that_slides(name: str) -> None:
    constraint = CONSTRAINTS[name]
    robot, q = random_chain(np.random.default_rng(1), [False, True] * 3), configurations(20)
    gradient = constraint.gradient(robot, q)
    expected = central_difference(lambda x: constraint.margin(robot, x), q)
    assert gradient == pytest.approx(expected, abs=GRADIENT * (1.0 + np.abs(expected).max()))


@pytest.mark.parametrize("name", CONSTRAINTS)
def test_weighted_gradients_are_gradients_times_weights(name: str) -> None:
    """What refinement asks for: one row per posture, none where the weight is zero."""
    constraint, robot, q = CONSTRAINTS[name], kuka_kr270(), configurations(4)
    weights = np.array([1.0, 0.0, -2.5, 1e3])
    pulled = constraint.at(Posture(robot, q))[1](weights).T
    assert pulled == pytest.approx(weights[:, None] * constraint.gradient(robot, q), abs=1e-9)


@pytest.mark.parametrize("count", [0, 1, 7])
@pytest.mark.parametrize("name", CONSTRAINTS)
def test_a_batch_is_a_loop(name: str, count: int) -> None:
    constraint, robot, q = CONSTRAINTS[name], kuka_kr270(), configurations(count)
    batch = constraint.margin(robot, q)
    single = [constraint.margin(robot, one[None])[0] for one in q]
    assert batch.shape == (count,)
    assert np.allclose(batch, single, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("name", CONSTRAINTS)
def test_units_are_those_of_the_margin(name: str) -> None:
    assert CONSTRAINTS[name].unit in ("m", "rad")
    assert CONSTRAINTS[name].name


def test_joint_limits_measure_the_room_of_their_joint() -> None:
    robot, q = kuka_kr270(), configurations(5)
    lower, upper = CONSTRAINTS["lower joint limit"], CONSTRAINTS["upper joint limit"]
    assert lower.margin(robot, q) == pytest.approx(q[:, 2] + np.radians(119.0))
    assert upper.margin(robot, q) == pytest.approx(np.radians(122.5) - q[:, 4])


def test_workspace_margins_are_distances_of_the_marker() -> None:
    robot, q = kuka_kr270(), configurations(20)
    poses = forward_kinematics(robot, q)
    x, y, z = (poses[:, :3, :3] @ POINT + poses[:, :3, 3]).T
    assert CONSTRAINTS["height"].margin(robot, q) == pytest.approx(z - 0.8)
    assert CONSTRAINTS["radius"].margin(robot, q) == pytest.approx(np.hypot(x, y) - 0.6)
    wall = (x - 2.0 * y + 0.5 * z + 3.0) / np.sqrt(5.25)  # distance from the plane
    assert CONSTRAINTS["oblique half-space"].margin(robot, q) == pytest.approx(wall)


def test_a_half_space_does_not_depend_on_the_length_of_its_normal() -> None:
    robot, q = kuka_kr270(), configurations(5)
    long = HalfSpace("height", POINT, [0, 0, 10], 8.0)
    assert long.margin(robot, q) == pytest.approx(CONSTRAINTS["height"].margin(robot, q))


def test_orientation_margins_are_angles_of_the_flange_axis() -> None:
    robot, q = kuka_kr270(), configurations(50)
    z = forward_kinematics(robot, q)[:, :3, 2]
    over_horizontal = np.arctan2(np.abs(z[:, 2]), np.hypot(z[:, 0], z[:, 1]))
    elevation = CONSTRAINTS["elevation"].margin(robot, q)
    assert elevation == pytest.approx(np.radians(30.0) - over_horizontal)
    from_down = np.arctan2(np.hypot(z[:, 0], z[:, 1]), -z[:, 2])
    assert CONSTRAINTS["tilt"].margin(robot, q) == pytest.approx(np.radians(40.0) - from_down)


def test_angles_are_finite_where_axes_align_to_the_last_digit() -> None:
    """The cosine of a unit vector with itself may be a little over one, either way."""
    robot, home = kuka_kr270(), np.zeros((1, 6))
    turn = forward_kinematics(robot, home)[0, :3, :3]
    for axis in np.random.default_rng(0).normal(size=(200, 3)):
        for sign, room in ((1.0, 0.5), (-1.0, 0.5 - np.pi)):
            tilt = Tilt("tilt", axis, sign * turn @ axis, 0.5)
            assert tilt.margin(robot, home)[0] == pytest.approx(room, abs=1e-7)


def test_elevation_at_home_is_a_right_angle() -> None:
    """Flange z is up at home: 90 degrees over the horizontal where 30 are allowed."""
    margin = CONSTRAINTS["elevation"].margin(kuka_kr270(), np.zeros((1, 6)))
    assert margin == pytest.approx([np.radians(-60.0)])


@pytest.mark.parametrize(
    ("name", "robot", "q"),
    [
        ("elevation", kuka_kr270(), np.zeros((1, 6))),
        ("tilt", kuka_kr270(), np.zeros((1, 6))),
        ("radius", three_link(), np.radians([[0.0, 90.0, 0.0]])),
    ],
)
def test_gradients_are_finite_where_the_angle_or_distance_has_a_kink(
    name: str, robot: Robot, q: np.ndarray
) -> None:
    constraint = CONSTRAINTS[name]
    assert np.isfinite(constraint.margin(robot, q)).all()
    assert np.isfinite(constraint.gradient(robot, q)).all()
