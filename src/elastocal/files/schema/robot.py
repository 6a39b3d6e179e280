"""Robot, tools and controller."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from elastocal.files.schema.values import Axis, Name, Number, Positive, Range, Section, Vector


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
    mass_kg: Positive | None = None
    center_mm: Vector | None = None


class DHRobotFile(Section):
    """A robot given by its table."""

    name: Name = "robot"
    convention: Literal["modified", "classic"]
    dh: list[DHRowFile]


class UrdfRobotFile(Section):
    """A robot given by a URDF or xacro file."""

    urdf: Name
    base: Name | None = None
    tip: Name | None = None
    packages: dict[Name, Name] = Field(default_factory=dict)
    limits_deg: dict[Name, Range] = Field(default_factory=dict)
    limits_mm: dict[Name, Range] = Field(default_factory=dict)


def _form(value: Any) -> str:
    """Which form a robot has: told by its keys, so that errors speak of one form only."""
    if not isinstance(value, dict):
        return "by name"
    return "by file" if "urdf" in value else "by table"


RobotFile = Annotated[
    Annotated[Name, Tag("by name")]
    | Annotated[DHRobotFile, Tag("by table")]
    | Annotated[UrdfRobotFile, Tag("by file")],
    Discriminator(_form),
]


class ToolFile(Section):
    """Points of a tool in the flange frame."""

    tcp_mm: Vector | None = None
    load_point_mm: Vector | None = None
    markers_mm: dict[Name, Vector] | None = None
    marker_axes: dict[Name, Axis] | None = None
    acceptance_deg: Positive | dict[Name, Positive] | None = None
    radius_mm: Positive = 30.0


class SpringFile(Section):
    """A spring of a link or of the base."""

    carried_by: Name
    type: Literal["revolute", "prismatic"] = "revolute"
    axis: Vector
    origin_mm: Vector = Field(default_factory=lambda: [0.0, 0.0, 0.0])


class ControllerFile(Section):
    """How the joint values of the controller follow from those of the model."""

    preset: Name | None = None
    signs: dict[Name, Literal[1, -1]] = Field(default_factory=dict)
    offsets_deg: dict[Name, Number] = Field(default_factory=dict)
    offsets_mm: dict[Name, Number] = Field(default_factory=dict)
    couple: dict[Name, dict[Name, Number]] = Field(default_factory=dict)


class CheckPoseFile(Section):
    """A pose read off at the robot, in joint values of the controller."""

    name: Name | None = None
    q_deg: dict[Name, Number] | list[Number] | None = None
    q_mm: dict[Name, Number] | None = None
    flange_mm: Vector | None = None
    tcp_mm: Vector | None = None
    tool: Name | None = None
