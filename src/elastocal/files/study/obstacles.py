"""Obstacles, floor and collision rules of a study, as clearances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Constraint
from elastocal.constraints.cell import FLOOR, CollisionRules, clearances, usual_rules
from elastocal.errors import Doubt, InputError
from elastocal.files.sections import Section
from elastocal.files.values import (
    DegreeVector,
    FileName,
    Flag,
    Millimetres,
    MillimetreVector,
    Name,
    NamePair,
    OneOrByName,
    PositiveMillimetres,
    mm,
)
from elastocal.files.yaml_lines import LocatedError, Path_, at
from elastocal.robot.chain import Robot, Tool, transform
from elastocal.robot.rotations import from_zyx_angles
from elastocal.robot.shapes import Shape

_UNITS = {"mm": 1e-3, "m": 1.0, "inch": 0.0254}
_ROOM_TO_LEAVE = 2e-3  # [m]
_ROUNDING = 1e-9  # [m]
_SHAPES = ("box_mm", "cylinder_mm", "capsule_mm", "sphere_radius_mm", "mesh")


@dataclass(frozen=True)
class Cell:
    """What clearances are of.

    Attributes:
        robot: The robot.
        tool: The tool it carries in the experiments.
        limits: (2, n) joint limits [rad or m].
        gravity: (3,) acceleration in the base frame [m/s²], zero if it is not known.
        folder: Where the study file is; meshes must lie in it.
    """

    robot: Robot
    tool: Tool
    limits: Array
    gravity: Array
    folder: Path


class CylinderFile(Section):
    """A cylinder or capsule along its z axis; the length of a capsule is without its caps."""

    radius: PositiveMillimetres
    length: PositiveMillimetres


class ObstacleFile(Section):
    """Something that stands in the cell: one of five shapes, and where it is."""

    name: Name
    box_mm: MillimetreVector | None = None
    cylinder_mm: CylinderFile | None = None
    capsule_mm: CylinderFile | None = None
    sphere_radius_mm: PositiveMillimetres | None = None
    mesh: FileName | None = None
    mesh_unit: Literal["mm", "m", "inch"] | None = None
    center_mm: MillimetreVector | None = None
    rpy_deg: DegreeVector | None = None


class CollisionFile(Section):
    """What counts as a collision."""

    margin_mm: Millimetres = 20.0
    motion_margin_mm: Millimetres | None = None
    self: Flag = True
    ignore: list[NamePair] | None = None
    links: Literal["hulls", "capsules"] = "hulls"
    link_radius_mm: OneOrByName[PositiveMillimetres] | None = None


class FloorFile(Section):
    """The level floor under links and tool."""

    z_mm: Millimetres


def clearances_of(
    entries: Sequence[ObstacleFile] | None,
    collision: CollisionFile | Literal["off"] | None,
    floor: FloorFile | Literal["off"] | None,
    cell: Cell,
) -> tuple[Constraint, ...]:
    """Clearances from the obstacles, from the floor and of the robot from itself.

    Where nothing is said, the robot is kept from itself and from the floor it stands on by what is
    at hand, as `default_clearances` does.

    Args:
        entries: The obstacles.
        collision: What counts as a collision.
        floor: The floor.
        cell: What the clearances are of.
    """
    obstacles = []
    for i, one in enumerate(entries or []):
        with at("obstacles", i):
            obstacles.append(_obstacle(one, cell.folder))
    rules = usual_rules(cell.robot, cell.gravity)
    if collision == "off":
        rules = replace(rules, itself=False)
    elif collision is not None or obstacles:
        with at("collision"):
            asked = _rules(collision or CollisionFile(), cell.robot)
            rules = replace(asked, floor=rules.floor)
    if floor is not None:
        rules = replace(rules, floor=None if floor == "off" else floor.z_mm)
    elif any(obstacle.name.casefold() == FLOOR for obstacle in obstacles):
        rules = replace(rules, floor=None)
    try:
        return clearances(cell.robot, cell.tool, cell.limits, obstacles, rules)
    except InputError as error:
        raise LocatedError(_place(error.doubts, obstacles), str(error)) from None


def _place(doubts: Sequence[Doubt], obstacles: Sequence[Shape]) -> Path_:
    """The key that an error of the whole cell is about."""
    named = {name for doubt in doubts for name in doubt.about}
    for i, obstacle in enumerate(obstacles):
        if obstacle.name in named:
            return ("obstacles", i)
    unknown = any(doubt.code == "unknown-name" for doubt in doubts)
    return ("collision", "ignore") if unknown else ("obstacles",)


def _rules(entry: CollisionFile, robot: Robot) -> CollisionRules:
    margin, motion, radius = entry.margin_mm, entry.motion_margin_mm, entry.link_radius_mm
    for key, value in (("margin_mm", margin), ("motion_margin_mm", motion)):
        if value is not None and value < 0.0:
            raise LocatedError((key,), f"{key} must not be negative, found {mm(value)}")
    moving = margin / 2.0 if motion is None else motion
    if margin - moving < _ROOM_TO_LEAVE - _ROUNDING:
        raise LocatedError(
            ("margin_mm" if motion is None else "motion_margin_mm",),
            f"motions must keep at least {mm(_ROOM_TO_LEAVE)} mm less than poses, so that a pose "
            f"at its margin can be left; found motion_margin_mm {mm(moving)}, margin_mm "
            f"{mm(margin)}",
        )
    if radius is not None and robot.collisions:
        raise LocatedError(
            ("link_radius_mm",),
            f"link_radius_mm: robot {robot.name!r} has shapes of its own; the capsules this is "
            "the radius of are for robots without",
        )
    for name in radius if isinstance(radius, dict) else ():
        if name not in (*robot.joint_names, "base"):
            raise LocatedError(
                ("link_radius_mm", name),
                f"no joint {name!r}; there are base, {', '.join(robot.joint_names)}",
            )
    return CollisionRules(
        margin=margin,
        motion_margin=motion,
        itself=entry.self,
        ignore=tuple((a, b) for a, b in entry.ignore or []),
        as_capsules=entry.links == "capsules",
        link_radius=radius,
    )


def _obstacle(entry: ObstacleFile, folder: Path) -> Shape:
    """One obstacle in the base frame."""
    given = [key for key in _SHAPES if getattr(entry, key) is not None]
    if len(given) != 1:
        raise InputError(
            f"obstacle {entry.name!r} needs exactly one of {', '.join(_SHAPES)}, found "
            f"{' and '.join(given) or 'none'}"
        )
    if entry.mesh_unit is not None and entry.mesh is None:
        raise LocatedError(("mesh_unit",), "mesh_unit is for a mesh")
    if entry.center_mm is None and entry.mesh is None:
        raise InputError(f"obstacle {entry.name!r}: key 'center_mm' is missing")
    # Roll about x, then pitch about y, then yaw about z, axes fixed.
    roll, pitch, yaw = entry.rpy_deg or [0.0] * 3
    rotation = from_zyx_angles(np.array([[yaw, pitch, roll]]))[0]
    pose = transform(rotation, entry.center_mm or [0.0] * 3)
    if entry.mesh is not None:
        says_it = Path(entry.mesh).suffix.lower() == ".dae"
        if says_it and entry.mesh_unit is not None:
            raise LocatedError(
                ("mesh_unit",), "a COLLADA file (.dae) says its unit itself; leave mesh_unit out"
            )
        if entry.mesh_unit is None and not says_it:
            raise InputError(
                f"obstacle {entry.name!r}: say the unit of its mesh with mesh_unit: mm, m or inch"
            )
        file = _inside(folder, entry.mesh)
        scale = np.full(3, 1.0 if entry.mesh_unit is None else _UNITS[entry.mesh_unit])
        return Shape("mesh", scale, pose, 0, entry.name, file, entry.mesh)
    kind, size = given[0].split("_")[0], [entry.sphere_radius_mm or 0.0]
    if entry.box_mm is not None:
        size = entry.box_mm
        if min(size) <= 0.0:
            raise LocatedError(
                ("box_mm",),
                f"box_mm of {entry.name!r}: the three sides must be positive, found "
                f"{', '.join(mm(side) for side in size)}",
            )
    tube = entry.cylinder_mm or entry.capsule_mm
    if tube is not None:
        size = [tube.radius, tube.length]
    return Shape(kind, np.array(size), pose, 0, entry.name)


def _inside(folder: Path, name: str) -> Path:
    """A file that the study names, in its own folder or below."""
    with at("mesh"):
        try:
            inside = (folder / name).resolve().is_relative_to(folder.resolve())
        except (OSError, ValueError, RuntimeError):
            raise InputError(f"mesh {name[:80]!r} is not the name of a file") from None
        if not inside:
            raise InputError(f"mesh {name!r} is outside the folder of the study; copy it there")
    return folder / name
