"""What was measured before a plan, as a section of plan.json."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.arrays import frozen
from elastocal.errors import PlanFileError
from elastocal.files.plans.load_case_entries import finite_at, load_case_entries, read_load_cases
from elastocal.robot.chain import Robot
from elastocal.study.study import Done


def done_section(robot: Robot, done: Done) -> dict[str, Any]:
    """The section `after`."""
    return {
        "measurements": done.source,
        "sha256": done.sha256,
        "experiments": done.experiments,
        "configurations": list(load_case_entries(robot, done.cases)),
        "information_N2m2": done.information.tolist(),
    }


def read_done(entry: Any, robot: Robot, where: str) -> Done:
    """The section `after`, as it was written.

    Raises:
        PlanFileError: it is wrong; names the key.
    """
    if not isinstance(entry, dict):
        raise PlanFileError(f"{where}: expected a section of keys")
    rows = entry.get("information_N2m2")
    size = len(rows) if isinstance(rows, list) else 0
    if not size or any(not isinstance(row, list) or len(row) != size for row in rows or []):
        raise PlanFileError(f"{where}: information_N2m2 must be as many rows as columns")
    table = [[_number(v, f"{where}: information_N2m2") for v in row] for row in rows or []]
    information = np.array(table)
    if not np.allclose(information, information.T, rtol=1e-6):
        raise PlanFileError(f"{where}: information_N2m2 is not symmetric")
    return Done(
        source=str(entry.get("measurements", "")),
        sha256=str(entry.get("sha256", "")),
        experiments=int(finite_at(entry.get("experiments"), f"{where}: experiments")),
        cases=read_load_cases(entry.get("configurations"), robot, f"{where}: configurations"),
        information=frozen(information),
    )


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) < 1e30:
        raise PlanFileError(f"{where}: expected a finite number, found {str(value)[:40]}")
    return float(value)
