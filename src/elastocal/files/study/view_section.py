"""What the tracker of a study must see, as constraints in SI units.

The keys stand in two places: the limits of the tracker under `instrument`, the axes of the
reflectors under `tools`. Every marker of the calibration tool must be seen.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import (
    AcceptanceCone,
    BeamRange,
    Clearance,
    Constraint,
    HeadAzimuth,
    HeadElevation,
    LineOfSight,
)
from elastocal.constraints.collision.chain import robot_solids
from elastocal.constraints.collision.solid import Solid
from elastocal.files.schema import ToolFile, TrackerFile
from elastocal.files.yaml_lines import LocatedError
from elastocal.robot.chain import Robot, Tool

ACCEPTANCE_DEG = 30.0
"""Half the opening of a reflector's acceptance cone, if nothing is said [°]."""


def view_of(
    robot: Robot,
    tool: Tool,
    reflectors: ToolFile | None,
    tracker: TrackerFile | None,
    others: Sequence[Constraint],
) -> tuple[Constraint, ...]:
    """Constraints for every marker of the calibration tool; none without a tracker.

    Errors have the path from the top of the file: `tools` or `instrument`.

    Args:
        robot: The robot.
        tool: The calibration tool.
        reflectors: Its section of the study file, None if the robot brought it.
        tracker: The section on the tracker, None if there is none.
        others: The other constraints; solids of clearances may stand in the beam.
    """
    axes = _axes(tool, reflectors, tracker is not None)
    if tracker is None:
        return ()
    position = np.array(tracker.position_mm) / 1e3
    found: list[Constraint] = []
    solids = _solids(robot, others) if tracker.line_of_sight else []
    for name, point in zip(tool.marker_names, tool.markers, strict=True):
        found += _limits(tracker, name, point, position)
        if name in axes:
            axis, limit = axes[name]
            label = f"acceptance of {name} <= {limit:g}°"
            found.append(
                AcceptanceCone(label, name, point, position, axis, float(np.radians(limit)))
            )
        if solids:
            found.append(
                LineOfSight(
                    f"line of sight to {name}",
                    name,
                    point,
                    position,
                    solids,
                    robot,
                    radius=tracker.beam_radius_mm / 1e3,
                )
            )
    return tuple(found)


def _solids(robot: Robot, others: Sequence[Constraint]) -> list[Solid]:
    """Parts of robot, tool and cell: those of the clearances, else the robot alone."""
    known = {id(s): s for c in others if isinstance(c, Clearance) for s in c.pairs.solids}
    return list(known.values()) or robot_solids(robot)


def _axes(tool: Tool, entry: ToolFile | None, tracked: bool) -> dict[str, tuple[Array, float]]:
    """Viewing axis in the flange frame and half angle [°] of the markers that have one."""
    if entry is None:
        return {}
    given, openings = entry.marker_axes, entry.acceptance_deg
    for key, value in (("marker_axes", given), ("acceptance_deg", openings)):
        path = ("tools", tool.name, key)
        if value is not None and not tracked:
            raise LocatedError(path, f"{key} needs a tracker that looks at the markers")
        for name in value if isinstance(value, dict) else ():
            if name not in tool.marker_names:
                raise LocatedError(
                    (*path, name),
                    f"{key}: no marker {name!r}; the markers are {', '.join(tool.marker_names)}",
                )
    if openings is not None and given is None:
        raise LocatedError(
            ("tools", tool.name, "acceptance_deg"), "acceptance_deg needs marker_axes"
        )
    found = {}
    for name, axis in (given or {}).items():
        limit = openings.get(name) if isinstance(openings, dict) else openings
        limit = ACCEPTANCE_DEG if limit is None else limit
        if not 1.0 <= limit <= 180.0:
            raise LocatedError(
                ("tools", tool.name, "acceptance_deg"),
                f"acceptance_deg of {name!r} must be from 1 to 180, found {limit:g}",
            )
        vector = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.array(axis)
        if not vector.any():
            raise LocatedError(
                ("tools", tool.name, "marker_axes", name), f"the axis of {name!r} must not be zero"
            )
        found[name] = vector, float(limit)
    return found


def _limits(tracker: TrackerFile, name: str, point: Array, position: Array) -> list[Constraint]:
    """Range, elevation and azimuth of the beam to one marker."""
    found: list[Constraint] = []
    if tracker.range_mm is not None:
        low, high = _ordered(tracker, "range_mm", 0.0, np.inf)
        for bound, upper, sign in ((low, False, ">="), (high, True, "<=")):
            if bound > 0.0:
                label = f"range of {name} {sign} {bound:g} mm"
                found.append(BeamRange(label, name, point, position, bound / 1e3, upper=upper))
    if tracker.elevation_deg is not None:
        low, high = _ordered(tracker, "elevation_deg", -90.0, 90.0)
        for bound, upper, sign in ((low, False, ">="), (high, True, "<=")):
            if abs(bound) < 90.0:
                label = f"elevation of the beam to {name} {sign} {bound:g}°"
                angle = float(np.radians(bound))
                found.append(HeadElevation(label, name, point, position, angle, upper=upper))
    if tracker.azimuth_deg is not None:
        low, high = _ordered(tracker, "azimuth_deg", -360.0, 360.0)
        if high - low > 360.0:
            raise LocatedError(
                ("instrument", "tracker", "azimuth_deg"),
                f"azimuth_deg covers {high - low:g}°, more than a whole turn",
            )
        label = f"azimuth of the beam to {name} in {low:g}° to {high:g}°"
        angles = np.radians([low, high])
        found.append(HeadAzimuth(label, name, point, position, float(angles[0]), float(angles[1])))
    return found


def _ordered(tracker: TrackerFile, key: str, least: float, most: float) -> tuple[float, float]:
    low, high = getattr(tracker, key)
    if not low < high:
        raise LocatedError(
            ("instrument", "tracker", key),
            f"{key}: the lower limit {low:g} must be below the upper one, {high:g}",
        )
    if low < least or high > most:
        wanted = (
            f"must be from {least:g} to {most:g}" if np.isfinite(most) else "must not be negative"
        )
        raise LocatedError(
            ("instrument", "tracker", key), f"{key} {wanted}, found {low:g} to {high:g}"
        )
    return low, high
