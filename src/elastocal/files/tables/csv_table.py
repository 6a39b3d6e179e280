"""Small tables of numbers in CSV with units in the header; errors say line and column."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.files.tables.decoding import decoded
from elastocal.files.tables.layout import Style, layout
from elastocal.files.tables.numbers import decimal_in, numbers_of, plain
from elastocal.files.tables.units import UNITS, spelled, split_header
from elastocal.names import flaw

ANGLES, LENGTHS = UNITS["angle"], UNITS["length"]
FORCES, TORQUES = UNITS["force"], UNITS["torque"]
PLAIN = {"": 1.0, "-": 1.0}
_ENDINGS = (".csv", ".tsv", ".tab", ".txt")


@dataclass(frozen=True)
class TextTable:
    """A table whose cells are still text.

    Attributes:
        path: File it comes from.
        sha256: Hash of its bytes.
        header_line: Line of the header.
        columns: Name of every column with its unit, empty if it has none.
        rows: Line number and cells of every row that is not blank.
        decimal: Decimal sign.
        error: What to raise if something is wrong.
        shows_units: Whether messages call a column by its name and unit.
    """

    path: Path
    sha256: str
    header_line: int
    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[int, tuple[str, ...]], ...]
    decimal: str
    error: type[InputError]
    shows_units: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns without their units."""
        return tuple(name for name, _ in self.columns)

    def text(self, name: str) -> list[str]:
        """The cells of a column as they are, without the apostrophe of spreadsheets: names.

        Raises:
            InputError: of the type `error`: a cell cannot be one, see `names.flaw`.
        """
        index = self.names.index(name)
        found = [plain(cells[index]) for _, cells in self.rows]
        for (line, _), word in zip(self.rows, found, strict=True):
            if wrong := flaw(word):
                raise self.error(f"{self.path}, line {line}, column {name!r}: {wrong}")
        return found

    def numbers(self, names: Sequence[str], units: Mapping[str, float]) -> Array:
        """(rows, len(names)) numbers of columns of one kind, in SI.

        Args:
            names: Columns that are there.
            units: Factor to SI of every unit that they may have.

        Raises:
            InputError: of the type `error`: a unit is missing or of another kind, a cell is no
                finite number.
        """
        result = np.zeros((len(self.rows), len(names)))
        for j, name in enumerate(names):
            index = self.names.index(name)
            written = self.columns[index][1]
            unit = spelled(written)
            if unit not in units:
                known = "no unit" if "" in units else f"one of the units {', '.join(units)}"
                raise self.error(
                    f"{self.path}, line {self.header_line}, column {name!r}: expected {known}, "
                    f"found {f'[{written}]' if written else 'none'}"
                )
            shown = f"{name} [{written}]" if written and self.shows_units else name

            def where(i: int, shown: str = shown) -> str:
                return f"{self.path}, line {self.rows[i][0]}, column {shown!r}"

            cells = [cells[index] for _, cells in self.rows]
            result[:, j] = units[unit] * numbers_of(cells, self.decimal, where, self.error)
        return result


def is_table(path: Path) -> bool:
    """Whether a file is a table, by the ending of its name."""
    return path.suffix.lower() in _ENDINGS


def read_table(path: Path, error: type[InputError], *, shows_units: bool = False) -> TextTable:
    """The table in a text file; delimiters and encodings as in measurement files.

    A comma is the decimal sign where it does not separate cells and numbers have it.

    Raises:
        InputError: of the type `error`: no table, no rows, rows of another length than the header,
            a column twice.
    """
    file = decoded(path, error)
    plan = layout(file, Style())
    rows = tuple((line, tuple(map(str.strip, row))) for line, row in plan.rows())
    columns = tuple((name, unit or "") for name, unit in map(split_header, plan.header))
    names = [name for name, _ in columns]
    for name in names:
        if name and names.count(name) > 1:
            raise error(f"{path}, line {plan.first}: column {name!r} is there twice")
    # A comma in a cell needs another delimiter, or quotes: else there is no cell to look at.
    possible = "," in file.text and (plan.delimiter != "," or '"' in file.text)
    commas = possible and any(
        "," in cell and decimal_in(cell, plan.delimiter) for _, row in rows for cell in row
    )
    decimal = "," if commas else "."
    return TextTable(path, file.sha256, plan.first, columns, rows, decimal, error, shows_units)
