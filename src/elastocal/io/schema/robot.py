"""Robot and tools."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from elastocal.io.schema.values import Name, Number, Range, Section, Vector


class DHRowFile(Section):
    """One row of a DH table."""

    joint: Name
    theta_deg: Number = 0.0
    d_mm: Number = 0.0
    a_mm: Number = 0.0
    alpha_deg: Number = 0.0
    type: Literal["revolute", "prismatic"] = "revolute"
    sign: Literal[1, -1] = 1
    limits_deg: Range | None = None
    limits_mm: Range | None = None


class DHRobotFile(Section):
    """A robot given by its table."""

    name: Name = "robot"
    convention: Literal["modified", "classic"]
    dh: list[DHRowFile]


class ToolFile(Section):
    """Points of a tool in the flange frame."""

    tcp_mm: Vector | None = None
    load_point_mm: Vector | None = None
    markers_mm: dict[Name, Vector] | None = None


class SpringFile(Section):
    """A spring of a link or of the base."""

    carried_by: Name
    type: Literal["revolute", "prismatic"] = "revolute"
    axis: Vector
    origin_mm: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])
