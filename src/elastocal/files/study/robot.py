"""The robot of a study: built in, from a table or a file; and what its controller shows."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np

from elastocal.errors import InputError
from elastocal.files.sections import Section, Told, Variant, fresh
from elastocal.files.study.joint_values import by_joint, configuration
from elastocal.files.study.tools import find_tool
from elastocal.files.values import (
    Argument,
    DegreeRange,
    Degrees,
    FileName,
    ListOrByName,
    MillimetreRange,
    Millimetres,
    MillimetreVector,
    Name,
    Number,
    Positive,
)
from elastocal.files.yaml_lines import LocatedError, at
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.controller_axes import Coupling, coupling
from elastocal.robot.joint_kinds import KINDS, PRISMATIC, REVOLUTE, kind_of
from elastocal.robot.pose_check import KnownPose
from elastocal.robot.sources import DHRow, from_dh, load


class DHRowFile(Section):
    """One row of a DH table."""

    joint: Name
    theta_deg: Degrees = 0.0
    d_mm: Millimetres = 0.0
    a_mm: Millimetres = 0.0
    alpha_deg: Degrees = 0.0
    type: Literal["revolute", "prismatic"] = "revolute"
    sign: Literal[1, -1] = 1
    limits_deg: DegreeRange | None = None
    limits_mm: MillimetreRange | None = None
    mass_kg: Positive | None = None
    center_mm: MillimetreVector | None = None


class DHRobotFile(Section):
    """A robot given by its table."""

    name: Name = "robot"
    convention: Literal["modified", "classic"]
    dh: list[DHRowFile]


class UrdfRobotFile(Section):
    """A robot given by a URDF or xacro file."""

    urdf: FileName
    base: Name | None = None
    tip: Name | None = None
    packages: dict[Name, FileName] = fresh(dict)
    arguments: dict[Name, Argument] = fresh(dict)
    limits_deg: dict[Name, DegreeRange] = fresh(dict)
    limits_mm: dict[Name, MillimetreRange] = fresh(dict)


def _form(value: Any) -> str:
    """Which form a robot has: told by its keys, so that errors speak of one form only."""
    if not isinstance(value, dict):
        return "by name"
    return "by file" if "urdf" in value else "by table"


RobotFile = Annotated[
    Annotated[Name, Variant("by name")]
    | Annotated[DHRobotFile, Variant("by table")]
    | Annotated[UrdfRobotFile, Variant("by file")],
    Told(_form),
]


class ControllerFile(Section):
    """How the joint values of the controller follow from those of the model."""

    preset: Name | None = None
    signs: dict[Name, Literal[1, -1]] = fresh(dict)
    offsets_deg: dict[Name, Degrees] = fresh(dict)
    offsets_mm: dict[Name, Millimetres] = fresh(dict)
    couple: dict[Name, dict[Name, Number]] = fresh(dict)


class CheckPoseFile(Section):
    """A pose read off at the robot, in joint values of the controller."""

    name: Name | None = None
    q_deg: ListOrByName[Degrees] | None = None
    q_mm: dict[Name, Millimetres] | None = None
    flange_mm: MillimetreVector | None = None
    tcp_mm: MillimetreVector | None = None
    tool: Name | None = None


def robot_of(entry: str | DHRobotFile | UrdfRobotFile, file: Path) -> Robot:
    """The robot that a study in `file` names; paths are relative to the folder of `file`."""
    if isinstance(entry, UrdfRobotFile):
        return _from_file(entry, file)
    if isinstance(entry, DHRobotFile):
        return _from_table(entry)
    if Path(entry).suffix.lower() in (".urdf", ".xacro"):
        raise InputError(f"a robot from a file is written as robot: {{urdf: {entry}}}")
    return load(entry)


def _from_file(entry: UrdfRobotFile, file: Path) -> Robot:
    from elastocal.robot.sources.urdf import from_urdf

    path = file.parent / entry.urdf
    if not _exists(path):
        raise LocatedError(
            ("urdf",),
            f"robot file {entry.urdf[:120]!r} is not there; it is looked for in {file.parent}, the "
            f"folder of {file.name}",
        )
    twice = next((name for name in entry.limits_mm if name in entry.limits_deg), None)
    if twice is not None:
        raise LocatedError(("limits_mm", twice), f"joint {twice!r} has limits in degrees and mm")
    limits = {n: (low, high) for n, (low, high) in (entry.limits_deg | entry.limits_mm).items()}
    packages = {name: file.parent / folder for name, folder in entry.packages.items()}
    with at("urdf"):
        robot = from_urdf(
            path,
            base=entry.base,
            tip=entry.tip,
            packages=packages,
            arguments=entry.arguments,
            limits=limits,
        )
    list(by_joint(robot, entry, "limits_{}"))  # for its errors
    return robot


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # too long for a name, or with characters that none has
        return False


def _from_table(entry: DHRobotFile) -> Robot:
    if not entry.dh:
        raise LocatedError(("dh",), "the DH table has no rows")
    rows = [_row(row, i) for i, row in enumerate(entry.dh)]
    return from_dh(entry.name, rows, modified=entry.convention == "modified")


def _row(row: DHRowFile, index: int) -> DHRow:
    kind = kind_of(row.type == PRISMATIC.name)
    limits = {REVOLUTE: row.limits_deg, PRISMATIC: row.limits_mm}
    if any(limits[other] is not None for other in KINDS if other is not kind):
        need = f"limits_{kind.key}"
        raise LocatedError(("dh", index), f"joint {row.joint!r} is {row.type}: use {need}")
    if row.center_mm is not None and row.mass_kg is None:
        raise LocatedError(("dh", index), f"joint {row.joint!r}: center_mm needs mass_kg")
    low, high = limits[kind] or (-np.inf, np.inf)
    return DHRow(
        name=row.joint,
        theta=row.theta_deg,
        d=row.d_mm,
        a=row.a_mm,
        alpha=row.alpha_deg,
        prismatic=kind is PRISMATIC,
        sign=float(row.sign),
        lower=low,
        upper=high,
        mass=row.mass_kg or 0.0,
        center=tuple(row.center_mm or (0.0, 0.0, 0.0)),
    )


def coupling_of(robot: Robot, entry: ControllerFile) -> Coupling:
    """What the controller shows."""
    robot.index([*entry.offsets_deg, *entry.offsets_mm])
    shifts = by_joint(robot, entry, "offsets_{}")
    offsets = {robot.joint_names[i]: value for _, i, value in shifts}
    return coupling(
        robot,
        signs={name: float(sign) for name, sign in entry.signs.items()},
        offsets=offsets,
        couple=entry.couple,
        preset=entry.preset,
    )


def known_pose_of(
    robot: Robot, tools: Mapping[str, Tool], entry: CheckPoseFile, index: int
) -> KnownPose:
    """A pose to check the model with; its joint values are those of the controller."""
    name = entry.name or f"check pose {index + 1}"
    shown = configuration(robot, entry)
    if (entry.flange_mm is None) == (entry.tcp_mm is None):
        raise InputError(f"{name}: give either flange_mm, or tcp_mm with its tool")
    if entry.flange_mm is not None:
        if entry.tool is not None:
            raise LocatedError(("tool",), f"{name}: a tool needs tcp_mm instead of flange_mm")
        return KnownPose(name, shown, np.array(entry.flange_mm))
    if entry.tool is None:
        raise LocatedError(("tcp_mm",), f"{name}: tcp_mm needs the name of its tool")
    return KnownPose(name, shown, np.array(entry.tcp_mm), find_tool(tools, entry.tool).tcp)
