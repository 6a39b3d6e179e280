"""Joints that a study takes as rigid, and whether its test poses mind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import joint_springs
from elastocal.errors import Doubt
from elastocal.study.study import Study

_NOTHING = 1e-9  # share of the largest deflection that is rounding


def left_rigid(study: Study) -> Iterator[Doubt]:
    """The joints that are neither identified nor known: those the task bends, and the others."""
    known = () if study.known is None else study.known.model.names
    given = (*study.springs.names, *known)
    rigid = [name for name in study.robot.joint_names if name not in given]
    at: dict[str, list[str]] = {name: [] for name in rigid}
    for pose in study.test_poses:
        if pose.cases is None or pose.tool is None or not rigid:
            continue
        arm = ElasticArm(study.robot, joint_springs(study.robot), pose.tool.at_tcp)
        size: Array = np.abs(regressor(arm, pose.cases)).max(axis=(0, 1))
        for name, bent in zip(study.robot.joint_names, size, strict=True):
            if name in at and bent > _NOTHING * size.max():
                at[name].append(pose.name)
    if bends := tuple(name for name in rigid if at[name]):
        where = tuple(dict.fromkeys(pose for name in bends for pose in at[name]))
        yield Doubt("rigid-at-test-pose", bends, where)
    if idle := tuple(name for name in rigid if not at[name]):
        yield Doubt("taken-as-rigid", idle)
