"""Tools of a study: points in the flange frame."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from elastocal.errors import InputError
from elastocal.files.sections import Section
from elastocal.files.values import (
    Axis,
    MillimetreVector,
    Name,
    OneOrByName,
    PositiveDegrees,
    PositiveMillimetres,
)
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Tool


class ToolFile(Section):
    """Points of a tool in the flange frame."""

    tcp_mm: MillimetreVector | None = None
    load_point_mm: MillimetreVector | None = None
    markers_mm: dict[Name, MillimetreVector] | None = None
    marker_axes: dict[Name, Axis] | None = None
    acceptance_deg: OneOrByName[PositiveDegrees] | None = None
    radius_mm: PositiveMillimetres = 30.0


def tool_of(name: str, entry: ToolFile) -> Tool:
    """A tool from its points."""
    load_point = entry.load_point_mm or entry.tcp_mm
    if load_point is None:
        raise InputError(f"tool {name!r} has neither tcp_mm nor load_point_mm; give one of them")
    if entry.markers_mm is not None and not entry.markers_mm:
        raise LocatedError(("markers_mm",), f"tool {name!r}: markers_mm is empty")
    default = "TCP" if entry.tcp_mm is not None else "load point"
    tcp = entry.tcp_mm or load_point
    markers = entry.markers_mm or {default: tcp}
    return Tool(
        name,
        np.array(load_point),
        np.array(list(markers.values())),
        tuple(markers),
        np.array(tcp),
        entry.radius_mm,
    )


def find_tool(tools: Mapping[str, Tool], name: str) -> Tool:
    """The tool called `name`."""
    if name not in tools:
        known = ", ".join(tools) or "none"
        raise LocatedError(("tool",), f"tool {name!r} is not defined; defined are: {known}")
    return tools[name]
