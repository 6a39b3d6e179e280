"""The constraints section of a study file, as limits and constraints in SI units."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Constraint, Elevation, HalfSpace, MinRadius, Tilt
from elastocal.files.schema import ConstraintsFile, WorkspaceFile
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Robot, Tool


def limits_of(robot: Robot, entry: ConstraintsFile) -> Array:
    """(2, n) limits: the robot's, narrowed by the study, less the margin."""
    limits = np.array([robot.lower, robot.upper])
    for key, prismatic, scale in (
        ("joint_limits_deg", False, np.pi / 180.0),
        ("joint_limits_mm", True, 1e-3),
    ):
        for name, (low, high) in (getattr(entry, key) or {}).items():
            path = (key, name)
            if name not in robot.joint_names:
                raise LocatedError(
                    path, f"no joint {name!r}; the joints are {', '.join(robot.joint_names)}"
                )
            i = robot.joint_names.index(name)
            if robot.joints[i].prismatic != prismatic:
                right = "joint_limits_deg" if prismatic else "joint_limits_mm"
                raise LocatedError(path, f"joint {name!r} belongs under {right}")
            if not low < high:
                raise LocatedError(
                    path,
                    f"limits of {name!r}: the lower one, {low:g}, must be below "
                    f"the upper one, {high:g}",
                )
            if scale * low < limits[0, i] - 1e-9 or scale * high > limits[1, i] + 1e-9:
                raise LocatedError(
                    path,
                    f"limits {low:g} to {high:g} of {name!r} go beyond those of the robot, "
                    f"{limits[0, i] / scale:.6g} to {limits[1, i] / scale:.6g}",
                )
            limits[:, i] = scale * low, scale * high
    for key in ("joint_margin_deg", "joint_margin_mm"):
        if getattr(entry, key) < 0.0:
            raise LocatedError((key,), f"{key} must not be negative, found {getattr(entry, key):g}")
    margin = np.where(
        robot.prismatic, entry.joint_margin_mm / 1e3, np.radians(entry.joint_margin_deg)
    )
    return limits + np.outer([1.0, -1.0], margin)


def constraints_of(entry: ConstraintsFile, tool: Tool) -> tuple[Constraint, ...]:
    """Workspace and orientation constraints on the points and the axes of the tool."""
    points = _named_points(tool)
    found: list[Constraint] = []
    if entry.workspace is not None:
        for name, point in points:
            found += _workspace(name, point, entry.workspace)
    if entry.elevation is not None:
        e = entry.elevation
        if e.max_deg > 90.0:
            raise LocatedError(
                ("elevation", "max_deg"), f"max_deg must be at most 90, found {e.max_deg:g}"
            )
        label = f"elevation of flange {_axis_name(e.axis)} <= {e.max_deg:g}°"
        found.append(Elevation(label, _axis(e.axis, "elevation"), np.radians(e.max_deg)))
    if entry.tilt is not None:
        t = entry.tilt
        if not 0.1 <= t.max_deg <= 180.0:
            raise LocatedError(
                ("tilt", "max_deg"), f"max_deg must be at most 180, found {t.max_deg:g}"
            )
        label = (
            f"tilt of flange {_axis_name(t.axis)} from {_axis_name(t.towards)} <= {t.max_deg:g}°"
        )
        found.append(
            Tilt(label, _axis(t.axis, "tilt"), _axis(t.towards, "tilt"), np.radians(t.max_deg))
        )
    return tuple(found)


def _workspace(name: str, point: Array, w: WorkspaceFile) -> list[Constraint]:
    """Heights, radius and box for one point of the tool."""
    found: list[Constraint] = []
    if w.min_z_mm is not None:
        found.append(_height(name, point, w.min_z_mm, 1.0, ">="))
    if w.max_z_mm is not None:
        found.append(_height(name, point, w.max_z_mm, -1.0, "<="))
    if w.min_radius_mm is not None:
        label = f"radius of {name} >= {w.min_radius_mm:g} mm"
        found.append(MinRadius(label, point, w.min_radius_mm / 1e3))
    for i, axis in enumerate("xyz" if w.box_mm is not None else ""):
        assert w.box_mm is not None
        low, high = w.box_mm.min[i], w.box_mm.max[i]
        if not low < high:
            raise LocatedError(
                ("workspace", "box_mm"),
                f"box_mm: min {axis} {low:g} must be below max {axis} {high:g}",
            )
        unit = np.eye(3)[i]
        found.append(HalfSpace(f"{axis} of {name} >= {low:g} mm", point, unit, low / 1e3))
        found.append(HalfSpace(f"{axis} of {name} <= {high:g} mm", point, -unit, -high / 1e3))
    return found


def _named_points(tool: Tool) -> list[tuple[str, Array]]:
    """Distinct points of a tool with their names: the markers, and the load point."""
    points = list(zip(tool.marker_names, tool.markers, strict=True))
    if not any(np.array_equal(point, tool.load_point) for _, point in points):
        points.append(("load point", tool.load_point))
    return points


def _height(name: str, point: Array, height: float, sign: float, relation: str) -> HalfSpace:
    label = f"height of {name} {relation} {height:g} mm"
    return HalfSpace(label, point, [0.0, 0.0, sign], sign * height / 1e3)


def _axis(axis: str | list[float], key: str) -> Array:
    vector = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.array(axis)
    if not vector.any():
        raise LocatedError((key,), f"{key}: an axis must not be zero")
    return vector


def _axis_name(axis: str | list[float]) -> str:
    return axis if isinstance(axis, str) else "[" + ", ".join(f"{v:g}" for v in axis) + "]"
