"""Test poses, experiments, instrument, prior."""

from __future__ import annotations

from typing import Literal

from elastocal.files.schema.values import (
    Count,
    Flag,
    Name,
    Number,
    Positive,
    Range,
    Section,
    Vector,
)


class TestPoseFile(Section):
    """A test pose: a load case with its tool, or the matrix A0."""

    __test__ = False

    name: Name | None = None
    tool: Name | None = None
    q_deg: dict[Name, Number] | list[Number] | None = None
    q_mm: dict[Name, Number] | None = None
    force_N: Vector | None = None
    torque_Nm: Vector | None = None
    regressor_Nm2: list[list[Number]] | None = None
    weight: Positive = 1.0


class ConeFile(Section):
    """Directions within an angle of an axis."""

    axis: Vector
    half_angle_deg: Positive


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


class TrackerFile(Section):
    """A laser tracker: where it stands, and its noise, one reading, one standard deviation."""

    position_mm: Vector
    preset: Name | None = None
    along_um: Positive | None = None
    along_um_per_m: Number | None = None
    across_um: Positive | None = None
    across_um_per_m: Number | None = None
    range_mm: Range | None = None
    elevation_deg: Range | None = None
    azimuth_deg: Range | None = None
    line_of_sight: Flag = True
    beam_radius_mm: Positive = 10.0


class InstrumentFile(Section):
    """How well a coordinate is measured."""

    sigma_mm: Positive | None = None
    tracker: TrackerFile | None = None


class PriorFile(Section):
    """What is known before: one of three ways to say it."""

    plan: Name | None = None
    standard_error_rad_per_Nm: dict[Name, Positive] | None = None
    information_N2m2: list[list[Number]] | None = None
