"""Load cases as entries of a file: degrees, millimetres, newtons, joints by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError, PlanFileError
from elastocal.files.study.joint_values import configuration
from elastocal.files.values import Section
from elastocal.robot.chain import Robot

LARGEST = 1e9
"""Numbers beyond this are mistakes in any unit of these files."""


class _Joints(Section):
    q_deg: dict[str, float]
    q_mm: dict[str, float]


def load_case_entries(robot: Robot, cases: LoadCases) -> Iterator[dict[str, Any]]:
    """One entry for each load case."""
    for q, wrench in zip(cases.q, cases.wrench, strict=True):
        entry = configuration_entry(robot, q)
        entry["force_N"] = [float(v) for v in wrench[:3]]
        entry["torque_Nm"] = [float(v) for v in wrench[3:]]
        yield entry


def configuration_entry(robot: Robot, q: Array) -> dict[str, Any]:
    """The keys q_deg, and q_mm if a joint slides, of a configuration (n,)."""
    entry: dict[str, Any] = {"q_deg": {}}
    for joint, value in zip(robot.joints, q.tolist(), strict=True):
        entry.setdefault(f"q_{joint.kind.key}", {})[joint.name] = joint.kind.scale * value
    return entry


def read_load_cases(entries: Any, robot: Robot, where: str) -> LoadCases:
    """Load cases from the entries of a file.

    Raises:
        PlanFileError: an entry is wrong; names it and its key.
    """
    if not isinstance(entries, list) or not entries:
        raise PlanFileError(f"{where} must be a list with at least one load case")
    q = np.zeros((len(entries), len(robot.joints)))
    wrench = np.zeros((len(entries), 6))
    for i, entry in enumerate(entries):
        here = f"{where}, load case {i + 1}"
        if not isinstance(entry, dict):
            raise PlanFileError(f"{here}: expected a section of keys")
        q[i] = configuration_at(entry, robot, here)
        wrench[i, :3] = _vector(entry.get("force_N"), f"{here}: force_N")
        wrench[i, 3:] = _vector(entry.get("torque_Nm", [0, 0, 0]), f"{here}: torque_Nm")
    return LoadCases(q, wrench)


def configuration_at(entry: dict[str, Any], robot: Robot, where: str) -> Array:
    """(n,) configuration of an entry with q_deg, and q_mm for joints that slide."""
    values = {}
    for key in ("q_deg", "q_mm"):
        section = entry.get(key, {})
        if not isinstance(section, dict):
            raise PlanFileError(f"{where}: {key} must give values by joint name")
        values[key] = {k: finite_at(v, f"{where}: {key} of {k}") for k, v in section.items()}
    try:
        section = _Joints.model_construct(
            q_deg={k: float(np.radians(v)) for k, v in values["q_deg"].items()},
            q_mm={k: v / 1e3 for k, v in values["q_mm"].items()},
        )
        return configuration(robot, section)
    except InputError as error:
        raise PlanFileError(f"{where}: {error}") from None


def finite_at(value: Any, where: str) -> float:
    """A finite number of ordinary size."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not number or not abs(value) < LARGEST:
        raise PlanFileError(f"{where}: expected a finite number, found {str(value)[:40]}")
    return float(value)


def _vector(value: Any, where: str) -> list[float]:
    if not isinstance(value, list) or len(value) != 3:
        raise PlanFileError(f"{where}: expected three numbers [x, y, z], found {value!r}")
    return [finite_at(entry, where) for entry in value]


def columns(robot: Robot) -> list[str]:
    """Header of a table of load cases."""
    joints = [f"{j.name} [{j.kind.key}]" for j in robot.joints]
    forces = [f"F{axis} [N]" for axis in "xyz"] + [f"T{axis} [N.m]" for axis in "xyz"]
    return ["configuration", *joints, *forces]
