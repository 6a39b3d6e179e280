"""Rows of several files: below each other, beside each other, or joined by a key.

A file that is joined has one row for each key, as a list of joint values has one for each pose. All
rows of the first file with that key get its values.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import Cells, Words
from elastocal.files.measurements.columns import FORCES, LINE, MASS, TORQUES
from elastocal.files.measurements.mapping import FieldMapping
from elastocal.files.measurements.selection import selected, usable
from elastocal.files.measurements.table import Table, combined, kept

LOADS = (*FORCES, *TORQUES, MASS)


def joined(
    files: Sequence[Cells], joins: Sequence[tuple[str, ...]], mapping: FieldMapping | None
) -> tuple[Table, list[str]]:
    """One table, and what is said of rows that are left out.

    Args:
        files: The files.
        joins: By which words each belongs to the first ones; () by order.
        mapping: What chooses rows, and names reflectors that need no partner; None: neither.

    Raises:
        MeasurementFileError: files that do not belong together.
    """
    table = combined([file for file, join in zip(files, joins, strict=True) if not join])
    every = table.sources[0].lines
    remarks: list[str] = []
    keep = {} if mapping is None else dict(mapping.keep)
    where = "" if mapping is None else str(mapping.path)
    if keep:
        table, said = selected(table, keep, where)
        remarks += said
    behind: dict[tuple[tuple[str, ...], frozenset[str]], list[Cells]] = {}
    for file, join in zip(files, joins, strict=True):
        if join:
            keys = frozenset((*file.numbers, *file.words))
            behind.setdefault((join, keys), []).append(file)
    for (join, _), parts in behind.items():
        other = combined(parts)
        if join == (LINE,):
            table, said = _by_line(table, other, every)
        else:
            excused = needs_none(table, mapping)
            row, said = _partners(table, other, join, excused)
            table = beside(table, other, row, join)
        remarks += said
    if keep:
        table, said = selected(table, keep, where, last=True)
        remarks += said
    return table, remarks


def needs_none(table: Table, mapping: FieldMapping | None) -> BoolArray:
    """(R,) rows that need no partner: of reflectors that stand still, or not to be used."""
    excused = ~usable(table)
    if mapping is not None and mapping.foot and "marker" in table.words:
        words = table.words["marker"]
        excused |= np.array([name in mapping.foot for name in words.names])[words.codes]
    return excused


def plain_key(word: str) -> str:
    """A key as keys are compared: whole numbers without leading zeros."""
    return str(int(word)) if re.fullmatch(r"[0-9]{1,18}", word) else word


def _keys(table: Table, words: tuple[str, ...]) -> list[tuple[str, ...]]:
    """The key of every row."""
    columns = []
    for word in words:
        names = [plain_key(name) for name in table.words[word].names]
        columns.append([names[code] for code in table.words[word].codes.tolist()])
    return list(zip(*columns, strict=True))


def _partners(
    table: Table, other: Table, join: tuple[str, ...], excused: BoolArray
) -> tuple[IntArray, list[str]]:
    """(R,) row of the other file for each row, -1 for none."""
    for word in join:
        for one, far in ((table, other), (other, table)):
            if word not in one.words:
                raise MeasurementFileError(
                    f"{one.sources[0].paths[0]}: no column or pattern gives {word!r}, by which "
                    f"{far.sources[0].paths[0]} is joined"
                )
    known = _known(other, join)
    mine = _keys(table, join)
    row = np.array([known.get(key, -1) for key in mine], dtype=np.int64)
    lost = np.flatnonzero((row < 0) & ~excused)
    if len(lost):
        first = int(lost[0])
        name, there = " ".join(mine[first]), [" ".join(key) for key in known]
        near = difflib.get_close_matches(name, there, 3, 0.0)
        raise MeasurementFileError(
            f"{table.where(first, join[0])}: there is no {' '.join(join)} {name[:60]!r} in "
            f"{other.sources[0].paths[0]}; nearest to it are {', '.join(map(repr, near))}"
        )
    unused = [i for i in known.values() if i not in {*row.tolist()}]
    said = []
    if unused:
        many = f"{len(unused)} row{'s' if len(unused) > 1 else ''}"
        said.append(f"{many} without readings, first at {other.where(unused[0], join[0])}")
    return row, said


def _known(other: Table, join: tuple[str, ...]) -> dict[tuple[str, ...], int]:
    """The row of each key.

    Raises:
        MeasurementFileError: a key that is there twice with other values.
    """
    known: dict[tuple[str, ...], int] = {}
    told = [words.codes for key, words in other.words.items() if key not in join]
    numbers = np.column_stack([*other.numbers.values(), *told, np.zeros(other.rows)])
    for row, key in enumerate(_keys(other, join)):
        first = known.setdefault(key, row)
        same = np.array_equal(numbers[first], numbers[row], equal_nan=True)
        if first != row and not same:
            raise MeasurementFileError(
                f"{other.where(row, join[0])}: {' '.join(join)} {' '.join(key)[:60]!r} was given "
                f"in {other.line(first, row)} with other values; expected one row for each"
            )
    return known


def _by_line(table: Table, other: Table, every: IntArray) -> tuple[Table, list[str]]:
    """The rows that the other file lists by their line, with what it says of them."""
    source = table.sources[0]
    if LINE not in other.words:
        raise MeasurementFileError(
            f"{other.sources[0].paths[0]}: no column gives {LINE!r}, by which it is joined"
        )
    if len(source.paths) > 1:
        raise MeasurementFileError(
            f"{other.sources[0].paths[0]}: lines of several files, {source.paths[0]} and others, "
            "cannot be told apart; join one file"
        )
    known = _known(other, (LINE,))
    there = {str(line) for line in every.tolist()}
    for (line,), row in known.items():
        if line not in there:
            raise MeasurementFileError(
                f"{other.where(row, LINE)}: there is no row in line {line[:40]!r} of "
                f"{source.paths[0]}; expected the numbers of its lines, the first of the file is 1"
            )
    rows = np.array([known.get((str(line),), -1) for line in source.lines.tolist()], dtype=np.int64)
    listed = rows >= 0
    if not listed.any():
        raise MeasurementFileError(
            f"{other.where(0, LINE)}: none of the rows that are left of {source.paths[0]} is listed"
        )
    said = []
    if not listed.all():
        said.append(
            f"{int((~listed).sum())} of {len(rows)} rows left out that "
            f"{other.sources[0].paths[0].name} does not list"
        )
    return beside(kept(table, listed), other, rows[listed], (LINE,)), said


def beside(table: Table, other: Table, row: IntArray, join: tuple[str, ...]) -> Table:
    """A table with the columns of another, of which it takes the rows (R,); -1 for none.

    Loads that are said once for several states are those of the loaded one.

    Raises:
        MeasurementFileError: a column that both have, but for names that agree.
    """
    there = row >= 0
    numbers, words = dict(table.numbers), dict(table.words)
    for key, values in other.numbers.items():
        if key in numbers:
            _twice(table, other, key)
        taken = values[row] if other.rows else np.full(len(row), np.nan)
        numbers[key] = np.where(there, taken, np.nan)
    for key, word in other.words.items():
        if key in join:
            continue
        codes = np.where(there, word.codes[row], len(word.names))
        names = word.names if there.all() else (*word.names, "")
        if key in words:
            mine = words[key]
            apart = [mine.names[a] != names[b] for a, b in zip(mine.codes, codes, strict=True)]
            if any(a and b for a, b in zip(apart, there, strict=True)):
                _twice(table, other, key)
            continue
        words[key] = Words(codes, names)
    sources = tuple(replace(s, file=s.file[row], lines=s.lines[row]) for s in other.sources)
    found = Table(numbers, words, (*table.sources, *sources), table.rows)
    return found if "state" in join else of_loaded(found, other.numbers)


def of_loaded(table: Table, given: Sequence[str] | dict[str, Array]) -> Table:
    """The table without those loads in unloaded rows that are given for all states alike."""
    keys = [key for key in LOADS if key in given]
    if "state" not in table.words or not keys:
        return table
    words = table.words["state"]
    off = np.array([name.lower() == "unloaded" for name in words.names], dtype=bool)[words.codes]
    return replace(
        table,
        numbers=table.numbers | {key: np.where(off, 0.0, table.numbers[key]) for key in keys},
    )


def _twice(table: Table, other: Table, key: str) -> None:
    where = other.where(0, key)
    raise MeasurementFileError(
        f"{where}: this is in {table.sources[0].paths[0]} too, and not alike; expected files with "
        "columns of their own, and the key by which they are joined"
    )
