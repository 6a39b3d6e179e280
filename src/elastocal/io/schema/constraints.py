"""Constraints."""

from __future__ import annotations

from elastocal.io.schema.values import Axis, Name, Number, Positive, Range, Section, Vector


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


class ConstraintsFile(Section):
    """Where the robot may go."""

    joint_limits_deg: dict[Name, Range] | None = None
    joint_limits_mm: dict[Name, Range] | None = None
    joint_margin_deg: Number = 0.0
    joint_margin_mm: Number = 0.0
    workspace: WorkspaceFile | None = None
    elevation: ElevationFile | None = None
    tilt: TiltFile | None = None
