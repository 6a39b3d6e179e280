"""Test poses and experiments of a study."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np

from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, Load
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import InputError
from elastocal.files.study.joint_values import configuration
from elastocal.files.study.tools import find_tool
from elastocal.files.values import (
    Count,
    Degrees,
    ListOrByName,
    Millimetres,
    Name,
    Number,
    Positive,
    PositiveDegrees,
    Section,
    Vector,
    deg,
)
from elastocal.files.yaml_lines import LocatedError, at
from elastocal.robot.chain import Robot, Tool
from elastocal.study.study import Experiments, TestPose, test_pose


class TestPoseFile(Section):
    """A test pose: a load case with its tool, or the matrix A0."""

    __test__ = False

    name: Name | None = None
    tool: Name | None = None
    q_deg: ListOrByName[Degrees] | None = None
    q_mm: dict[Name, Millimetres] | None = None
    force_N: Vector | None = None
    torque_Nm: Vector | None = None
    regressor_Nm2: list[list[Number]] | None = None
    weight: Positive = 1.0


class ConeFile(Section):
    """Directions within an angle of an axis."""

    axis: Vector
    half_angle_deg: PositiveDegrees


Direction = Literal["free"] | ConeFile


class ExperimentsFile(Section):
    """What is done."""

    tool: Name
    force_N: Vector | None = None
    max_force_N: Positive | None = None
    direction: Direction | None = None
    torque_Nm: Vector | None = None
    max_torque_Nm: Positive | None = None
    torque_direction: Direction | None = None
    count: Count
    max_configurations: Count | None = None


def test_pose_of(
    robot: Robot,
    springs: VirtualJoints,
    tools: Mapping[str, Tool],
    entry: TestPoseFile,
    index: int,
) -> TestPose:
    """A test pose from its section, the one at `index`."""
    name = entry.name or f"test pose {index + 1}"
    if entry.regressor_Nm2 is not None:
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
    if entry.tool is None:
        raise InputError(f"{name}: key 'tool' is missing")
    if entry.force_N is None and entry.torque_Nm is None:
        raise InputError(f"{name}: key 'force_N' is missing")
    wrench = np.append(entry.force_N or [0.0] * 3, entry.torque_Nm or [0.0] * 3)
    if not wrench.any():
        raise InputError(f"{name}: force and torque are zero, so nothing deflects there")
    q = configuration(robot, entry)
    arm = ElasticArm(robot, springs, find_tool(tools, entry.tool))
    return test_pose(arm, LoadCases(q[None], wrench[None]), entry.weight, name)


def experiments_of(entry: ExperimentsFile, tools: Mapping[str, Tool]) -> Experiments:
    """What is done, with the loads that may be chosen."""
    force = _load(entry, "force_N", "max_force_N", "direction")
    moment = _load(entry, "torque_Nm", "max_torque_Nm", "torque_direction")
    if force is None and moment is None:
        raise InputError(
            "experiments say nothing of the load: give force_N, or max_force_N with direction"
        )
    none = FixedVector(np.zeros(3))
    if entry.max_configurations is not None and entry.max_configurations > entry.count:
        raise LocatedError(
            ("max_configurations",),
            f"max_configurations {entry.max_configurations} "
            f"is more than the {entry.count} experiments",
        )
    return Experiments(
        find_tool(tools, entry.tool),
        force or none,
        entry.count,
        entry.max_configurations,
        moment or none,
    )


def _load(
    entry: ExperimentsFile, fixed_key: str, bound_key: str, direction_key: str
) -> Load | None:
    """A fixed or free load from its keys; None if none is given."""
    fixed, bound, direction = (getattr(entry, k) for k in (fixed_key, bound_key, direction_key))
    if fixed is not None and (bound is not None or direction is not None):
        other = bound_key if bound is not None else direction_key
        raise LocatedError((other,), f"give either {fixed_key} or {bound_key} with {direction_key}")
    if fixed is not None:
        return FixedVector(np.array(fixed))
    if bound is None and direction is not None:
        raise LocatedError((direction_key,), f"{direction_key} needs {bound_key}")
    if bound is None:
        return None
    if direction is None:
        raise LocatedError(
            (bound_key,), f"{bound_key} needs {direction_key}: 'free', or axis and half_angle_deg"
        )
    if isinstance(direction, str):
        return FreeDirection(bound, np.array([0.0, 0.0, -1.0]))
    with at(direction_key):
        if not np.radians(0.1) <= direction.half_angle_deg <= np.radians(180.0):
            raise InputError(
                f"half_angle_deg must be from 0.1 to 180, found {deg(direction.half_angle_deg)}; "
                "a narrower cone is a fixed direction"
            )
        return FreeDirection(bound, np.array(direction.axis), direction.half_angle_deg)
