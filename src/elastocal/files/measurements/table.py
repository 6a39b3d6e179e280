"""One table from one file or several: rows with the place they came from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import Cells, Words


@dataclass(frozen=True)
class Source:
    """Where a row stands.

    Attributes:
        paths: The files.
        file: (R,) file of every row.
        lines: (R,) line of every row.
        headers: Header of every column that came from here, by key.
    """

    paths: tuple[Path, ...]
    file: IntArray
    lines: IntArray
    headers: dict[str, str]


@dataclass(frozen=True)
class Table:
    """R rows with their columns.

    Attributes:
        numbers: (R,) numbers in SI units, by key.
        words: Words, by key.
        sources: Where the rows stand; several for files side by side.
        rows: Number of rows R.
    """

    numbers: dict[str, Array]
    words: dict[str, Words]
    sources: tuple[Source, ...]
    rows: int

    def where(self, row: int, key: str = "") -> str:
        """'m.csv, line 4, column "u [mm]"'; without the column if there is none for `key`."""
        source = next((s for s in self.sources if key in s.headers), self.sources[0])
        place = f"{source.paths[source.file[row]]}, line {source.lines[row]}"
        return f"{place}, column {source.headers[key]!r}" if key in source.headers else place

    def line(self, row: int, other: int) -> str:
        """The line of a row, with its file if that is not the file of the `other` row."""
        source = self.sources[0]
        place = f"line {source.lines[row]}"
        if source.file[row] == source.file[other]:
            return place
        return f"{place} of {source.paths[source.file[row]]}"

    def has(self, *keys: str) -> bool:
        """Whether all these columns are there."""
        return all(key in self.numbers or key in self.words for key in keys)

    def vectors(self, keys: Sequence[str]) -> Array:
        """(R, len(keys)) columns side by side; zeros for those that are not there."""
        zero = np.zeros(self.rows)
        return np.column_stack([self.numbers.get(key, zero) for key in keys])


def kept(table: Table, keep: BoolArray) -> Table:
    """The rows where `keep`, (R,), is true."""
    return Table(
        {key: values[keep] for key, values in table.numbers.items()},
        {key: Words(word.codes[keep], word.names) for key, word in table.words.items()},
        tuple(Source(s.paths, s.file[keep], s.lines[keep], s.headers) for s in table.sources),
        int(keep.sum()),
    )


def combined(files: Sequence[Cells]) -> Table:
    """One table: files with the same columns one below the other, others row by row.

    Raises:
        MeasurementFileError: files side by side with different numbers of rows, with a
            column of numbers in two of them, or with different names in a row.
    """
    keys = [set(file.headers) for file in files]
    if all(some == keys[0] for some in keys):
        return _stacked(files)
    for i, file in enumerate(files):
        for other, theirs in zip(files[:i], keys[:i], strict=True):
            if len(file.lines) != len(other.lines):
                raise MeasurementFileError(
                    f"{file.path}: {len(file.lines)} rows, but {len(other.lines)} in "
                    f"{other.path}; files matched row by row need the same number"
                )
            for key in sorted(theirs & keys[i]):
                _check_same(file, other, key)
    return Table(
        {key: values for file in files for key, values in file.numbers.items()},
        {key: words for file in files for key, words in file.words.items()},
        tuple(_source([file]) for file in files),
        len(files[0].lines),
    )


def _check_same(file: Cells, other: Cells, key: str) -> None:
    """Refuse files side by side that share a column, unless it names the same in every row."""
    if key not in file.words or key not in other.words:
        raise MeasurementFileError(
            f"{file.path}: column {file.headers[key]!r} is in {other.path} too; expected files "
            "with the same columns, or each with columns of its own"
        )
    mine, theirs = file.words[key], other.words[key]
    known = {name: i for i, name in enumerate(mine.names)}
    place = np.array([known.get(name, -1) for name in theirs.names], dtype=np.int64)
    apart = np.flatnonzero(mine.codes != place[theirs.codes])
    if len(apart):
        row = int(apart[0])
        raise MeasurementFileError(
            f"{file.path}, line {file.lines[row]}, column {file.headers[key]!r}: "
            f"{mine.names[mine.codes[row]]!r} is matched with "
            f"{theirs.names[theirs.codes[row]]!r} in {other.path}, line {other.lines[row]}; "
            "expected the same rows in the same order"
        )


def _stacked(files: Sequence[Cells]) -> Table:
    if len(files) == 1:
        one = files[0]
        return Table(dict(one.numbers), dict(one.words), (_source(files),), len(one.lines))
    numbers = {key: np.concatenate([f.numbers[key] for f in files]) for key in files[0].numbers}
    words = {}
    for key in files[0].words:
        known: dict[str, int] = {}
        codes = []
        for file in files:
            word = file.words[key]
            new = [known.setdefault(name, len(known)) for name in word.names]
            codes.append(np.array(new, dtype=np.int64)[word.codes])
        words[key] = Words(np.concatenate(codes), tuple(known))
    source = _source(files)
    return Table(numbers, words, (source,), len(source.lines))


def _source(files: Sequence[Cells]) -> Source:
    return Source(
        tuple(file.path for file in files),
        np.repeat(np.arange(len(files)), [len(file.lines) for file in files]),
        np.concatenate([file.lines for file in files]),
        files[0].headers,
    )
