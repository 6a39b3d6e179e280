"""True arms against MuJoCo's, and against the equilibrium that identifies them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.errors import EquilibriumError
from elastocal.robot.chain import Robot, T_body_joint, transform
from elastocal.robot.payloads import Payload
from elastocal.robot.shapes import BodyMass
from elastocal.simulation.absolute_truth import TrueArm, commanded, drawn_displacements, flanges
from tests.arms import Oracle, random_chain, random_tool
from tests.settling import Settling

SLIDES = [False, True, False, False, True]


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes its log into the folder it is run in."""
    monkeypatch.chdir(tmp_path)


def heavy(rng: np.random.Generator, slides: list[bool]) -> Robot:
    masses = tuple(
        BodyMass(b, rng.uniform(5.0, 20.0), rng.normal(size=3)) for b in range(1, len(slides) + 1)
    )
    return replace(random_chain(rng, slides), masses=masses)


def springs_of(robot: Robot, rng: np.random.Generator) -> VirtualJoints:
    axis = rng.normal(size=(3, 3))
    extra = VirtualJoints(
        names=("base", "link", "slide"),
        body=np.array([0, 2, 3]),
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        origin=rng.normal(size=(3, 3)),
        prismatic=np.array([False, False, True]),
    )
    return merged(extra, joint_springs(robot))


def displaced(robot: Robot, moved: Array) -> Robot:
    """The robot as a file would have it if all frames were displaced."""
    joints = tuple(
        replace(joint, T_parent_joint=joint.T_parent_joint @ by)
        for joint, by in zip(robot.joints, moved, strict=False)
    )
    return replace(robot, joints=joints, T_tip_flange=robot.T_tip_flange @ moved[-1])


@pytest.mark.parametrize("seed", range(3))
def test_mujoco_comes_to_rest_in_the_same_place(seed: int) -> None:
    """Springs anywhere, sliding joints, weights, a payload, a wrench; every frame displaced."""
    rng = np.random.default_rng(seed)
    robot = heavy(rng, SLIDES)
    springs = springs_of(robot, rng)
    compliance = np.where(springs.prismatic, 1e-6, 1e-5) * rng.uniform(0.5, 2.0, len(springs))
    moved = drawn_displacements(robot, 0.02, 0.02, rng)
    tool, gravity = random_tool(rng, 2), rng.normal(size=3) * 5.0
    load = Payload("weight", 30.0, rng.normal(size=3))
    arm = TrueArm(robot, moved, springs, compliance, gravity, (load,))
    q, wrench = rng.uniform(-1.0, 1.0, (2, 5)), rng.normal(size=(2, 6)) * 100.0
    ours = flanges(arm, q, wrench, tool.load_point, np.array([0, -1]))
    files = displaced(robot, moved)
    # MuJoCo's arm is built from the drawing with its frames displaced; springs and masses sit in
    # bodies as drawn, which are those of the displaced robot where no axis moved in its frame.
    hung = replace(
        files,
        masses=(
            *files.masses,
            BodyMass(5, load.mass, _in_body(files, load.center)),
        ),
    )
    for i, each in enumerate((hung, files)):
        settled = Settling(ElasticArm(each, springs, tool, gravity), compliance, q[i])
        theirs = settled.markers(wrench[i]).reshape(2, 3)
        found = tool.markers @ ours[i, :3, :3].T + ours[i, :3, 3]
        assert found == pytest.approx(theirs, abs=1e-10)


def _in_body(robot: Robot, center: Array) -> Array:
    """A point of the flange in the frame of the last body."""
    last = T_body_joint(robot, robot.last) @ robot.T_tip_flange
    return np.asarray((last @ np.append(center, 1.0))[:3])


def test_a_rigid_arm_is_where_pinocchio_has_it() -> None:
    rng = np.random.default_rng(3)
    robot = random_chain(rng, [False, True, False])
    moved = drawn_displacements(robot, 0.01, 0.01, rng)
    arm = TrueArm(robot, moved, joint_springs(robot, ()), np.zeros(0), np.zeros(3))
    q = rng.uniform(-1.0, 1.0, (4, 3))
    found = flanges(arm, q, np.zeros((4, 6)), np.zeros(3), np.full(4, -1))
    oracle = Oracle(displaced(robot, moved))
    assert found == pytest.approx(np.array([oracle.forward(each) for each in q]), abs=1e-12)


def test_an_arm_that_gives_way_is_said_to() -> None:
    rng = np.random.default_rng(4)
    robot = heavy(rng, [False, False])
    nowhere = np.tile(np.eye(4), (3, 1, 1))
    arm = TrueArm(
        robot, nowhere, joint_springs(robot), np.array([1.0, 1.0]), np.array([0, 0, -9.8])
    )
    with pytest.raises(EquilibriumError, match="does not come to rest"):
        flanges(arm, rng.normal(size=(1, 2)), np.zeros((1, 6)), np.zeros(3), np.array([-1]))


def test_joints_are_elsewhere_than_shown() -> None:
    rng = np.random.default_rng(5)
    robot = random_chain(rng, [False, True])
    arm = TrueArm(
        robot,
        np.tile(transform(), (3, 1, 1)),
        joint_springs(robot, ()),
        np.zeros(0),
        np.zeros(3),
        wave=np.array([1e-3, 2e-3]),
        waves=np.array([2.0, 10.0]),
        phase=np.array([0.0, np.pi / 2]),
    )
    shown = np.array([[np.pi / 4, 0.0], [0.0, 0.05]])
    stands = commanded(arm, shown, rng) - shown
    assert stands == pytest.approx(np.array([[1e-3, 2e-3], [0.0, -2e-3]]), abs=1e-15)
    loose = replace(arm, wave=np.zeros(2), loose=np.array([1e-4, 0.0]))
    scatter = commanded(loose, np.zeros((4000, 2)), rng)
    assert scatter.std(axis=0) == pytest.approx([1e-4, 0.0], rel=0.05)
