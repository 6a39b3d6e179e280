"""Load cases as entries of a file: degrees, millimetres, newtons, joints by name."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Annotated, Any, TypeVar

import numpy as np

from elastocal.arrays import Array, unset
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError, PlanFileError
from elastocal.files.sections import (
    NOTHING,
    After,
    Before,
    PartSection,
    Section,
    SectionError,
    fresh,
)
from elastocal.files.study.joint_values import configuration
from elastocal.files.tables.numbers import LARGEST
from elastocal.files.texts import text_hash
from elastocal.robot.chain import Robot


def finite(value: Any, largest: float = LARGEST) -> float:
    """A number below `largest`; other values raise what is said behind the name of their key."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or not abs(value) < largest:
        raise ValueError(f": expected a finite number, found {repr(value)[:40]}")
    return float(value)


def _three(value: Any) -> list[float]:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(f": expected three numbers [x, y, z], found {value!r}")
    return [finite(entry) for entry in value]


def _by_name(value: Any) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError(" must give values by joint name")
    return value


Finite = Annotated[float, Before(lambda value: finite(value))]
_Degrees = Annotated[Finite, After(math.radians)]
_Millimetres = Annotated[Finite, After(lambda value: value / 1e3)]
_Three = Annotated[list[float], Before(_three)]


class ConfigurationFile(PartSection):
    """A configuration of a plan; what else stands there is not read here."""

    q_deg: Annotated[dict[str, _Degrees], Before(_by_name)] = fresh(dict)
    q_mm: Annotated[dict[str, _Millimetres], Before(_by_name)] = fresh(dict)


class WrenchFile(PartSection):
    """The load of a load case, and what acted before it already."""

    force_N: _Three = NOTHING
    torque_Nm: _Three = fresh(lambda: [0.0, 0.0, 0.0])
    preload_N: _Three = fresh(lambda: [0.0, 0.0, 0.0])
    preload_Nm: _Three = fresh(lambda: [0.0, 0.0, 0.0])


_Section = TypeVar("_Section", bound=Section)


def section_at(model: type[_Section], entry: Any, where: str) -> _Section:
    """The entry of a plan file as a section.

    Raises:
        PlanFileError: the first key that is wrong.
    """
    if not isinstance(entry, dict):
        raise PlanFileError(f"{where}: expected a section of keys")
    try:
        return model.of(entry)
    except SectionError as error:
        first = error.problems[0]
        key = " of ".join(map(str, first.place))
        raise PlanFileError(f"{where}: {key}{first.said}") from None


def load_case_entries(robot: Robot, cases: LoadCases) -> Iterator[dict[str, Any]]:
    """One entry for each load case."""
    loads = zip(cases.wrench.tolist(), cases.first.tolist(), strict=True)
    for entry, (wrench, before) in zip(_configurations(robot, cases.q), loads, strict=True):
        entry["force_N"], entry["torque_Nm"] = wrench[:3], wrench[3:]
        if cases.preloaded:
            entry["preload_N"], entry["preload_Nm"] = before[:3], before[3:]
        yield entry


def configuration_entry(robot: Robot, q: Array) -> dict[str, Any]:
    """The keys q_deg, and q_mm if a joint slides, of a configuration (n,)."""
    return next(_configurations(robot, q[None]))


def _configurations(robot: Robot, q: Array) -> Iterator[dict[str, Any]]:
    """The same of many, (N, n)."""
    kinds = [joint.kind for joint in robot.joints]
    columns = [(f"q_{k.key}", j.name) for k, j in zip(kinds, robot.joints, strict=True)]
    for row in (q * [kind.scale for kind in kinds]).tolist():
        entry: dict[str, Any] = {"q_deg": {}}
        for (key, name), value in zip(columns, row, strict=True):
            entry.setdefault(key, {})[name] = value
        yield entry


def load_cases_hash(entries: Any, via: Any) -> str:
    """SHA-256 of what a plan tells the robot: values by joint, loads, repeats, via points.

    Args:
        entries: The load cases, as they stand in the file.
        via: The via points, likewise.
    """
    keys = ("q_deg", "q_mm", "force_N", "torque_Nm", "repeats", "to")
    told = [[{key: part.get(key) for key in keys} for part in group] for group in (entries, via)]
    return text_hash(json.dumps(_plain(told), sort_keys=True))


def _plain(value: Any) -> Any:
    """The same document with every number as a decimal: programs write 1 and 1.0 as they like."""
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    return float(value) if isinstance(value, int) else value


def read_load_cases(entries: Any, robot: Robot, where: str) -> LoadCases:
    """Load cases from the entries of a file.

    Raises:
        PlanFileError: an entry is wrong; names it and its key.
    """
    if not isinstance(entries, list) or not entries:
        raise PlanFileError(f"{where} must be a list with at least one load case")
    q = np.zeros((len(entries), len(robot.joints)))
    wrench, before = np.zeros((2, len(entries), 6))
    for i, entry in enumerate(entries):
        here = f"{where}, load case {i + 1}"
        q[i] = configuration_at(section_at(ConfigurationFile, entry, here), robot, here)
        load = section_at(WrenchFile, entry, here)
        wrench[i] = load.force_N + load.torque_Nm
        before[i] = load.preload_N + load.preload_Nm
    return LoadCases(q, wrench, before if before.any() else unset())


def configuration_at(section: ConfigurationFile, robot: Robot, where: str) -> Array:
    """(n,) configuration of a section with q_deg, and q_mm for joints that slide."""
    try:
        return configuration(robot, section)
    except InputError as error:
        raise PlanFileError(f"{where}: {error}") from None


def finite_at(value: Any, where: str) -> float:
    """A finite number of ordinary size."""
    try:
        return finite(value)
    except ValueError as error:
        raise PlanFileError(f"{where}{error}") from None


def columns(robot: Robot) -> list[str]:
    """Header of a table of load cases."""
    joints = [f"{j.name} [{j.kind.key}]" for j in robot.joints]
    forces = [f"F{axis} [N]" for axis in "xyz"] + [f"T{axis} [N.m]" for axis in "xyz"]
    return ["configuration", *joints, *forces]
