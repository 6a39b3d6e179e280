"""Where the robot may go: joint limits, and constraints on the points and axes of the tool."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Constraint, Elevation, HalfSpace, MinRadius, Tilt
from elastocal.files.sections import Section
from elastocal.files.study.joint_values import by_joint
from elastocal.files.study.obstacles import CollisionFile, FloorFile, ObstacleFile
from elastocal.files.values import (
    Axis,
    DegreeRange,
    Degrees,
    Either,
    MillimetreRange,
    Millimetres,
    MillimetreVector,
    Name,
    PositiveDegrees,
    PositiveMillimetres,
    deg,
    mm,
    off_or,
)
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.joint_kinds import KINDS


class BoxFile(Section):
    """A box in the base frame."""

    min: MillimetreVector
    max: MillimetreVector


class HalfSpaceFile(Section):
    """What lies on that side of a plane where its normal points to."""

    name: Name
    point_mm: MillimetreVector
    normal: Axis


class WorkspaceFile(Section):
    """Where the points of the tool may be."""

    min_z_mm: Millimetres | None = None
    max_z_mm: Millimetres | None = None
    min_radius_mm: PositiveMillimetres | None = None
    box_mm: BoxFile | None = None
    half_spaces: list[HalfSpaceFile] | None = None


class ElevationFile(Section):
    """Angle of a flange axis over the horizontal."""

    axis: Axis
    max_deg: PositiveDegrees


class TiltFile(Section):
    """Angle between a flange axis and a direction of the base frame."""

    axis: Axis
    towards: Axis
    max_deg: PositiveDegrees


_NoCollision = Annotated[Literal["off"], off_or("{}, which may have keys such as margin_mm: 20")]
_NoFloor = Annotated[Literal["off"], off_or("{z_mm: …}, its height in the base frame")]


class ConstraintsFile(Section):
    """Where the robot may go."""

    joint_limits_deg: dict[Name, DegreeRange] | None = None
    joint_limits_mm: dict[Name, MillimetreRange] | None = None
    joint_margin_deg: Degrees = 0.0
    joint_margin_mm: Millimetres = 0.0
    workspace: WorkspaceFile | None = None
    elevation: ElevationFile | None = None
    tilt: TiltFile | None = None
    obstacles: list[ObstacleFile] | None = None
    collision: Either[_NoCollision, CollisionFile] | None = None
    floor: Either[_NoFloor, FloorFile] | None = None


def limits_of(robot: Robot, entry: ConstraintsFile) -> Array:
    """(2, n) limits: the robot's, narrowed by the study, less the margin.

    Equal limits of the study hold a joint at that value; no margin is taken from them.
    """
    limits = np.array([robot.lower, robot.upper])
    held = np.zeros(len(robot.joints), dtype=bool)
    for path, i, (low, high) in by_joint(robot, entry, "joint_limits_{}"):
        name, scale = robot.joint_names[i], robot.joints[i].kind.scale
        if low > high:
            raise LocatedError(
                path,
                f"limits of {name!r}: the lower one, {scale * low:g}, must be below "
                f"the upper one, {scale * high:g}, or equal to it to hold the joint there",
            )
        if low < limits[0, i] - 1e-9 or high > limits[1, i] + 1e-9:
            raise LocatedError(
                path,
                f"limits {scale * low:g} to {scale * high:g} of {name!r} go beyond those of the "
                f"robot, {scale * limits[0, i]:.6g} to {scale * limits[1, i]:.6g}",
            )
        limits[:, i], held[i] = (low, high), low == high
    margins = {}
    for kind in KINDS:
        key = f"joint_margin_{kind.key}"
        margins[kind] = getattr(entry, key)
        if margins[kind] < 0.0:
            shown = kind.scale * margins[kind]
            raise LocatedError((key,), f"{key} must not be negative, found {shown:g}")
    margin = np.where(held, 0.0, [margins[joint.kind] for joint in robot.joints])
    limits += np.outer([1.0, -1.0], margin)
    for i in np.flatnonzero(~held & (limits[0] == limits[1])).tolist():
        raise LocatedError(
            (f"joint_margin_{robot.joints[i].kind.key}",),
            f"the margin leaves joint {robot.joint_names[i]!r} no room; to hold it at a value give "
            f"that twice in joint_limits_{robot.joints[i].kind.key}",
        )
    return limits


def constraints_of(entry: ConstraintsFile, tool: Tool) -> tuple[Constraint, ...]:
    """Workspace and orientation constraints on the points and the axes of the tool."""
    points = _named_points(tool)
    found: list[Constraint] = []
    if entry.workspace is not None:
        for name, point in points:
            found += _workspace(name, point, entry.workspace)
    if entry.elevation is not None:
        e = entry.elevation
        if e.max_deg > np.radians(90.0):
            raise LocatedError(
                ("elevation", "max_deg"), f"max_deg must be at most 90, found {deg(e.max_deg)}"
            )
        label = f"elevation of flange {_axis_name(e.axis)} <= {deg(e.max_deg)}°"
        found.append(Elevation(label, _axis(e.axis, ("elevation",)), e.max_deg))
    if entry.tilt is not None:
        t = entry.tilt
        if not np.radians(0.1) <= t.max_deg <= np.radians(180.0):
            raise LocatedError(
                ("tilt", "max_deg"), f"max_deg must be at most 180, found {deg(t.max_deg)}"
            )
        towards = _axis_name(t.towards)
        label = f"tilt of flange {_axis_name(t.axis)} from {towards} <= {deg(t.max_deg)}°"
        found.append(Tilt(label, _axis(t.axis, ("tilt",)), _axis(t.towards, ("tilt",)), t.max_deg))
    return tuple(found)


def _workspace(name: str, point: Array, w: WorkspaceFile) -> list[Constraint]:
    """Heights, radius, half-spaces and box for one point of the tool."""
    found: list[Constraint] = []
    x, y, z = np.eye(3)
    if w.min_z_mm is not None:
        found.append(
            HalfSpace(f"height of {{}} >= {mm(w.min_z_mm)} mm", point, z, w.min_z_mm, name)
        )
    if w.max_z_mm is not None:
        found.append(
            HalfSpace(f"height of {{}} <= {mm(w.max_z_mm)} mm", point, -z, -w.max_z_mm, name)
        )
    if w.min_radius_mm is not None:
        label = f"radius of {{}} >= {mm(w.min_radius_mm)} mm"
        found.append(MinRadius(label, point, w.min_radius_mm, name))
    for i, plane in enumerate(w.half_spaces or []):
        here = ("workspace", "half_spaces", i)
        if any(plane.name == other.name for other in (w.half_spaces or [])[:i]):
            raise LocatedError((*here, "name"), f"half-space {plane.name!r} is there twice")
        normal = _axis(plane.normal, (*here, "normal"))
        offset = float(normal @ plane.point_mm)
        wall = plane.name.replace("{", "{{").replace("}", "}}")
        label = f"distance of {{}} from {wall} >= 0 mm"
        found.append(HalfSpace(label, point, normal, offset, name))
    if w.box_mm is None:
        return found
    for axis, unit, low, high in zip("xyz", (x, y, z), w.box_mm.min, w.box_mm.max, strict=True):
        if not low < high:
            raise LocatedError(
                ("workspace", "box_mm"),
                f"box_mm: min {axis} {mm(low)} must be below max {axis} {mm(high)}",
            )
        found.append(HalfSpace(f"{axis} of {{}} >= {mm(low)} mm", point, unit, low, name))
        found.append(HalfSpace(f"{axis} of {{}} <= {mm(high)} mm", point, -unit, -high, name))
    return found


def _named_points(tool: Tool) -> list[tuple[str, Array]]:
    """Distinct points of a tool with their names: the markers, and the load point."""
    points = list(zip(tool.marker_names, tool.markers, strict=True))
    if not any(np.array_equal(point, tool.load_point) for _, point in points):
        points.append(("load point", tool.load_point))
    return points


def _axis(axis: str | list[float], place: tuple[str | int, ...]) -> Array:
    vector = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.array(axis)
    if not vector.any():
        raise LocatedError(place, f"{place[-1]}: an axis must not be zero")
    return vector


def _axis_name(axis: str | list[float]) -> str:
    return axis if isinstance(axis, str) else "[" + ", ".join(f"{v:g}" for v in axis) + "]"
