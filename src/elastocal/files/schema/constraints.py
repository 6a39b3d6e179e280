"""Constraints."""

from __future__ import annotations

from typing import Literal

from elastocal.files.schema.values import (
    Axis,
    Flag,
    Name,
    NamePair,
    Number,
    Positive,
    Range,
    Section,
    Vector,
)


class BoxFile(Section):
    """A box in the base frame."""

    min: Vector
    max: Vector


class WorkspaceFile(Section):
    """Where the points of the tool may be."""

    min_z_mm: Number | None = None
    max_z_mm: Number | None = None
    min_radius_mm: Positive | None = None
    box_mm: BoxFile | None = None


class ElevationFile(Section):
    """Angle of a flange axis over the horizontal."""

    axis: Axis
    max_deg: Positive


class TiltFile(Section):
    """Angle between a flange axis and a direction of the base frame."""

    axis: Axis
    towards: Axis
    max_deg: Positive


class CylinderFile(Section):
    """A cylinder or capsule along its z axis; the length of a capsule is without its caps."""

    radius: Positive
    length: Positive


class ObstacleFile(Section):
    """Something that stands in the cell: one of five shapes, and where it is."""

    name: Name
    box_mm: Vector | None = None
    cylinder_mm: CylinderFile | None = None
    capsule_mm: CylinderFile | None = None
    sphere_radius_mm: Positive | None = None
    mesh: Name | None = None
    mesh_unit: Literal["mm", "m", "inch"] | None = None
    center_mm: Vector | None = None
    rpy_deg: Vector | None = None


class CollisionFile(Section):
    """What counts as a collision."""

    margin_mm: Number = 20.0
    motion_margin_mm: Number | None = None
    self: Flag = True
    ignore: list[NamePair] | None = None
    links: Literal["hulls", "capsules"] = "hulls"
    link_radius_mm: Positive | dict[Name, Positive] | None = None


class ConstraintsFile(Section):
    """Where the robot may go."""

    joint_limits_deg: dict[Name, Range] | None = None
    joint_limits_mm: dict[Name, Range] | None = None
    joint_margin_deg: Number = 0.0
    joint_margin_mm: Number = 0.0
    workspace: WorkspaceFile | None = None
    elevation: ElevationFile | None = None
    tilt: TiltFile | None = None
    obstacles: list[ObstacleFile] | None = None
    collision: CollisionFile | None = None
