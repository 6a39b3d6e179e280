"""Foreign files seen through a mapping: their columns found, constants and words put in."""

from __future__ import annotations

import difflib
import unicodedata
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import Cells, Words
from elastocal.files.measurements.columns import TIME, Column, Meaning, column_of, raw
from elastocal.files.measurements.joined import of_loaded
from elastocal.files.measurements.mapping import FieldMapping
from elastocal.files.measurements.mapping_places import Constant, Place, twice
from elastocal.files.measurements.patterns import Pattern
from elastocal.files.measurements.table import Source, Table
from elastocal.files.tables.layout import Layout
from elastocal.files.tables.units import spelled, split_header


def mapped_columns(tables: Sequence[Layout], mapping: FieldMapping) -> list[dict[str, Column]]:
    """The columns of each file, by key.

    Raises:
        MeasurementFileError: a column that no file has, or that several have where one is meant.
    """
    found: list[dict[str, Column]] = [{} for _ in tables]
    for place in mapping.places:
        if place.file is not None and place.file > len(tables):
            raise MeasurementFileError(
                f"{place.where}: there is no file {place.file}, only {len(tables)}"
            )
        files = range(len(tables)) if place.file is None else [place.file - 1]
        hits = {i: at for i in files if (at := _index(tables[i], place)) is not None}
        if not hits:
            raise MeasurementFileError(_not_found(tables, files, place))
        for i, index in hits.items():
            header = tables[i].header[index]
            column = _column(place, index, header, mapping.style(i).header)
            key = place.key if place.meaning.key != TIME else column.meaning.key
            if key in found[i]:
                raise MeasurementFileError(twice(place.meaning.key, place.where))
            found[i][key] = column
    split: list[set[str]] = [set() for _ in tables]
    for number, pattern in enumerate(mapping.patterns):
        for i, index in _columns_of(tables, pattern).items():
            key = pattern_key(number)
            also = [w for w in pattern.words if w in found[i] or w in split[i]]
            if also:
                raise MeasurementFileError(twice(also[0], pattern.where))
            split[i] |= {*pattern.words}
            found[i][key] = Column(Meaning(key, pattern.column), index, tables[i].header[index])
    for name in mapping.keep:
        if not _gives(mapping, name):
            hits = {
                i: at
                for i, table in enumerate(tables)
                if (at := _named(table, name, str(mapping.path))) is not None
            }
            for i, index in hits.items():
                found[i][f"raw:{name}"] = Column(raw(name), index, tables[i].header[index])
            if not hits:
                nowhere = Place(raw(name), None, name, None, "", f"{mapping.path}: keep")
                raise MeasurementFileError(_not_found(tables, range(len(tables)), nowhere))
    return found


def pattern_key(number: int) -> str:
    """Key of the column that a pattern splits."""
    return f"pattern:{number}"


def _columns_of(tables: Sequence[Layout], pattern: Pattern) -> dict[int, int]:
    """The columns that a pattern splits, by file.

    Raises:
        MeasurementFileError: no file has it.
    """
    files = range(len(tables)) if pattern.file is None else [pattern.file - 1]
    hits = {
        i: at for i in files if (at := _named(tables[i], pattern.column, pattern.where)) is not None
    }
    if not hits:
        place = Place(raw(pattern.column), None, pattern.column, None, "", pattern.where)
        raise MeasurementFileError(_not_found(tables, files, place))
    return hits


def _gives(mapping: FieldMapping, word: str) -> bool:
    """Whether a mapping says where one of our words is."""
    return any(place.meaning.key == word for place in mapping.places) or any(
        word in pattern.words for pattern in mapping.patterns
    )


def _index(table: Layout, place: Place) -> int | None:
    """Where a column is in a file: by number, by name, or by name without the unit."""
    if isinstance(place.column, int):
        return place.column - 1 if place.column <= len(table.header) else None
    return _named(table, place.column, place.where)


def _named(table: Layout, name: str, where: str) -> int | None:
    """Where the column of this name is in a file."""
    wanted, there = _said(name), [_said(cell) for cell in table.header]
    for hits in (
        [i for i, cell in enumerate(table.header) if cell == name],
        [i for i, said in enumerate(there) if said == wanted],
        [i for i, said in enumerate(there) if wanted == (said[0], None)],
    ):
        if len(hits) > 1:
            raise MeasurementFileError(
                f"{where}: {table.file.path} has {len(hits)} columns {name!r}; give "
                "the number of the one that is meant"
            )
        if hits:
            return hits[0]
    return None


def _said(header: str) -> tuple[str, str | None]:
    """Name and unit of a header, alike for all ways to write them."""
    name, unit = split_header(header)
    return unicodedata.normalize("NFKC", name), None if unit is None else spelled(unit)


def _not_found(tables: Sequence[Layout], files: Sequence[int], place: Place) -> str:
    there = [name for i in files for name in tables[i].header if name]
    which = ", ".join(tables[i].file.path.name for i in files)
    if isinstance(place.column, int):
        most = max(len(tables[i].header) for i in files)
        return f"{place.where}: there is no column {place.column} in {which}, only {most}"
    nearest = difflib.get_close_matches(place.column, there, 6, 0.0)
    return (
        f"{place.where}: there is no column {place.column!r} in {which}; nearest to it are "
        f"{', '.join(map(repr, nearest))}"
    )


def _column(place: Place, index: int, header: str, named: bool) -> Column:
    unit = split_header(header)[1] if named else None
    if place.unit and unit and place.meaning.kind and spelled(unit) != spelled(place.unit):
        raise MeasurementFileError(
            f"{place.where}: the mapping says [{place.unit}], but the column is {header!r}; "
            "expected the same unit"
        )
    return column_of(place.meaning, index, header, place.unit or unit, place.where)


def completed(table: Table, mapping: FieldMapping) -> Table:
    """The table with the constants of a mapping, and one row for each marker.

    Raises:
        MeasurementFileError: a list of constants that does not fit the files.
    """
    for constant in mapping.constants:
        table = _with_constant(table, constant)
    return _unfolded(table, mapping.markers) if mapping.markers else table


def translated(cells: Cells, mapping: FieldMapping) -> Cells:
    """The cells of a file with our words for theirs."""
    words = {
        key: _translated(w, mapping.words.get(key.split("@")[0], {}))
        for key, w in cells.words.items()
    }
    return replace(cells, words=words)


def _translated(words: Words, ours: dict[str, str]) -> Words:
    """Our words for theirs; two of theirs may be one of ours."""
    if not ours:
        return words
    low = {theirs.lower(): word for theirs, word in ours.items()}
    known: dict[str, int] = {}
    new = [known.setdefault(low.get(name.lower(), name), len(known)) for name in words.names]
    return Words(np.array(new, dtype=np.int64)[words.codes], tuple(known))


def _with_constant(table: Table, constant: Constant) -> Table:
    source, values = table.sources[0], constant.values
    file = source.file
    if len(values) == 1:
        file = np.zeros(table.rows, dtype=np.int64)
    elif len(values) != len(source.paths):
        raise MeasurementFileError(
            f"{constant.where}: {len(values)} values for {constant.meaning.name!r}; expected one, "
            "or one for each of several files with the same columns"
        )
    key = constant.meaning.key
    if constant.meaning.kind:
        numbers = np.array([float(v) for v in values])[file]
        table = replace(table, numbers=table.numbers | {key: numbers})
        return table if len(values) > 1 else of_loaded(table, [key])
    known: dict[str, int] = {}
    codes = np.array([known.setdefault(str(v), len(known)) for v in values])[file]
    return replace(table, words=table.words | {key: Words(codes, tuple(known))})


def _unfolded(table: Table, markers: Sequence[str]) -> Table:
    """One row for each marker of a table with columns for each: all of a row's together."""
    k = len(markers)
    numbers, words = {}, {}
    for key in {name.split("@")[0]: None for name in table.numbers}:
        each = [table.numbers.get(f"{key}@{m}", table.numbers.get(key)) for m in markers]
        numbers[key] = np.column_stack([v for v in each if v is not None]).ravel()
    for key, word in table.words.items():
        if "@" not in key:
            words[key] = Words(np.repeat(word.codes, k), word.names)
    for key in {name.split("@")[0] for name in table.words if "@" in name}:
        known: dict[str, int] = {}
        codes = []
        for marker in markers:
            word = table.words[f"{key}@{marker}"]
            new = [known.setdefault(name, len(known)) for name in word.names]
            codes.append(np.array(new, dtype=np.int64)[word.codes])
        words[key] = Words(np.column_stack(codes).ravel(), tuple(known))
    words["marker"] = Words(np.tile(np.arange(k), table.rows), tuple(markers))
    sources = tuple(_folded_headers(source, k) for source in table.sources)
    return Table(numbers, words, sources, k * table.rows)


def _folded_headers(source: Source, k: int) -> Source:
    headers: dict[str, str] = {}
    for key, header in source.headers.items():
        bare = key.split("@")[0]
        headers[bare] = f"{headers[bare]} / {header}" if bare in headers else header
    return Source(source.paths, np.repeat(source.file, k), np.repeat(source.lines, k), headers)
