"""From the cells of a file to columns of numbers and words; wrong cells by row and column."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.columns import Column
from elastocal.files.measurements.fast import plain_columns
from elastocal.files.tables.layout import Layout
from elastocal.files.tables.numbers import decimal_in, matches, numbers_of, plain
from elastocal.names import LONGEST, flaw

CHUNK = 20_000  # rows; bounds the memory for cells as text
NOT_USED = {"valid": ("0", "false", "no"), "delete": ("1", "true", "yes")}
"""Words that mark a row as not to be used."""
_DECIMALS = 1000  # rows that tell the decimal sign


@dataclass(frozen=True)
class Words:
    """A column of words: a number for each row, and the word of each number."""

    codes: IntArray
    names: tuple[str, ...]


@dataclass(frozen=True)
class Cells:
    """The columns of one file.

    Attributes:
        path: The file.
        lines: (R,) line of every row.
        headers: Header of every column, by key.
        numbers: (R,) numbers in SI units, by key; NaN where an optional cell is empty.
        words: Words, by key.
    """

    path: Path
    lines: IntArray
    headers: dict[str, str]
    numbers: dict[str, Array]
    words: dict[str, Words]


def read_cells(
    table: Layout,
    columns: dict[str, Column],
    decimal: str | None = None,
    keep: Mapping[str, Sequence[str]] = MappingProxyType({}),
) -> Cells:
    """Read the columns of a table.

    Args:
        table: The file with its header.
        columns: What to read, by key.
        decimal: Decimal sign; None to find out.
        keep: Words of the rows that are used, by key; other rows promise no numbers.

    Raises:
        MeasurementFileError: the first cell that is wrong, by line and column.
    """
    decimal = decimal or _decimal(table, columns)
    quick = plain_columns(table, columns, decimal)
    if quick is not None:
        found = _of_plain(table, columns, *quick)
    else:
        found = _cell_by_cell(table, columns, decimal, keep)
    for key, words in found.words.items():
        for code, name in enumerate(words.names if _may_be_flawed(words.names) else ()):
            if wrong := flaw(name):
                line = found.lines[np.flatnonzero(words.codes == code)[0]]
                raise MeasurementFileError(
                    f"{found.path}, line {line}, column {found.headers[key]!r}: {wrong}"
                )
    return found


def _may_be_flawed(names: tuple[str, ...]) -> bool:
    """Whether one of many names may have a flaw; quickly told if none has."""
    together = "".join(names)
    usual = together.isascii() and together.isprintable()
    return not usual or max(map(len, names), default=0) > LONGEST


def _of_plain(
    table: Layout, columns: dict[str, Column], lines: IntArray, found: dict[str, Any]
) -> Cells:
    """The columns of a plain table."""
    numbers = {key: found[key] for key, column in columns.items() if column.meaning.kind}
    words = {key: Words(*found[key]) for key in columns if key not in numbers}
    headers = {key: column.header for key, column in columns.items()}
    return Cells(table.file.path, lines, headers, numbers, words)


def _cell_by_cell(
    table: Layout, columns: dict[str, Column], decimal: str, keep: Mapping[str, Sequence[str]]
) -> Cells:
    numbers: dict[str, list[Array]] = {k: [] for k, c in columns.items() if c.meaning.kind}
    words: dict[str, list[IntArray]] = {k: [] for k, c in columns.items() if not c.meaning.kind}
    codes: dict[str, dict[str, int]] = {key: {} for key in words}
    lines: list[IntArray] = []
    marks = [(columns[k].index, out) for k, out in NOT_USED.items() if k in columns]
    kept = [(columns[key].index, words) for key, words in keep.items()]
    for at, rows in _chunks(table.rows()):
        lines.append(np.array(at, dtype=np.int64))
        out = _not_used(rows, marks, kept)
        for key, column in columns.items():
            cells = [row[column.index] for row in rows]
            if column.meaning.kind:
                if any(out):  # nobody promises numbers there
                    cells = ["0" if o else cell for o, cell in zip(out, cells, strict=True)]
                empty = [not cell.strip() for cell in cells] if column.optional else []
                if any(empty):
                    cells = ["0" if e else cell for e, cell in zip(empty, cells, strict=True)]

                def where(i: int, at: Sequence[int] = at, column: Column = column) -> str:
                    return f"{table.file.path}, line {at[i]}, column {column.header!r}"

                values = numbers_of(cells, decimal, where, table.file.error)
                if any(empty):
                    values[empty] = np.nan
                numbers[key].append(values)
            else:
                words[key].append(_codes(cells, codes[key]))
    if not lines:
        raise MeasurementFileError(f"{table.file.path}: there is no row of data below the header")
    return Cells(
        table.file.path,
        np.concatenate(lines),
        {key: column.header for key, column in columns.items()},
        {key: columns[key].factor * np.concatenate(parts) for key, parts in numbers.items()},
        {key: Words(np.concatenate(parts), tuple(codes[key])) for key, parts in words.items()},
    )


def _not_used(
    rows: Sequence[list[str]],
    marks: Sequence[tuple[int, tuple[str, ...]]],
    kept: Sequence[tuple[int, Sequence[str]]],
) -> list[bool]:
    """Which rows are marked by one of the words in one of the places, or not kept; [] if none."""
    if not (marks or kept):
        return []
    return [
        any(plain(row[i]).lower() in words for i, words in marks)
        or not all(matches(plain(row[i]), words) for i, words in kept)
        for row in rows
    ]


def _chunks(
    rows: Iterator[tuple[int, list[str]]],
) -> Iterator[tuple[tuple[int, ...], tuple[list[str], ...]]]:
    while chunk := list(islice(rows, CHUNK)):
        at, cells = zip(*chunk, strict=True)
        yield at, cells


def _decimal(table: Layout, columns: dict[str, Column]) -> str:
    """The decimal sign of the first rows.

    Raises:
        MeasurementFileError: numbers with a comma and numbers with a point.
    """
    if table.delimiter == "," and '"' not in table.file.text:
        return "."
    used = [column for column in columns.values() if column.meaning.kind]
    first: dict[str, tuple[int, Column, str]] = {}
    for line, row in islice(table.rows(), _DECIMALS):
        for column in used:
            cell = row[column.index]
            sign = decimal_in(cell, table.delimiter)
            if sign and sign not in first:
                first[sign] = line, column, cell.strip()
    if len(first) == 2:
        line, column, cell = first[","]
        raise MeasurementFileError(
            f"{table.file.path}, line {line}, column {column.header!r}: {cell[:40]!r} here and "
            f"{first['.'][2][:40]!r} in line {first['.'][0]}; expected one decimal sign for all"
        )
    return next(iter(first), ".")


def _codes(cells: Sequence[str], known: dict[str, int]) -> IntArray:
    numbers = (known.setdefault(plain(cell), len(known)) for cell in cells)
    return np.fromiter(numbers, dtype=np.int64, count=len(cells))
