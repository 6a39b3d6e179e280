"""What tells one robot from another does not depend on how it is described."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np

from elastocal.robot.chain import Joint, Robot, transform
from elastocal.robot.geometry_hash import geometry_hash
from elastocal.robot.sources import load
from tests.arms import random_chain, random_rotation

KR270 = load("kuka-kr270")


def described_otherwise(robot: Robot, rng: np.random.Generator) -> Robot:
    """The same lines, with joint frames turned and shifted along them at random."""
    joints, undo = [], np.eye(4)
    for joint in robot.joints:
        turn = random_rotation(rng)
        shift = rng.uniform(-1.0, 1.0) * joint.axis
        if joint.prismatic:
            shift = rng.uniform(-1.0, 1.0, 3)  # where what slides has its frame is free
        moved = transform(turn, shift)
        T = undo @ joint.T_parent_joint @ moved
        joints.append(replace(joint, T_parent_joint=T, axis=turn.T @ joint.axis))
        undo = np.linalg.inv(moved)
    return Robot(robot.name, tuple(joints), undo @ robot.T_tip_flange)


def test_the_description_does_not_count() -> None:
    rng = np.random.default_rng(0)
    for robot in (
        KR270,
        *(random_chain(rng, rng.integers(0, 2, 5).astype(bool)) for _ in range(5)),
    ):
        other = described_otherwise(robot, rng)
        assert geometry_hash(other) == geometry_hash(robot)


def test_limits_tools_and_the_flange_do_not_count() -> None:
    other = replace(
        KR270,
        name="cell 3",
        joints=tuple(replace(joint, lower=-1.0, upper=1.0) for joint in KR270.joints),
        T_tip_flange=transform(translation=(0.1, 0.0, 0.0)),
        tools={},
    )
    assert geometry_hash(other) == geometry_hash(KR270)


def test_the_joints_count() -> None:
    def changed(i: int, **changes: object) -> Robot:
        joints = list(KR270.joints)
        joints[i] = replace(joints[i], **changes)  # type: ignore[arg-type]
        return replace(KR270, joints=tuple(joints))

    shifted = np.array(KR270.joints[2].T_parent_joint)
    shifted[0, 3] += 1e-6
    others = (
        changed(0, name="J1"),
        changed(2, T_parent_joint=shifted),
        changed(3, axis=-KR270.joints[3].axis),
        changed(5, prismatic=True),
        replace(KR270, joints=KR270.joints[:5]),
    )
    assert len({geometry_hash(KR270), *map(geometry_hash, others)}) == 6


def test_it_is_the_same_everywhere() -> None:
    """The digits of the program that wrote it: another rounding would be another robot."""
    one = Robot("one", (Joint("a", transform(translation=(0.1, 0.2, 0.3)), np.array([0, 0, 2.0])),))
    text = "a revolute 0.000000000 0.000000000 1.000000000 0.200000000 -0.100000000 0.000000000\n"
    assert geometry_hash(one) == hashlib.sha256(text.encode()).hexdigest()
    assert geometry_hash(KR270)[:16] == "df6e75dfd87bc5dd"
