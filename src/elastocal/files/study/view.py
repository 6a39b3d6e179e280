"""What the tracker of a study must see, as constraints.

The keys stand in two places: the limits of the tracker under `instrument`, the axes of the
reflectors under `tools`. Every marker of the calibration tool must be seen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

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
from elastocal.constraints.collision.chain import robot_solids, solids_at_hand
from elastocal.constraints.collision.solid import Solid
from elastocal.errors import InputError
from elastocal.files.study.instrument import TrackerFile
from elastocal.files.study.tools import ToolFile
from elastocal.files.values import deg, mm
from elastocal.files.yaml_lines import LocatedError, at
from elastocal.robot.chain import Robot, Tool

_QUARTER = float(np.radians(90.0))  # of a turn
_ACCEPTANCE = float(np.radians(30.0))  # half opening of a reflector's cone if nothing is said


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
    with at("tools", tool.name):
        axes = _axes(tool, reflectors, tracker is not None)
    if tracker is None:
        return ()
    position = np.array(tracker.position_mm)
    found: list[Constraint] = []
    solids = _solids(robot, others) if tracker.line_of_sight else []
    with at("instrument"):
        for name, point in zip(tool.marker_names, tool.markers, strict=True):
            with at("tracker"):
                found += _limits(tracker, name, point, position)
            if name in axes:
                axis, limit = axes[name]
                label = f"acceptance of {name} <= {deg(limit)}°"
                found.append(AcceptanceCone(label, name, point, position, axis, limit))
            if solids:
                label, radius = f"line of sight to {name}", tracker.beam_radius_mm
                sight = LineOfSight(label, name, point, position, solids, robot, radius=radius)
                found.append(sight)
    return tuple(found)


def _solids(robot: Robot, others: Sequence[Constraint]) -> list[Solid]:
    """Parts of robot, tool and cell: those of the clearances, else the robot alone.

    The floor is under the beam; what another solid covers hides nothing more.
    """
    all_ = [s for c in others if isinstance(c, Clearance) for s in c.pairs.solids]
    known = {id(s): s for s in all_ if s.kind != "plane" and not s.covered}
    if known:
        return list(known.values())
    try:
        return robot_solids(robot)
    except InputError:
        shaped, along, *_ = solids_at_hand(robot)
        return [*shaped, *along]


def _axes(tool: Tool, entry: ToolFile | None, tracked: bool) -> dict[str, tuple[Array, float]]:
    """Viewing axis in the flange frame and half angle [rad] of the markers that have one."""
    if entry is None:
        return {}
    given, openings = entry.marker_axes, entry.acceptance_deg
    for key, value in (("marker_axes", given), ("acceptance_deg", openings)):
        if value is not None and not tracked:
            raise LocatedError((key,), f"{key} needs a tracker that looks at the markers")
        for name in value if isinstance(value, dict) else ():
            if name not in tool.marker_names:
                raise LocatedError(
                    (key, name),
                    f"{key}: no marker {name!r}; the markers are {', '.join(tool.marker_names)}",
                )
    if openings is not None and given is None:
        raise LocatedError(("acceptance_deg",), "acceptance_deg needs marker_axes")
    found = {}
    for name, axis in (given or {}).items():
        limit = openings.get(name) if isinstance(openings, dict) else openings
        limit = _ACCEPTANCE if limit is None else limit
        if not np.radians(1.0) <= limit <= np.radians(180.0):
            raise LocatedError(
                ("acceptance_deg",),
                f"acceptance_deg of {name!r} must be from 1 to 180, found {deg(limit)}",
            )
        vector = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.array(axis)
        if not vector.any():
            raise LocatedError(("marker_axes", name), f"the axis of {name!r} must not be zero")
        found[name] = vector, limit
    return found


def _limits(tracker: TrackerFile, name: str, point: Array, position: Array) -> list[Constraint]:
    """Range, elevation and azimuth of the beam to one marker."""
    found: list[Constraint] = []
    if tracker.range_mm is not None:
        low, high = _ordered("range_mm", tracker.range_mm, 0.0, np.inf, mm)
        for bound, upper, sign in ((low, False, ">="), (high, True, "<=")):
            if bound > 0.0:
                label = f"range of {name} {sign} {mm(bound)} mm"
                found.append(BeamRange(label, name, point, position, bound, upper=upper))
    if tracker.elevation_deg is not None:
        low, high = _ordered("elevation_deg", tracker.elevation_deg, -_QUARTER, _QUARTER, deg)
        for bound, upper, sign in ((low, False, ">="), (high, True, "<=")):
            if abs(bound) < _QUARTER:
                label = f"elevation of the beam to {name} {sign} {deg(bound)}°"
                found.append(HeadElevation(label, name, point, position, bound, upper=upper))
    if tracker.azimuth_deg is not None:
        low, high = _ordered(
            "azimuth_deg", tracker.azimuth_deg, -4.0 * _QUARTER, 4.0 * _QUARTER, deg
        )
        if high - low > 4.0 * _QUARTER + 1e-9:
            raise LocatedError(
                ("azimuth_deg",), f"azimuth_deg covers {deg(high - low)}°, more than a whole turn"
            )
        label = f"azimuth of the beam to {name} in {deg(low)}° to {deg(high)}°"
        found.append(HeadAzimuth(label, name, point, position, low, high))
    return found


def _ordered(
    key: str, limits: list[float], least: float, most: float, shown: Callable[[float], str]
) -> tuple[float, float]:
    low, high = limits
    with at(key):
        if not low < high:
            raise InputError(
                f"{key}: the lower limit {shown(low)} must be below the upper one, {shown(high)}"
            )
        if low < least or high > most:
            wanted = f"must be from {shown(least)} to {shown(most)}"
            wanted = wanted if np.isfinite(most) else "must not be negative"
            raise InputError(f"{key} {wanted}, found {shown(low)} to {shown(high)}")
    return low, high
