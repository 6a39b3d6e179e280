"""Obstacles and collision rules of a study file, as clearances in SI units."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Constraint
from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.errors import InputError
from elastocal.files.schema import CollisionFile, ConstraintsFile, ObstacleFile
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Robot, Tool, transform
from elastocal.robot.shapes import Shape

_UNITS = {"mm": 1e-3, "m": 1.0, "inch": 0.0254}
_ROOM_TO_LEAVE = 2.0  # [mm]
_SHAPES = ("box_mm", "cylinder_mm", "capsule_mm", "sphere_radius_mm", "mesh")


def clearances_of(
    entry: ConstraintsFile, robot: Robot, tool: Tool, limits: Array, folder: Path
) -> tuple[Constraint, ...]:
    """Clearances from the obstacles and of the robot from itself; none if neither key is there.

    Args:
        entry: The constraints section.
        robot: The robot.
        tool: The tool it carries in the experiments.
        limits: (2, n) joint limits [rad or m].
        folder: Where the study file is; meshes must lie in it.
    """
    if entry.obstacles is None and entry.collision is None:
        return ()
    obstacles = [
        _obstacle(one, folder, ("obstacles", i)) for i, one in enumerate(entry.obstacles or [])
    ]
    rules = _rules(entry.collision or CollisionFile(), robot)
    turning = ~robot.prismatic
    limits = np.array(limits)
    endless = turning & ~np.isfinite(limits).all(axis=0)
    limits[:, endless] = np.array([[-np.pi], [np.pi]])
    try:
        return clearances(robot, tool, limits, obstacles, rules)
    except LocatedError:
        raise
    except InputError as error:
        raise LocatedError(_place(str(error), entry), str(error)) from None


def _place(sentence: str, entry: ConstraintsFile) -> tuple[str | int, ...]:
    """The key that an error of the whole cell is about."""
    for i, one in enumerate(entry.obstacles or []):
        if f"{one.name!r}" in sentence or (one.mesh and one.mesh in sentence):
            return ("obstacles", i)
    return ("collision", "ignore") if "is called" in sentence else ("obstacles",)


def _rules(entry: CollisionFile, robot: Robot) -> CollisionRules:
    for key in ("margin_mm", "motion_margin_mm"):
        value = getattr(entry, key)
        if value is not None and value < 0.0:
            raise LocatedError(("collision", key), f"{key} must not be negative, found {value:g}")
    moving = entry.margin_mm / 2.0 if entry.motion_margin_mm is None else entry.motion_margin_mm
    if entry.margin_mm - moving < _ROOM_TO_LEAVE:
        raise LocatedError(
            ("collision", "margin_mm" if entry.motion_margin_mm is None else "motion_margin_mm"),
            f"motions must keep at least {_ROOM_TO_LEAVE:g} mm less than poses, so that a pose at "
            f"its margin can be left; found motion_margin_mm {moving:g}, margin_mm "
            f"{entry.margin_mm:g}",
        )
    radius = entry.link_radius_mm
    if radius is not None and robot.collisions:
        raise LocatedError(
            ("collision", "link_radius_mm"),
            f"link_radius_mm: robot {robot.name!r} has shapes of its own; the capsules this is "
            "the radius of are for robots without",
        )
    if isinstance(radius, dict):
        for name in radius:
            if name not in (*robot.joint_names, "base"):
                raise LocatedError(
                    ("collision", "link_radius_mm", name),
                    f"no joint {name!r}; there are base, {', '.join(robot.joint_names)}",
                )
    motion = entry.motion_margin_mm
    return CollisionRules(
        margin=entry.margin_mm / 1e3,
        motion_margin=None if motion is None else motion / 1e3,
        itself=entry.self,
        ignore=tuple((a, b) for a, b in entry.ignore or []),
        as_capsules=entry.links == "capsules",
        link_radius=(
            {name: value / 1e3 for name, value in radius.items()}
            if isinstance(radius, dict)
            else None
            if radius is None
            else radius / 1e3
        ),
    )


def _obstacle(entry: ObstacleFile, folder: Path, path: tuple[str | int, ...]) -> Shape:
    """One obstacle in the base frame [m]."""
    given = [key for key in _SHAPES if getattr(entry, key) is not None]
    if len(given) != 1:
        raise LocatedError(
            path,
            f"obstacle {entry.name!r} needs exactly one of {', '.join(_SHAPES)}, found "
            f"{' and '.join(given) or 'none'}",
        )
    if entry.mesh_unit is not None and entry.mesh is None:
        raise LocatedError((*path, "mesh_unit"), "mesh_unit is for a mesh")
    if entry.center_mm is None and entry.mesh is None:
        raise LocatedError(path, f"obstacle {entry.name!r}: key 'center_mm' is missing")
    pose = transform(
        _rotation(entry.rpy_deg), [value / 1e3 for value in entry.center_mm or [0.0] * 3]
    )
    if entry.mesh is not None:
        if entry.mesh_unit is None:
            raise LocatedError(
                path,
                f"obstacle {entry.name!r}: say the unit of its mesh with mesh_unit: mm, m or inch",
            )
        file = _inside(folder, entry.mesh, (*path, "mesh"))
        scale = np.full(3, _UNITS[entry.mesh_unit])
        return Shape("mesh", scale, pose, 0, entry.name, file, entry.mesh)
    if entry.box_mm is not None:
        if min(entry.box_mm) <= 0.0:
            raise LocatedError(
                (*path, "box_mm"),
                f"box_mm of {entry.name!r}: the three sides must be positive, found "
                f"{', '.join(f'{side:g}' for side in entry.box_mm)}",
            )
        return Shape("box", np.array(entry.box_mm) / 1e3, pose, 0, entry.name)
    if entry.sphere_radius_mm is not None:
        return Shape("sphere", np.array([entry.sphere_radius_mm / 1e3]), pose, 0, entry.name)
    kind = "cylinder" if entry.cylinder_mm is not None else "capsule"
    tube = entry.cylinder_mm or entry.capsule_mm
    assert tube is not None
    return Shape(kind, np.array([tube.radius, tube.length]) / 1e3, pose, 0, entry.name)


def _inside(folder: Path, name: str, path: tuple[str | int, ...]) -> Path:
    """A file that the study names, in its own folder or below."""
    try:
        inside = (folder / name).resolve().is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):
        raise LocatedError(path, f"mesh {name[:80]!r} is not the name of a file") from None
    if not inside:
        raise LocatedError(path, f"mesh {name!r} is outside the folder of the study; copy it there")
    return folder / name


def _rotation(rpy_deg: list[float] | None) -> Array:
    """(3, 3) rotation by roll about x, then pitch about y, then yaw about z, axes fixed."""
    roll, pitch, yaw = np.radians(rpy_deg or [0.0, 0.0, 0.0])
    (cr, cp, cy), (sr, sp, sy) = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_z @ about_y @ about_x)
