"""From rows to readings: loaded minus unloaded, one for every marker of an experiment."""

from __future__ import annotations

from collections.abc import Container, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, unset
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.columns import AXES, POSITION, ROTATION, Triple
from elastocal.files.measurements.experiments import Grouping
from elastocal.files.measurements.table import Table, kept
from elastocal.files.measurements.turns import first_rows
from elastocal.files.measurements.uncertainty import averaged, kind_of_uncertainty, variances
from elastocal.robot.chain import Tool


@dataclass(frozen=True)
class Readings:
    """R readings.

    Attributes:
        case: (R,) experiment.
        marker: (R,) target: marker, or the rotation behind them.
        deflection: (R, 3) in the frame of the file [m], rotations [rad].
        six: (R, 6) their own variances and covariances [m², rad²]; None if none has any, NaN
            where a reading has none.
        weight: (R,) variance over that of one loaded minus one unloaded reading.
        remarks: What is odd.
        unloaded: (R,) number of the unloaded reading behind each; empty if none is shared.
        unloaded_at: (R, 3) where the marker was read without load [m], frame of the file; none if
            deflections alone are known.
        row: (R,) row in which each stands first, beside `unloaded_at`.
    """

    case: IntArray
    marker: IntArray
    deflection: Array
    six: Array | None
    weight: Array
    remarks: tuple[str, ...] = ()
    unloaded: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    unloaded_at: Array = field(default_factory=unset)
    row: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


def markers(table: Table, tool: Tool) -> IntArray:
    """(R,) position of the marker of every row in the tool.

    Raises:
        MeasurementFileError: a marker that the tool does not have.
    """
    if "marker" not in table.words:
        return np.zeros(table.rows, dtype=np.int64)
    words = table.words["marker"]
    place = np.array([_place(name, tool.marker_names) for name in words.names])[words.codes]
    wrong = np.flatnonzero(place < 0)
    if len(wrong):
        row = int(wrong[0])
        raise MeasurementFileError(
            f"{table.where(row, 'marker')}: the tool {tool.name!r} has no marker "
            f"{words.names[words.codes[row]][:40]!r}; its markers are "
            f"{', '.join(tool.marker_names)}"
        )
    return np.asarray(place, dtype=np.int64)


def _place(name: str, known: tuple[str, ...]) -> int:
    if name in known:
        return known.index(name)
    alike = [i for i, other in enumerate(known) if other.lower() == name.lower()]
    return alike[0] if len(alike) == 1 else -1


def deflections(table: Table, grouping: Grouping, marker: IntArray, tool: Tool) -> Readings:
    """Readings of a table that has deflections, rotations or both.

    An experiment has one rotation, however many markers: it may stand in any of its rows.

    Raises:
        MeasurementFileError: a marker of an experiment, or its rotation, is there twice with other
            values; a row in which nothing is read, or only some of three axes.
    """
    found, nothing = [], np.ones(table.rows, dtype=bool)
    for of in (POSITION, ROTATION):
        if not table.has(*of.values):
            continue
        read = _is_read(table, of)
        nothing &= ~read
        target = marker if of is POSITION else np.full(table.rows, len(tool.markers))
        if not read.all():
            codes = replace(grouping, codes=grouping.codes[read])
            found.append(_read(kept(table, read), codes, target[read], tool, of))
        else:
            found.append(_read(table, grouping, target, tool, of))
    if nothing.any():
        raise MeasurementFileError(
            f"{table.where(int(nothing.argmax()))}: the row has neither a deflection nor a rotation"
        )
    return found[0] if len(found) == 1 else _together(found)


def _is_read(table: Table, of: Triple) -> BoolArray:
    """(R,) rows with such a reading; its cells are empty in the others.

    Raises:
        MeasurementFileError: some of the three cells are empty.
    """
    empty = np.isnan(table.vectors(of.values))
    some = np.flatnonzero(empty.any(axis=1) & ~empty.all(axis=1))
    if len(some):
        row = int(some[0])
        lacking = of.values[int(empty[row].argmax())]
        raise MeasurementFileError(
            f"{table.where(row, lacking)}: the cell is empty; expected a number, or all three of "
            f"{', '.join(of.values)} empty where nothing was read"
        )
    return np.asarray(~empty[:, 0])


def _read(table: Table, grouping: Grouping, target: IntArray, tool: Tool, of: Triple) -> Readings:
    """Readings of one kind, of which every row has one."""
    values, own = table.vectors(of.values), kind_of_uncertainty(table.numbers, "", of)
    remarks = repeated(table, repeats(values)) if of is POSITION else []
    six = variances(table, own, of) if own else None
    key = grouping.codes * len(tool.targets) + target
    first = first_rows(key, len(grouping.names) * len(tool.targets))
    again = np.flatnonzero(first[key] != np.arange(len(key)))
    keep: BoolArray | slice = slice(None)
    if len(again):
        before = first[key[again]]
        other = (values[again] != values[before]).any(axis=1)
        if six is not None:
            other |= (six[again] != six[before]).any(axis=1)
        if other.any():
            row, old = int(again[other.argmax()]), int(before[other.argmax()])
            named = f"experiment {grouping.names[grouping.codes[row]]!r}"
            what = f"marker {tool.targets[target[row]]!r}" if of is POSITION else "its rotation"
            raise MeasurementFileError(
                f"{table.where(row)}: {named}, {what} was given in {table.line(old, row)} with "
                f"another {of.what}; a repetition needs an experiment name of its own"
            )
        keep = np.ones(len(key), dtype=bool)
        keep[again] = False
        once = "repeated exactly" if of is POSITION else "with a rotation that another row has"
        remarks = [
            f"{_rows(len(again))} {once}, first at {table.where(int(again[0]))}; counted once"
        ]
    return Readings(
        grouping.codes[keep],
        target[keep],
        values[keep],
        None if six is None else six[keep],
        np.ones(len(key) - len(again)),
        tuple(remarks),
    )


def _together(parts: Sequence[Readings]) -> Readings:
    """Positions and rotations, experiment by experiment; uncertainties that only some have: NaN."""
    sixes = [np.full((len(p.case), 6), np.nan) if p.six is None else p.six for p in parts]
    case, marker = (np.concatenate([getattr(p, n) for p in parts]) for n in ("case", "marker"))
    order = np.argsort(case, kind="stable")
    return Readings(
        case[order],
        marker[order],
        np.concatenate([p.deflection for p in parts])[order],
        None if all(p.six is None for p in parts) else np.concatenate(sixes)[order],
        np.concatenate([p.weight for p in parts])[order],
        tuple(remark for p in parts for remark in p.remarks),
    )


def differences(
    table: Table,
    grouping: Grouping,
    marker: IntArray,
    tool: Tool,
    loaded: BoolArray,
    excused: Container[tuple[str, str]],
) -> Readings:
    """Readings of a table that has loaded and unloaded positions.

    Several readings of one state are averaged. Without uncertainties of their own, a difference
    has the covariance of the instrument, half of it from each state.

    Args:
        table: Rows with positions.
        grouping: Their experiments.
        marker: (R,) their markers.
        tool: The tool with the markers.
        loaded: (R,) whether a row was read under load.
        excused: Experiments and markers of rows left out as invalid; what they leave without its
            counterpart is left out too, and said.

    Raises:
        MeasurementFileError: loaded without unloaded or the reverse.
    """
    values, own = table.vectors(AXES), kind_of_uncertainty(table.numbers, "", POSITION)
    key = grouping.codes * len(tool.marker_names) + marker
    pairs, first, group = np.unique(key, return_index=True, return_inverse=True)
    sides = []
    for rows in (np.flatnonzero(loaded), np.flatnonzero(~loaded)):
        count = np.bincount(group[rows], minlength=len(pairs))
        total = np.stack(
            [np.bincount(group[rows], values[rows, k], len(pairs)) for k in range(3)], axis=1
        )
        six = averaged(variances(table, own, POSITION)[rows], group[rows], count) if own else None
        sides.append((count, total / np.maximum(count, 1)[:, None], six))
    (n_on, on, six_on), (n_off, off, six_off) = sides
    alone = np.flatnonzero((n_on == 0) | (n_off == 0))
    remarks, behind = [], np.zeros(0, dtype=np.int64)
    again = repeats(values)
    if len(again):
        behind = _unloaded_of(grouping, marker, values, ~loaded)
        shared = np.bincount(behind)[behind] > 1
        remarks += repeated(table, again[~(shared & ~loaded)[again]])
        behind = _of_pairs(behind, group, ~loaded, n_off)
    if len(alone):
        lost = alone[np.argsort(first[alone])]
        for row in map(int, first[lost]):
            named = grouping.names[grouping.codes[row]], tool.marker_names[marker[row]]
            if named in excused:
                continue
            has, lacks = ("loaded", "unloaded") if loaded[row] else ("unloaded", "loaded")
            raise MeasurementFileError(
                f"{table.where(row)}: experiment {named[0]!r}, marker {named[1]!r} "
                f"has a reading {has} but none {lacks}"
            )
        remarks.append(
            f"{len(lost)} readings are left out because their counterpart is marked invalid, "
            f"first at {table.where(int(first[lost[0]]))}"
        )
    good = np.setdiff1d(np.arange(len(pairs)), alone)
    good = good[np.argsort(first[good])]
    weight = 0.5 / np.maximum(n_on, 1) + 0.5 / np.maximum(n_off, 1)
    return Readings(
        grouping.codes[first[good]],
        marker[first[good]],
        (on - off)[good],
        None if six_on is None or six_off is None else (six_on + six_off)[good],
        weight[good],
        tuple(remarks),
        behind[good] if len(behind) else behind,
        off[good],
        first[good],
    )


def _unloaded_of(
    grouping: Grouping, marker: IntArray, values: Array, unloaded: BoolArray
) -> IntArray:
    """(R,) number of each unloaded reading; rows that repeat one in its configuration share it.

    A campaign that reads the unloaded arm once in each configuration writes it down with every
    load. Loaded rows have numbers of their own.
    """
    q = np.round(grouping.cases.q, 9)[grouping.codes]
    rows = np.flatnonzero(unloaded)
    together = np.column_stack([q[rows], marker[rows], values[rows]])
    number = np.arange(len(values)) + len(rows)
    number[rows] = np.unique(together, axis=0, return_inverse=True)[1].reshape(-1)
    return number


def _of_pairs(number: IntArray, group: IntArray, unloaded: BoolArray, count: IntArray) -> IntArray:
    """(P,) number of the unloaded reading of each pair; one of its own where it is an average."""
    found = number.max(initial=0) + 1 + np.arange(len(count))
    rows = np.flatnonzero(unloaded & (count[group] == 1))
    found[group[rows]] = number[rows]
    return found


def repeats(values: Array) -> IntArray:
    """Rows that repeat one before, to the last digit.

    The sort is stable, so of equal rows the later ones are named.
    """
    bits = np.ascontiguousarray(values).view(np.uint64)
    digest = np.sort(bits @ np.array([1, 0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F], dtype=np.uint64))
    if not (digest[1:] == digest[:-1]).any():
        return np.zeros(0, dtype=np.int64)  # as good as always, and cheaper than to sort rows
    order = np.lexsort(values.T)
    same = (values[order[1:]] == values[order[:-1]]).all(axis=1)
    return np.sort(order[1:][same & values[order[1:]].any(axis=1)])


def repeated(table: Table, rows: IntArray) -> list[str]:
    """A beam that broke leaves the last point in the log again."""
    if not len(rows):
        return []
    return [
        f"{_rows(len(rows))} repeat a point to the last digit, first at "
        f"{table.where(int(rows[0]))}: was the beam broken there?"
    ]


def _rows(count: int) -> str:
    return "1 row" if count == 1 else f"{count} rows"
