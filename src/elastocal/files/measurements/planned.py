"""Joints and loads of a plan, for readings that say their experiment by its number in the plan."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from elastocal.arrays import BoolArray, IntArray
from elastocal.errors import InputError, MeasurementFileError
from elastocal.files.measurements.columns import FORCES, MASS, TORQUES
from elastocal.files.measurements.joined import beside, plain_key
from elastocal.files.measurements.table import Source, Table
from elastocal.reading import bytes_of
from elastocal.robot.chain import Robot

if TYPE_CHECKING:
    from elastocal.files.plans.proposal_file import Proposal

_LARGEST = 100_000_000  # bytes


@dataclass(frozen=True)
class PlannedJoints:
    """What a plan says of its experiments.

    Attributes:
        path: Its file.
        sha256: Hash of that.
        proposal: The plan; repeats are experiments of their own, counted from 1 in its order.
        robot: Whose joints it has.
    """

    path: Path
    sha256: str
    proposal: Proposal
    robot: Robot

    @property
    def joints(self) -> tuple[str, ...]:
        """Keys of the joints."""
        return tuple(f"q:{name}" for name in self.robot.joint_names)

    def gives(self, found: set[str]) -> set[str]:
        """What it gives beside what there is: joints, and loads where there are none.

        Raises:
            MeasurementFileError: there are joints already, or no numbers of experiments.
        """
        also = [key for key in self.joints if key in found]
        if also:
            raise MeasurementFileError(
                f"{self.path}: the joints are those of the plan, but there is a column of "
                f"{also[0].removeprefix('q:')!r} too; leave one of them out"
            )
        if "experiment" not in found:
            raise MeasurementFileError(
                f"{self.path}: the joints are those of the plan by the number of the experiment, "
                "but no column or pattern gives 'experiment'"
            )
        loads = () if found & {*FORCES, *TORQUES, MASS} else (*FORCES, *TORQUES)
        return {*self.joints, *loads}


def planned_at(path: Path, robot: Robot) -> PlannedJoints:
    """What a plan says.

    Raises:
        MeasurementFileError: it cannot be read, or is none.
    """
    from elastocal.files.plans.proposal_file import proposal_at  # with all of planning

    try:
        data = bytes_of(path, _LARGEST, MeasurementFileError)
        proposal = proposal_at(path, robot)
    except MeasurementFileError:
        raise
    except InputError as error:
        raise MeasurementFileError(str(error)) from None
    return PlannedJoints(path, hashlib.sha256(data).hexdigest(), proposal, robot)


def with_planned(table: Table, planned: PlannedJoints, excused: BoolArray) -> Table:
    """The table with joints and loads of the plan; loads are those of loaded rows.

    Args:
        table: Rows with the numbers of their experiments.
        planned: The plan.
        excused: (R,) rows that need none, as of reflectors that stand still.

    Raises:
        MeasurementFileError: an experiment that the plan does not have.
    """
    proposal = planned.proposal
    case = np.repeat(np.arange(len(proposal.load_cases)), proposal.repeats)
    words = table.words["experiment"]
    numbers = np.array([_number(name, len(case)) for name in words.names], dtype=np.int64)
    row: IntArray = numbers[words.codes]
    wrong = np.flatnonzero((row < 0) & ~excused)
    if len(wrong):
        first = int(wrong[0])
        raise MeasurementFileError(
            f"{table.where(first, 'experiment')}: expected the number of an experiment of "
            f"{planned.path.name}, 1 to {len(case)}, found "
            f"{words.names[words.codes[first]][:40]!r}"
        )
    values = dict(zip(planned.joints, proposal.load_cases.q[case].T, strict=True))
    loads = zip((*FORCES, *TORQUES), proposal.load_cases.wrench[case].T, strict=True)
    if not any(key in table.numbers for key in (*FORCES, *TORQUES, MASS)):
        values |= dict(loads)
    nothing = np.zeros(len(case), dtype=np.int64)
    source = Source((planned.path,), nothing, nothing, {})
    return beside(table, Table(values, {}, (source,), len(case)), row, ())


def _number(name: str, most: int) -> int:
    """Index of the experiment with a number, -1 if it is none."""
    number = plain_key(name)
    return int(number) - 1 if number.isdigit() and 1 <= int(number) <= most else -1
