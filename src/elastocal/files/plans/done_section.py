"""What was measured before a plan, as a section of plan.json."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from elastocal.arrays import frozen
from elastocal.files.plans.load_case_entries import (
    Finite,
    finite,
    load_case_entries,
    read_load_cases,
    section_at,
)
from elastocal.files.sections import NOTHING, Before, PartSection
from elastocal.matrices import is_information, is_symmetric
from elastocal.robot.chain import Robot
from elastocal.study.before import Done


def square(rows: Any) -> list[list[float]]:
    """A symmetric matrix."""
    size = len(rows) if isinstance(rows, list) else 0
    if not size or any(not isinstance(row, list) or len(row) != size for row in rows):
        raise ValueError(" must be as many rows as columns")
    matrix = [[finite(v, 1e30) for v in row] for row in rows]
    if not is_symmetric(np.array(matrix)):
        raise ValueError(" is not symmetric")
    return matrix


def _information(rows: Any) -> list[list[float]]:
    """A symmetric matrix that tells of no combination less than nothing."""
    matrix = square(rows)
    if not is_information(np.array(matrix)):
        raise ValueError(" has a negative eigenvalue")
    return matrix


_Text = Annotated[str, Before(str)]


class DoneFile(PartSection):
    """The section `after`: what was measured before."""

    information_N2m2: Annotated[list[list[float]], Before(_information)] = NOTHING
    measurements: _Text = ""
    sha256: _Text = ""
    experiments: Finite = NOTHING
    configurations: Any = None


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
    section = section_at(DoneFile, entry, where)
    return Done(
        source=section.measurements,
        sha256=section.sha256,
        experiments=int(section.experiments),
        cases=read_load_cases(section.configurations, robot, f"{where}: configurations"),
        information=frozen(np.array(section.information_N2m2)),
    )
