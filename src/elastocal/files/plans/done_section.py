"""What was measured before a plan, as a section of plan.json."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from elastocal.arrays import Array, IntArray, frozen, unset
from elastocal.elastic.load_cases import ranks_of_rows
from elastocal.errors import PlanFileError
from elastocal.files.plans.load_case_entries import (
    Finite,
    finite,
    load_case_entries,
    read_load_cases,
    section_at,
)
from elastocal.files.sections import NOTHING, Before, PartSection, fresh
from elastocal.files.values import Natural
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


class ReadingsFile(PartSection):
    """How a load case was read before."""

    repeats: Natural | None = None
    precision: Natural | None = None


class DoneFile(PartSection):
    """The section `after`: what was measured before."""

    information_N2m2: Annotated[list[list[float]], Before(_information)] = NOTHING
    precisions_per_m2: list[Annotated[list[list[float]], Before(_information)]] = fresh(list)
    measurements: _Text = ""
    sha256: _Text = ""
    experiments: Finite = NOTHING
    configurations: Any = None


def done_section(robot: Robot, done: Done) -> dict[str, Any]:
    """The section `after`."""
    entries, kinds = list(load_case_entries(robot, done.cases)), []
    if done.readings is not None:
        flat = done.precision.reshape(len(entries), -1)
        _, first, kind = np.unique(ranks_of_rows(flat), return_index=True, return_inverse=True)
        kinds = done.precision[first].tolist()
        for entry, times, own in zip(entries, done.repeats.tolist(), kind.tolist(), strict=True):
            entry["repeats"], entry["precision"] = times, own
    return {
        "measurements": done.source,
        "sha256": done.sha256,
        "experiments": done.experiments,
        "configurations": entries,
        "information_N2m2": done.information.tolist(),
        **({"precisions_per_m2": kinds} if kinds else {}),
    }


def read_done(entry: Any, robot: Robot, where: str) -> Done:
    """The section `after`, as it was written.

    Raises:
        PlanFileError: it is wrong; names the key.
    """
    section = section_at(DoneFile, entry, where)
    there = f"{where}: configurations"
    cases = read_load_cases(section.configurations, robot, there)
    given = [
        section_at(ReadingsFile, one, f"{there}, load case {i + 1}")
        for i, one in enumerate(section.configurations)
    ]
    repeats, precision = _readings(given, section.precisions_per_m2, where)
    if len(repeats) and int(repeats.sum()) != section.experiments:
        raise PlanFileError(
            f"{where}: experiments: found {section.experiments:g}, and the repeats of its "
            f"configurations are {int(repeats.sum())}"
        )
    return Done(
        source=section.measurements,
        sha256=section.sha256,
        experiments=int(section.experiments),
        cases=cases,
        information=frozen(np.array(section.information_N2m2)),
        repeats=repeats,
        precision=precision,
    )


def _readings(
    given: list[ReadingsFile], kinds: list[list[list[float]]], where: str
) -> tuple[IntArray, Array]:
    """(E,) repeats and (E, m, m) precisions of load cases; empty where a plan has none."""
    if not kinds:
        return np.zeros(0, dtype=np.int64), unset()
    if len({len(kind) for kind in kinds}) > 1:
        raise PlanFileError(f"{where}: precisions_per_m2: all must be of the same size")
    for i, one in enumerate(given):
        here = f"{where}: configurations, load case {i + 1}"
        if not one.repeats:
            raise PlanFileError(f"{here}: repeats: expected a number from 1")
        if one.precision is None or one.precision >= len(kinds):
            raise PlanFileError(
                f"{here}: precision: expected one of the {len(kinds)} of precisions_per_m2, from 0"
            )
    repeats = np.array([one.repeats for one in given], dtype=np.int64)
    return repeats, np.array([kinds[one.precision or 0] for one in given])
