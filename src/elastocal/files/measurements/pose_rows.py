"""Rows of absolute readings: which are of one pose, which of reflectors that stand still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastocal.arrays import BoolArray, IntArray, frozen
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import Words
from elastocal.files.measurements.table import Table
from elastocal.robot.payloads import Payload
from elastocal.study.absolute import AbsoluteStudy

APART = ("series", "mounting", "payload", "state")
"""Words that tell experiments of one name apart."""
_ALIKE = 1e-3  # by which weights of plans are rounded at most
_NOTHING = ("-", "none", "nothing")


def told_apart(table: Table, words: Sequence[str] = APART) -> Table:
    """The table with experiments named after their series, too, where names come again in others.

    Two files of two days both count their poses from one.
    """
    if "experiment" not in table.words:
        return table
    own = table.words["experiment"]
    codes, names = own.codes, own.names
    for word in words:
        if word not in table.words:
            continue
        other = table.words[word]
        pairs, first, together = np.unique(
            np.column_stack([codes, other.codes]), axis=0, return_index=True, return_inverse=True
        )
        if len(pairs) > len(np.unique(codes)):
            rank = np.argsort(np.argsort(first))  # numbered in order of appearance
            codes = rank[np.reshape(together, -1)]
            order = np.argsort(first)
            names = tuple(f"{other.names[b]}/{names[a]}" for a, b in pairs[order].tolist())
    return replace(table, words=table.words | {"experiment": Words(codes, tuple(names))})


def on_foot(table: Table, names: Sequence[str]) -> BoolArray:
    """(R,) rows of reflectors that stand still.

    Raises:
        MeasurementFileError: one of their names that no row has.
    """
    words = table.words.get("marker")
    if not names or words is None:
        return np.zeros(table.rows, dtype=bool)
    for name in names:
        if name not in words.names:
            there = ", ".join(repr(word[:40]) for word in words.names[:8])
            raise MeasurementFileError(
                f"{table.sources[0].paths[0]}: no row has the reflector {name!r} of 'foot'; found "
                f"{there}"
            )
    return np.array([name in names for name in words.names], dtype=bool)[words.codes]


def refuse_empty(table: Table, keys: Sequence[str]) -> None:
    """Raise if a row lacks a number.

    Raises:
        MeasurementFileError: by row and column.
    """
    for key in keys:
        if key in table.numbers:
            empty = np.flatnonzero(np.isnan(table.numbers[key]))
            if len(empty):
                raise MeasurementFileError(
                    f"{table.where(int(empty[0]), key)}: the cell is empty; expected a number"
                )


def numbered(table: Table, *words: str) -> tuple[IntArray, tuple[str, ...]]:
    """(R,) number and name of what the first of some words says that is there; one for none."""
    found = next((table.words[word] for word in words if word in table.words), None)
    if found is None:
        return np.zeros(table.rows, dtype=np.int64), ("",)
    used, codes = np.unique(found.codes, return_inverse=True)
    return np.reshape(codes, -1), tuple(found.names[code] for code in used)


def carried(table: Table, payloads: Sequence[Payload], usual: str) -> IntArray:
    """(R,) number of the payload in each row, -1 for nothing; the usual one where none is said.

    Raises:
        MeasurementFileError: a payload that the study does not have.
    """
    words = table.words.get("payload")
    known = [payload.name for payload in payloads]
    unsaid = known.index(usual) if usual else -1
    if words is None:
        return np.full(table.rows, unsaid, dtype=np.int64)
    place = [
        known.index(name) if name in known else unsaid if not name else _nothing(name)
        for name in words.names
    ]
    found = np.array(place, dtype=np.int64)[words.codes]
    wrong = np.flatnonzero(found == -2)
    if len(wrong):
        row = int(wrong[0])
        raise MeasurementFileError(
            f"{table.where(row, 'payload')}: the study has no payload "
            f"{words.names[words.codes[row]][:40]!r}; it has {', '.join(known) or 'none'}, and "
            "'none' is nothing"
        )
    return frozen(found, np.int64)


def hung_as_planned(
    cases: LoadCases, payload: IntArray, study: AbsoluteStudy
) -> tuple[LoadCases, IntArray]:
    """Load cases of a plan with the weight that it chooses as the payload that it is.

    Args:
        cases: N load cases as planned: a payload that is there or not is its weight there.
        payload: (N,) what is carried as far as readings say.
        study: The payloads, and gravity.

    Returns:
        The load cases without these weights, and (N,) what is carried.
    """
    wrench, carried = np.array(cases.wrench), np.array(payload)
    for number, one in enumerate(study.payloads):
        weight = np.append(one.mass * study.gravity, np.zeros(3))
        size = np.linalg.norm(weight)
        same = np.linalg.norm(wrench - weight, axis=1) <= _ALIKE * size
        if size and one.name != study.payload and same.any():
            wrench[same], carried[same] = 0.0, number
    return replace(cases, wrench=wrench), carried


def _nothing(name: str) -> int:
    """-1 for a word that means nothing, -2 for any other."""
    return -1 if name.lower() in _NOTHING else -2
