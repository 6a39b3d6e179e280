"""Experiments of a study: tool, loads, how many."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np

from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, InPlane, Load
from elastocal.errors import InputError
from elastocal.files.sections import Section, Told, Variant
from elastocal.files.study.tools import find_tool
from elastocal.files.values import (
    Count,
    Name,
    Positive,
    PositiveDegrees,
    PositiveMicrometres,
    Vector,
    deg,
)
from elastocal.files.yaml_lines import LocatedError, at
from elastocal.robot.chain import Tool
from elastocal.study.robustness import Robustness
from elastocal.study.study import Experiments


class ConeFile(Section):
    """Directions within an angle of an axis."""

    axis: Vector
    half_angle_deg: PositiveDegrees


class PlaneFile(Section):
    """Directions in a plane."""

    plane: Vector


def _form(value: Any) -> str:
    if not isinstance(value, dict):
        return "anywhere"
    return "in a plane" if "plane" in value else "in a cone"


Direction = Annotated[
    Annotated[Literal["free"], Variant("anywhere")]
    | Annotated[ConeFile, Variant("in a cone")]
    | Annotated[PlaneFile, Variant("in a plane")],
    Told(_form),
]


class RobustFile(Section):
    """What a plan is to withstand."""

    loss: Positive | None = None
    blind_um: PositiveMicrometres | None = None
    within: Positive | None = None


Robust = Annotated[
    Annotated[Positive, Variant("a number")] | Annotated[RobustFile, Variant("limits")],
    Told(lambda value: "limits" if isinstance(value, dict) else "a number"),
]


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
    robust: Robust | None = None


def experiments_of(entry: ExperimentsFile, tools: Mapping[str, Tool]) -> Experiments:
    """What is done, with the loads that may be chosen."""
    force = _load(entry, "force_N", "max_force_N", "direction")
    moment = _load(entry, "torque_Nm", "max_torque_Nm", "torque_direction")
    if force is None and moment is None:
        raise InputError(
            "experiments say nothing of the load: give force_N, or max_force_N with direction"
        )
    none = FixedVector(np.zeros(3))
    if entry.max_configurations is not None and entry.max_configurations > entry.count:
        raise LocatedError(
            ("max_configurations",),
            f"max_configurations {entry.max_configurations} "
            f"is more than the {entry.count} experiments",
        )
    distinct = entry.max_configurations or entry.count
    if entry.robust is not None and distinct < 2:
        raise LocatedError(("robust",), "robust needs at least two configurations, found 1")
    return Experiments(
        find_tool(tools, entry.tool),
        force or none,
        entry.count,
        entry.max_configurations,
        moment or none,
        None if entry.robust is None else _robustness(entry.robust),
    )


def _robustness(entry: float | RobustFile) -> Robustness:
    """What a plan is to withstand; a number limits what is left without any one configuration."""
    with at("robust"):
        if not isinstance(entry, RobustFile):
            return Robustness(loss=entry)
        return Robustness(entry.loss, entry.blind_um, entry.within)


def _load(
    entry: ExperimentsFile, fixed_key: str, bound_key: str, direction_key: str
) -> Load | None:
    """A fixed or free load from its keys; None if none is given."""
    fixed, bound, direction = (getattr(entry, k) for k in (fixed_key, bound_key, direction_key))
    if fixed is not None and (bound is not None or direction is not None):
        other = bound_key if bound is not None else direction_key
        raise LocatedError((other,), f"give either {fixed_key} or {bound_key} with {direction_key}")
    if fixed is not None:
        return FixedVector(np.array(fixed))
    if bound is None and direction is not None:
        raise LocatedError((direction_key,), f"{direction_key} needs {bound_key}")
    if bound is None:
        return None
    if direction is None:
        raise LocatedError(
            (bound_key,),
            f"{bound_key} needs {direction_key}: 'free', axis and half_angle_deg, or plane",
        )
    if isinstance(direction, str):
        return FreeDirection(bound, np.array([0.0, 0.0, -1.0]))
    with at(direction_key):
        if isinstance(direction, PlaneFile):
            return InPlane(bound, np.array(direction.plane))
        if not np.radians(0.1) <= direction.half_angle_deg <= np.radians(180.0):
            raise InputError(
                f"half_angle_deg must be from 0.1 to 180, found {deg(direction.half_angle_deg)}; "
                "a narrower cone is a fixed direction"
            )
        return FreeDirection(bound, np.array(direction.axis), direction.half_angle_deg)
