"""URDF robots against Pinocchio: kinematics, masses, and the robot that is built in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yourdfpy

from elastocal.arrays import Array
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture, forward_kinematics, jacobian
from elastocal.robot.sources import kuka_kr270
from elastocal.robot.sources.urdf import from_urdf
from elastocal.robot.sources.urdf_elements import read_elements
from tests.robot.sources.oracle import OWN, UrdfOracle, zoo

ENDS = {
    "arm-7r": ("base_link", "flange"),
    "cobot-ur10e": ("base_link", "tool0"),
    "gantry-5": ("floor", "nose"),
    "kr270": ("base_link", "flange"),
    "rail-arm": ("floor", "tool0"),
    "scara-700": ("base_link", "flange"),
}
ZOO = [
    ("ur_description/urdf/ur5_robot.urdf", "base_link", "tool0"),
    ("ur_description/urdf/ur10_joint_limited_robot.urdf", "world", "ee_link"),
    ("panda_description/urdf/panda.urdf", "panda_link0", "panda_hand_tcp"),
    ("tiago_description/robots/tiago.urdf", "base_footprint", "arm_tool_link"),
    ("tiago_description/robots/tiago.urdf", "torso_lift_link", "arm_7_link"),
    ("baxter_description/urdf/baxter.urdf", "torso", "left_gripper"),
    ("talos_data/robots/talos_left_arm.urdf", "arm_left_1_link", "gripper_left_base_link"),
    ("z1_description/urdf/z1.urdf", "world", "gripperStator"),
    ("kinova_description/robots/kinova.urdf", "base", "j2s6s200_end_effector"),
]
CASES = [(path, *ENDS[path.stem]) for path in OWN] + [(zoo(p), b, t) for p, b, t in ZOO]


def configurations(robot: Robot, count: int) -> Array:
    rng = np.random.default_rng(1)
    low = np.where(np.isfinite(robot.lower), robot.lower, -np.pi)
    high = np.where(np.isfinite(robot.upper), robot.upper, np.pi)
    return rng.uniform(low, high, (count, len(robot.joints)))


@pytest.mark.parametrize("path", dict.fromkeys(path for path, *_ in CASES), ids=lambda p: p.stem)
def test_elements_are_those_of_yourdfpy(path: Path) -> None:
    theirs = yourdfpy.URDF.load(
        path, build_scene_graph=False, load_meshes=False, load_collision_meshes=False
    ).robot
    ours = read_elements(path.read_bytes(), path.name)
    assert [link.name for link in ours.links] == [link.name for link in theirs.links]
    for joint, other in zip(ours.joints, theirs.joints, strict=True):
        assert (joint.name, joint.parent, joint.child) == (other.name, other.parent, other.child)
        pose = np.eye(4) if other.origin is None else other.origin
        np.testing.assert_array_equal(joint.T_parent_child, pose)
        if joint.type != "fixed":
            np.testing.assert_array_equal(joint.axis, other.axis)


def test_the_examples_are_all_compared() -> None:
    assert {path.stem for path in OWN} == set(ENDS)


@pytest.mark.parametrize(("path", "base", "tip"), CASES, ids=lambda value: Path(value).stem)
def test_kinematics_and_masses_are_those_of_pinocchio(path: Path, base: str, tip: str) -> None:
    robot = from_urdf(path, base=base, tip=tip)
    oracle = UrdfOracle(path, base, tip)
    q = configurations(robot, 10)
    forward, columns, posture = forward_kinematics(robot, q), jacobian(robot, q), Posture(robot, q)
    for i in range(len(q)):
        assert forward[i] == pytest.approx(oracle.forward(robot, q[i]), abs=1e-12)
        assert columns[i] == pytest.approx(oracle.jacobian(robot, q[i]), abs=1e-12)
        moments = np.zeros((len(robot.joints) + 1, 4))
        for mass in robot.masses:
            center = posture.point(mass.center, mass.body)[:, i]
            moments[mass.body] += mass.mass * np.append(1.0, center)
        expected = oracle.moments(robot, q[i])
        assert moments[1:] == pytest.approx(expected[1:], abs=1e-9, rel=1e-12)


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.stem)
def test_the_only_end_need_not_be_named(path: Path) -> None:
    named, found = from_urdf(path, base=ENDS[path.stem][0], tip=ENDS[path.stem][1]), from_urdf(path)
    assert found.joint_names == named.joint_names
    assert np.array_equal(found.links, named.links)
    assert found.remarks == ()
    assert found.collisions
    assert found.visuals
    assert found.masses


def test_the_kr270_is_the_one_that_is_built_in() -> None:
    built, read = kuka_kr270(), from_urdf(next(p for p in OWN if p.stem == "kr270"))
    assert read.joint_names == built.joint_names
    assert read.lower == pytest.approx(built.lower, abs=1e-15)
    assert read.upper == pytest.approx(built.upper, abs=1e-15)
    q = configurations(built, 200)
    assert forward_kinematics(read, q) == pytest.approx(forward_kinematics(built, q), abs=1e-12)
    assert jacobian(read, q) == pytest.approx(jacobian(built, q), abs=1e-12)
