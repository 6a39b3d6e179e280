"""From files and a mapping to one table: what all readers of measurements have in common.

Every file is read by its own layout and its own columns; names are split and translated there.
Then rows are put below, beside or behind each other, chosen, and completed by what no column says.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import Cells, read_cells
from elastocal.files.measurements.columns import Column, columns_by_name
from elastocal.files.measurements.joined import joined, needs_none
from elastocal.files.measurements.mapped import (
    completed,
    mapped_columns,
    pattern_key,
    translated,
)
from elastocal.files.measurements.mapping import FieldMapping, read_mapping
from elastocal.files.measurements.patterns import split
from elastocal.files.measurements.planned import PlannedJoints, planned_at, with_planned
from elastocal.files.measurements.table import Table
from elastocal.files.tables.decoding import FileText, decoded
from elastocal.files.tables.layout import Layout, Style, layout
from elastocal.robot.chain import Robot


@dataclass(frozen=True)
class OpenFiles:
    """OpenFiles whose columns are known, and none of whose rows is read.

    Attributes:
        texts: Their texts.
        tables: Their layouts.
        columns: Their columns, by key.
        mapping: What says what the columns mean; None: their names do.
        planned: The plan that says the joints; None: a column does.
    """

    texts: tuple[FileText, ...]
    tables: tuple[Layout, ...]
    columns: tuple[dict[str, Column], ...]
    mapping: FieldMapping | None
    planned: PlannedJoints | None = None

    @property
    def keys(self) -> set[str]:
        """All quantities that there are, also those of markers, patterns and constants."""
        found = {key.split("@")[0] for some in self.columns for key in some}
        if self.mapping is not None:
            found |= {constant.meaning.key for constant in self.mapping.constants}
            found |= {"marker"} if self.mapping.markers else set()
            for i, pattern in enumerate(self.mapping.patterns):
                found |= {*pattern.words} if pattern_key(i) in found else set()
        return found | (set() if self.planned is None else self.planned.gives(found))

    @property
    def controller(self) -> bool | None:
        """Whether the joint values are those of the controller; None: they are the plan's."""
        if self.planned is not None:
            return None
        return self.mapping is not None and self.mapping.controller

    @property
    def free(self) -> list[str]:
        """Headers without a meaning."""
        return [
            name
            for table, some in zip(self.tables, self.columns, strict=True)
            for i, name in enumerate(table.header)
            if name and i not in {column.index for column in some.values()}
        ]

    @property
    def several(self) -> bool:
        """Whether they have columns of their own."""
        return not all(set(some) == set(self.columns[0]) for some in self.columns)

    @property
    def header(self) -> str:
        """Place of the header, for messages; all files where each has columns of its own."""
        if self.several:
            return ", ".join(str(table.file.path) for table in self.tables)
        return header_of(self.tables[0])

    @property
    def remarks(self) -> tuple[str, ...]:
        """What is odd about the texts."""
        said = [*(text.remark for text in self.texts), *(table.remark for table in self.tables)]
        return tuple(filter(None, said))

    @property
    def source(self) -> str:
        """What they are called together."""
        through = f" through {self.mapping.path}" if self.mapping else ""
        said = self.mapping is not None and self.mapping.plan is not None
        planned = f" with the joints of {self.planned.path}" if self.planned and not said else ""
        return ", ".join(str(table.file.path) for table in self.tables) + through + planned

    @property
    def sha256(self) -> str:
        """The hash of one file; of several, a mapping being one, the hash of their hashes."""
        digests = [text.sha256 for text in self.texts]
        digests += [self.mapping.sha256] if self.mapping else []
        digests += [self.planned.sha256] if self.planned else []
        if len(digests) == 1:
            return digests[0]
        return hashlib.sha256("".join(digests).encode()).hexdigest()

    def units(self) -> dict[str, str]:
        """Units of the columns, by key."""
        return {key: column.unit for some in self.columns for key, column in some.items()}

    def with_readings(self, read: Iterable[str]) -> tuple[str, ...]:
        """Hashes of the files that have a column of the keys `read`.

        Raises:
            MeasurementFileError: two of them have the same content.
        """
        wanted, first = {*read}, dict[str, Path]()
        for file, some in zip(self.texts, self.columns, strict=True):
            if any(column.meaning.key in wanted for column in some.values()):
                if file.sha256 in first:
                    raise MeasurementFileError(
                        f"{file.path}: has the content of {first[file.sha256]}, so its readings "
                        "would count twice"
                    )
                first[file.sha256] = file.path
        return tuple(first)


def opened(
    path: str | Path | Sequence[str | Path],
    robot: Robot,
    mapping: str | Path | None,
    plan: str | Path | None = None,
    *,
    rotation: bool = True,
    absolute: bool = False,
) -> OpenFiles:
    """The columns of files.

    Args:
        path: File or files.
        robot: Whose joints they have.
        mapping: Mapping file that says what foreign columns mean.
        plan: Plan whose joints and loads the experiments have by their numbers.
        rotation: Whether rotations mean something.
        absolute: Whether positions are absolute readings.

    Raises:
        MeasurementFileError: a file cannot be read, a column is not there or without unit.
    """
    paths = [Path(path)] if isinstance(path, (str, Path)) else [Path(p) for p in path]
    if not paths:
        raise MeasurementFileError("no measurement file is named")
    foreign = read_mapping(mapping, robot) if mapping is not None else None
    if foreign is not None and len(foreign.styles) > 1 and len(foreign.styles) != len(paths):
        many = f"{len(paths)} file{'s are' if len(paths) > 1 else ' is'}"
        raise MeasurementFileError(
            f"{foreign.path}: 'files' has {len(foreign.styles)} entries, one for each file in the "
            f"order in which they are named, but {many} named"
        )
    styles = [foreign.style(i) if foreign else Style() for i in range(len(paths))]
    texts = tuple(
        decoded(p, MeasurementFileError, style.encoding)
        for p, style in zip(paths, styles, strict=True)
    )
    tables = tuple(layout(text, style) for text, style in zip(texts, styles, strict=True))
    if foreign:
        columns = mapped_columns(tables, foreign)
    else:
        columns = [
            columns_by_name(t.header, robot, header_of(t), rotation=rotation, absolute=absolute)
            for t in tables
        ]
    if plan is None and foreign is not None and foreign.plan is not None:
        plan = foreign.path.parent / foreign.plan
    planned = None if plan is None else planned_at(Path(plan), robot)
    return OpenFiles(texts, tables, tuple(columns), foreign, planned)


def header_of(table: Layout) -> str:
    """Place of the header, for messages."""
    return f"{table.file.path}, line {table.first}"


def rows_of(files: OpenFiles) -> tuple[Table, list[str]]:
    """All rows as one table, and what is said of those that are left out.

    Raises:
        MeasurementFileError: a cell is wrong, rows do not belong together, a name that no pattern
            matches.
    """
    if files.mapping is None:
        every = [read_cells(t, c) for t, c in zip(files.tables, files.columns, strict=True)]
        table, remarks = joined(every, [()] * len(every), None)
    else:
        table, remarks = _through(files, files.mapping)
    if files.planned is not None:
        table = with_planned(table, files.planned, needs_none(table, files.mapping))
    return table, remarks


def _through(files: OpenFiles, mapping: FieldMapping) -> tuple[Table, list[str]]:
    """The rows as a mapping understands them."""
    every = []
    for i, (table, columns) in enumerate(zip(files.tables, files.columns, strict=True)):
        keep = {key: mapping.keep[key.removeprefix("raw:")] for key in columns if "raw:" in key}
        cells = read_cells(table, columns, mapping.style(i).decimal, keep)
        every.append(translated(_split(cells, mapping), mapping))
    joins = [mapping.join(i) for i in range(len(every))]
    if len(mapping.styles) == 1:  # nothing is said of each file
        joins = [
            () if {*c} == {*files.columns[0]} else j
            for c, j in zip(files.columns, joins, strict=True)
        ]
    rows, remarks = joined(every, joins, mapping)
    return completed(rows, mapping), remarks


def _split(cells: Cells, mapping: FieldMapping) -> Cells:
    """The cells with all names split."""
    for i, pattern in enumerate(mapping.patterns):
        if pattern_key(i) in cells.words:
            cells = split(cells, pattern_key(i), pattern)
    return cells


def used_alone(files: OpenFiles, optional: Iterable[str], without: Iterable[str] = ()) -> OpenFiles:
    """The files with some columns left out, and some whose cells may be empty, by bare keys."""
    may_lack, out = {*optional}, {*without}
    columns = tuple(
        {
            key: replace(column, optional=key.split("@")[0] in may_lack)
            for key, column in some.items()
            if key.split("@")[0] not in out
        }
        for some in files.columns
    )
    return replace(files, columns=columns)
