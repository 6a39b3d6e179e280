"""The robot of a study: built in, from a table or a file; its tools, and what its controller shows.

In: sections checked by the schema. Out: values in SI units.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from elastocal.errors import InputError
from elastocal.files.schema import (
    CheckPoseFile,
    ControllerFile,
    DHRobotFile,
    DHRowFile,
    ToolFile,
    UrdfRobotFile,
)
from elastocal.files.study.joint_values import configuration
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.controller_axes import Coupling, coupling
from elastocal.robot.pose_check import KnownPose
from elastocal.robot.sources import DHRow, from_dh, load
from elastocal.robot.sources.urdf import from_urdf


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
    path = file.parent / entry.urdf
    if not path.exists():
        embedded = file.suffix.lower() == ".json"
        hint = "; name the study with --study, or put the file there" if embedded else ""
        raise LocatedError(
            ("urdf",),
            f"robot file {entry.urdf!r} is not there; it is looked for in {file.parent}, the "
            f"folder of {file.name}{hint}",
        )
    limits = {}
    for key, scale in (("limits_deg", np.pi / 180.0), ("limits_mm", 1e-3)):
        for name, (lower, upper) in getattr(entry, key).items():
            if name in limits:
                raise LocatedError((key, name), f"joint {name!r} has limits in degrees and mm")
            limits[name] = (scale * lower, scale * upper)
    packages = {name: file.parent / folder for name, folder in entry.packages.items()}
    robot = from_urdf(path, base=entry.base, tip=entry.tip, packages=packages, limits=limits)
    for joint in robot.joints:
        wrong = "limits_deg" if joint.prismatic else "limits_mm"
        if joint.name in getattr(entry, wrong):
            right = "limits_mm" if joint.prismatic else "limits_deg"
            raise LocatedError((wrong, joint.name), f"joint {joint.name!r} belongs under {right}")
    return robot


def _from_table(entry: DHRobotFile) -> Robot:
    if not entry.dh:
        raise LocatedError(("dh",), "the DH table has no rows")
    rows = [_row(row, i) for i, row in enumerate(entry.dh)]
    return from_dh(entry.name, rows, modified=entry.convention == "modified")


def _row(row: DHRowFile, index: int) -> DHRow:
    prismatic = row.type == "prismatic"
    wrong = row.limits_deg if prismatic else row.limits_mm
    if wrong is not None:
        need = "limits_mm" if prismatic else "limits_deg"
        raise LocatedError(("dh", index), f"joint {row.joint!r} is {row.type}: use {need}")
    if row.center_mm is not None and row.mass_kg is None:
        raise LocatedError(("dh", index), f"joint {row.joint!r}: center_mm needs mass_kg")
    limits = row.limits_mm if prismatic else row.limits_deg
    scale = 1e-3 if prismatic else np.pi / 180.0
    low, high = (-np.inf, np.inf) if limits is None else (scale * v for v in limits)
    return DHRow(
        name=row.joint,
        theta=np.radians(row.theta_deg),
        d=row.d_mm / 1e3,
        a=row.a_mm / 1e3,
        alpha=np.radians(row.alpha_deg),
        prismatic=prismatic,
        sign=float(row.sign),
        lower=low,
        upper=high,
        mass=row.mass_kg or 0.0,
        center=tuple(v / 1e3 for v in row.center_mm or (0.0, 0.0, 0.0)),
    )


def tool_of(name: str, entry: ToolFile) -> Tool:
    """A tool from its points."""
    load_point = entry.load_point_mm or entry.tcp_mm
    if load_point is None:
        raise InputError(f"tool {name!r} has neither tcp_mm nor load_point_mm; give one of them")
    if entry.markers_mm is not None and not entry.markers_mm:
        raise LocatedError(("markers_mm",), f"tool {name!r}: markers_mm is empty")
    default = "TCP" if entry.tcp_mm is not None else "load point"
    markers = entry.markers_mm or {default: entry.tcp_mm or load_point}
    return Tool(
        name,
        np.array(load_point) / 1e3,
        np.array(list(markers.values())) / 1e3,
        tuple(markers),
        np.array(entry.tcp_mm or load_point) / 1e3,
        entry.radius_mm / 1e3,
    )


def find_tool(tools: Mapping[str, Tool], name: str) -> Tool:
    """The tool called `name`."""
    if name not in tools:
        known = ", ".join(tools) or "none"
        raise LocatedError(("tool",), f"tool {name!r} is not defined; defined are: {known}")
    return tools[name]


def coupling_of(robot: Robot, entry: ControllerFile) -> Coupling:
    """What the controller shows."""
    offsets = {}
    for key, slides, scale in (("offsets_deg", False, np.pi / 180.0), ("offsets_mm", True, 1e-3)):
        for name, value in getattr(entry, key).items():
            joint = robot.joints[robot.index([name])[0]]
            if joint.prismatic != slides:
                right = "offsets_mm" if joint.prismatic else "offsets_deg"
                raise LocatedError((key, name), f"joint {name!r} belongs under {right}")
            offsets[name] = scale * value
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
    shown = configuration(robot, entry.q_deg, entry.q_mm)
    if (entry.flange_mm is None) == (entry.tcp_mm is None):
        raise InputError(f"{name}: give either flange_mm, or tcp_mm with its tool")
    if entry.flange_mm is not None:
        if entry.tool is not None:
            raise LocatedError(("tool",), f"{name}: a tool needs tcp_mm instead of flange_mm")
        return KnownPose(name, shown, np.array(entry.flange_mm) / 1e3)
    if entry.tool is None:
        raise LocatedError(("tcp_mm",), f"{name}: tcp_mm needs the name of its tool")
    point = find_tool(tools, entry.tool).tcp
    return KnownPose(name, shown, np.array(entry.tcp_mm) / 1e3, point)
