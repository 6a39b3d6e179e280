"""Joints that a study takes as rigid, and whether its test poses mind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import joint_springs
from elastocal.errors import Doubt
from elastocal.robot.joint_kinds import KINDS
from elastocal.study.study import Study

_NOTHING = 1e-9  # share of the largest deflection that is rounding


def counted(study: Study) -> tuple[str, ...]:
    """The springs whose bending ρ0 takes into account, joints in the order of the chain."""
    known = () if study.known is None else study.known.model.names
    given = dict.fromkeys((*study.springs.names, *known))
    joints = [name for name in study.robot.joint_names if name in given]
    return (*joints, *(name for name in given if name not in joints))


def left_rigid(study: Study) -> Iterator[Doubt]:
    """The joints that are neither identified nor known: those the task bends, and the others.

    Of those it bends, one doubt for each kind of joint: the test poses, and by name how far a unit
    of compliance moves the tool at most there [m per rad/(N·m) or m/N].
    """
    given = counted(study)
    rigid = [joint for joint in study.robot.joints if joint.name not in given]
    moved = {joint.name: 0.0 for joint in rigid}
    at: dict[str, list[str]] = {joint.name: [] for joint in rigid}
    for pose in study.test_poses:
        if pose.cases is None or pose.tool is None or not rigid:
            continue
        arm = ElasticArm(study.robot, joint_springs(study.robot), pose.tool.at_tcp)
        size: Array = np.linalg.norm(regressor(arm, pose.cases), axis=1).max(axis=0)
        for name, bent in zip(study.robot.joint_names, size.tolist(), strict=True):
            if name in at and bent > _NOTHING * size.max():
                at[name].append(pose.name)
                moved[name] = max(moved[name], bent)
    for kind in KINDS:
        if bends := tuple(j.name for j in rigid if j.kind is kind and at[j.name]):
            where = tuple(dict.fromkeys(pose for name in bends for pose in at[name]))
            numbers = {name: moved[name] for name in bends}
            yield Doubt("rigid-at-test-pose", bends, where, numbers, kind.compliance)
    if idle := tuple(joint.name for joint in rigid if not at[joint.name]):
        yield Doubt("taken-as-rigid", idle)
