"""Rows of the same experiment share one load case."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, unset
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.columns import FORCES, MASS, TORQUES
from elastocal.files.measurements.table import Table
from elastocal.files.measurements.turns import alike, first_rows, side_by_side
from elastocal.files.tables.units import STANDARD_GRAVITY
from elastocal.measuring.measurements import FORCE_SCATTER, JOINT_SCATTER
from elastocal.robot.chain import Robot


@dataclass(frozen=True)
class Grouping:
    """Which rows are which experiment.

    Attributes:
        names: Names of the N experiments in the order of the file.
        codes: (R,) experiment of every row.
        cases: Their load cases.
        remarks: What was averaged.
    """

    names: tuple[str, ...]
    codes: IntArray
    cases: LoadCases
    remarks: tuple[str, ...]


def grouped(
    table: Table,
    robot: Robot,
    loaded: BoolArray | None,
    gravity: Array,
    preloaded: BoolArray,
) -> Grouping:
    """The experiments of a table.

    Args:
        table: Rows with joints and loads.
        robot: Whose joints they are.
        loaded: (R,) whether the row was read under load; None if all are deflections.
        preloaded: (R,) whether it was read under the first of two loads.
        gravity: (3,) acceleration with which a hanging mass pulls [m/s²]; zero for the standard.

    Raises:
        MeasurementFileError: joints or forces differ between the rows of one experiment.
    """
    names, codes = _experiments(table)
    keys = [f"q:{joint.name}" for joint in robot.joints]
    shown = table.vectors(keys)
    q, spread = _common(side_by_side(shown, codes, robot), codes, len(names))
    row, joint = np.unravel_index(spread.argmax(), spread.shape)
    if spread[row, joint] > JOINT_SCATTER:
        scale, unit = robot.joints[joint].kind.shown
        first = int(np.flatnonzero(codes == codes[row])[0])
        raise MeasurementFileError(
            f"{table.where(int(row), keys[joint])}: experiment {names[codes[row]]!r} has "
            f"{scale * shown[row, joint]:.6g} {unit} here and {scale * shown[first, joint]:.6g} "
            f"{unit} in {table.line(first, int(row))}; expected one configuration for each "
            "experiment" + _own_names(table, first, int(row))
        )
    remarks = []
    if spread.any():
        scale, unit = robot.joints[joint].kind.shown
        remarks.append(
            f"joint values differ within experiments by up to {scale * spread[row, joint]:.2g} "
            f"{unit}; their means are used"
        )
    wrench, before, said = _wrenches(table, names, codes, loaded, gravity, preloaded)
    return Grouping(names, codes, LoadCases(q, wrench, before), (*remarks, *said))


def _experiments(table: Table) -> tuple[tuple[str, ...], IntArray]:
    """Names in order of appearance; the number of the row where the file has no names."""
    if "experiment" not in table.words:
        return tuple(str(i + 1) for i in range(table.rows)), np.arange(table.rows)
    words = table.words["experiment"]
    unnamed = np.flatnonzero(np.array([not name for name in words.names])[words.codes])
    if len(unnamed):
        raise MeasurementFileError(
            f"{table.where(int(unnamed[0]), 'experiment')}: the cell is empty; expected the name "
            "or number of the experiment"
        )
    first = first_rows(words.codes, len(words.names))
    used = np.flatnonzero(first >= 0)
    order = used[np.argsort(first[used])]
    if np.array_equal(order, np.arange(len(words.names))):
        return words.names, words.codes  # numbered in order of appearance already
    place = np.empty(len(words.names), dtype=np.int64)
    place[order] = np.arange(len(order))
    return tuple(words.names[i] for i in order), place[words.codes]


def _common(values: Array, codes: IntArray, count: int) -> tuple[Array, Array]:
    """(count, k) value of each group and (R, k) how far each row is from its group's first."""
    result = values[first_rows(codes, count)]
    if alike(values, codes):  # the usual case, and quickly told
        return result, np.broadcast_to(0.0, values.shape)
    spread = np.abs(values - result[codes])
    if spread.any():  # means are rounded, so groups that agree keep their value
        size = np.bincount(codes, minlength=count)
        for k in range(values.shape[1]):
            differ = np.bincount(codes, spread[:, k], count) > 0.0
            mean = np.bincount(codes, values[:, k], count) / size
            result[:, k] = np.where(differ, mean, result[:, k])
    return result, spread


def _wrenches(
    table: Table,
    names: tuple[str, ...],
    codes: IntArray,
    loaded: BoolArray | None,
    gravity: Array,
    preloaded: BoolArray,
) -> tuple[Array, Array, list[str]]:
    """(N, 6) the load that came on top, and what acted before it; none if nothing did."""
    wrench = table.vectors((*FORCES, *TORQUES))
    if MASS in table.numbers:
        pull = gravity if np.any(gravity) else np.array([0.0, 0.0, -STANDARD_GRAVITY])
        wrench[:, :3] = table.numbers[MASS][:, None] * pull
    if loaded is None:
        result, remarks = _shared(table, names, codes, wrench, np.arange(table.rows))
        return result, unset(), remarks
    on, off = np.flatnonzero(loaded), np.flatnonzero(~loaded & ~preloaded)
    result, remarks = _shared(table, names, codes, wrench, on)
    before = unset()
    if wrench[preloaded].any():
        every = np.flatnonzero(~loaded)
        before, said = _shared(table, names, codes, wrench, every)
        before[np.setdiff1d(np.arange(len(names)), codes[preloaded])] = 0.0
        remarks += said
        result = result - before
    if wrench[off].any():
        rest, _ = _shared(table, names, codes, wrench, off)
        for side in (slice(0, 3), slice(3, 6)):
            size = np.linalg.norm(result[:, side], axis=1)
            left = np.linalg.norm(rest[:, side], axis=1)
            wrong = np.flatnonzero(left[codes[off]] > 0.1 * size[codes[off]])
            if len(wrong):
                row = int(off[wrong[0]])
                what = "force" if side.start == 0 else "torque"
                key = MASS if MASS in table.numbers else ("Fz" if what == "force" else "Tz")
                raise MeasurementFileError(
                    f"{table.where(row, key)}: an unloaded row has a {what} of "
                    f"{left[codes[row]]:.4g} {'N' if what == 'force' else 'N·m'}; expected zero, "
                    "or the small rest of a sensor"
                )
        remarks.append(
            "the loads of unloaded rows are not zero (up to "
            f"{np.linalg.norm(rest[:, :3], axis=1).max():.3g} N); the differences are used"
        )
        result = result - rest
    return result, before, remarks


def _shared(
    table: Table, names: tuple[str, ...], codes: IntArray, wrench: Array, rows: IntArray
) -> tuple[Array, list[str]]:
    """The wrench of each experiment from some of its rows."""
    there = np.bincount(codes[rows], minlength=len(names)) > 0
    used, group = np.flatnonzero(there), (np.cumsum(there) - 1)[codes[rows]]
    own = wrench if len(rows) == len(wrench) else wrench[rows]
    common, spread = _common(own, group, len(used))
    result = np.zeros((len(names), 6))
    result[used] = common
    remarks: list[str] = []
    if not spread.any():
        return result, remarks
    for side, keys, unit in ((slice(0, 3), FORCES, "N"), (slice(3, 6), TORQUES, "N·m")):
        apart = np.linalg.norm(spread[:, side], axis=1)
        size = np.linalg.norm(result[codes[rows], side], axis=1)
        wrong = np.flatnonzero(apart > FORCE_SCATTER * size)
        if len(wrong):
            row = int(rows[wrong[0]])
            axis = int(spread[wrong[0], side].argmax())
            key = MASS if MASS in table.numbers else keys[axis]
            first = int(rows[np.flatnonzero(codes[rows] == codes[row])[0]])
            now, then = wrench[row, side][axis], wrench[first, side][axis]
            raise MeasurementFileError(
                f"{table.where(row, key)}: experiment {names[codes[row]]!r} has {now:.6g} {unit} "
                f"here and {then:.6g} {unit} in {table.line(first, row)}; expected one load for "
                "each experiment" + _own_names(table, first, row)
            )
        if apart.any():
            remarks.append(
                f"{'forces' if unit == 'N' else 'torques'} differ within experiments by up to "
                f"{apart.max():.3g} {unit}; their means are used"
            )
    return result, remarks


def _own_names(table: Table, row: int, other: int) -> str:
    """Advice where two files count their experiments alike."""
    file = table.sources[0].file
    return "" if file[row] == file[other] else ", and names of their own in every file"
