"""Test poses of a study: a load case with its tool, a path from a file, or the matrix A0."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import InputError
from elastocal.files.sections import Section
from elastocal.files.study.joint_values import configuration
from elastocal.files.study.tools import find_tool
from elastocal.files.values import (
    Count,
    Degrees,
    FileName,
    ListOrByName,
    Millimetres,
    Name,
    NonNegative,
    Number,
    Vector,
)
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Robot, Tool
from elastocal.study.study import TestPose, test_pose
from elastocal.study.test_path import TestPath, test_path


class TestPoseFile(Section):
    """A test pose: a load case with its tool, a path of them, or the matrix A0."""

    __test__ = False

    name: Name | None = None
    tool: Name | None = None
    q_deg: ListOrByName[Degrees] | None = None
    q_mm: dict[Name, Millimetres] | None = None
    force_N: Vector | None = None
    torque_Nm: Vector | None = None
    path: FileName | None = None
    every: Count | None = None
    regressor_Nm2: list[list[Number]] | None = None
    weight: NonNegative = 1.0


@dataclass(frozen=True)
class Surroundings:
    """What a test pose is read among.

    Attributes:
        robot: The robot.
        springs: The p springs to identify.
        tools: Tools by name.
        folder: Folder of the study file.
        before: The test poses that stand before it.
    """

    robot: Robot
    springs: VirtualJoints
    tools: Mapping[str, Tool]
    folder: Path
    before: Sequence[TestPose | TestPath] = ()


def test_pose_of(entry: TestPoseFile, among: Surroundings) -> TestPose | TestPath:
    """A test pose from its section."""
    name = entry.name or f"test pose {len(among.before) + 1}"
    if entry.path is not None:
        return _path(entry, among)
    if entry.every is not None:
        raise LocatedError(("every",), f"{name}: every takes points of a path; give path as well")
    if entry.regressor_Nm2 is not None:
        return _matrix(entry, among.springs, name)
    if entry.tool is None:
        raise InputError(f"{name}: key 'tool' is missing")
    if entry.force_N is None and entry.torque_Nm is None:
        raise InputError(f"{name}: key 'force_N' is missing")
    wrench = _wrench(entry)
    if not wrench.any():
        raise InputError(f"{name}: force and torque are zero, so nothing deflects there")
    q = configuration(among.robot, entry)
    arm = ElasticArm(among.robot, among.springs, find_tool(among.tools, entry.tool))
    return test_pose(arm, LoadCases(q[None], wrench[None]), entry.weight, name)


def _wrench(entry: TestPoseFile) -> Array:
    return np.append(entry.force_N or [0.0] * 3, entry.torque_Nm or [0.0] * 3)


def _matrix(entry: TestPoseFile, springs: VirtualJoints, name: str) -> TestPose:
    """The matrix A0."""
    for key in ("tool", "q_deg", "q_mm", "force_N", "torque_Nm"):
        if getattr(entry, key) is not None:
            raise LocatedError((key,), f"{name}: give either regressor_Nm2 or {key}")
    rows = entry.regressor_Nm2
    if not rows or any(len(row) != len(springs) for row in rows):
        raise LocatedError(
            ("regressor_Nm2",),
            f"{name}: every row of regressor_Nm2 needs {len(springs)} numbers, one for each "
            f"of {', '.join(springs.names)}",
        )
    return TestPose(name, np.array(rows), entry.weight)


def _path(entry: TestPoseFile, among: Surroundings) -> TestPath:
    """The points of a path file, or each k-th of them."""
    from elastocal.files.paths.path_file import read_path

    assert entry.path is not None
    name = entry.name or Path(entry.path).name
    if entry.regressor_Nm2 is not None:
        raise LocatedError(("regressor_Nm2",), f"{name}: give either path or regressor_Nm2")
    if entry.tool is None:
        raise InputError(f"{name}: key 'tool' is missing")
    tool = find_tool(among.tools, entry.tool)
    constant = entry.force_N is not None or entry.torque_Nm is not None
    load = _wrench(entry) if constant else None
    start = _start(entry, among, tool)
    try:
        task = read_path(among.folder / entry.path, among.robot, tool, start, load)
    except InputError as error:
        raise LocatedError(("path",), str(error)) from None
    every, arm = entry.every or 1, ElasticArm(among.robot, among.springs, tool)
    cases = LoadCases(task.cases.q[::every], task.cases.wrench[::every])
    path = test_path(arm, cases, entry.weight, name)
    return replace(
        path,
        points=task.names[::every],
        remarks=tuple(f"{entry.path}: {remark}" for remark in task.remarks),
        source=entry.path,
        sha256=task.sha256,
    )


def _start(entry: TestPoseFile, among: Surroundings, tool: Tool) -> Array:
    """A configuration near the first point: as given, else that of a pose before with the tool."""
    if entry.q_deg is not None or entry.q_mm is not None:
        return configuration(among.robot, entry)
    for pose in among.before:
        if pose.case is not None and pose.tool is not None and pose.tool.name == tool.name:
            return pose.case.q[0]
    limits = np.array([among.robot.lower, among.robot.upper])
    return np.where(np.isfinite(limits).all(axis=0), limits.mean(axis=0), 0.0)
