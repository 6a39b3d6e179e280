"""Small tables of numbers in CSV with units in the header; errors say line and column."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import PathFileError
from elastocal.io.files import read_text

ANGLES = {"deg": np.pi / 180.0, "°": np.pi / 180.0, "rad": 1.0}
LENGTHS = {"mm": 1e-3, "m": 1.0}
FORCES = {"N": 1.0, "kN": 1e3}
TORQUES = {"N.m": 1.0, "N·m": 1.0, "Nm": 1.0}
PLAIN = {"": 1.0, "-": 1.0}

_LARGEST = 1e12


@dataclass(frozen=True)
class Table:
    """A table whose cells are still text.

    Attributes:
        path: File it comes from.
        header_line: Line of the header.
        columns: Name of every column with its unit, empty if it has none.
        rows: Line number and cells of every row that is not blank.
        decimal_comma: Whether a comma is the decimal sign.
    """

    path: Path
    header_line: int
    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[int, tuple[str, ...]], ...]
    decimal_comma: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns without their units."""
        return tuple(name for name, _ in self.columns)

    def text(self, name: str) -> list[str]:
        """The cells of a column as they are."""
        index = self.names.index(name)
        return [cells[index] for _, cells in self.rows]

    def numbers(self, names: Sequence[str], units: Mapping[str, float]) -> Array:
        """(rows, len(names)) numbers of columns of one kind, in SI.

        Args:
            names: Columns that are there.
            units: Factor to SI of every unit that they may have.

        Raises:
            PathFileError: a unit is missing or of another kind, a cell is no finite number.
        """
        result = np.zeros((len(self.rows), len(names)))
        for j, name in enumerate(names):
            index = self.names.index(name)
            unit = self.columns[index][1]
            if unit not in units:
                known = " or ".join(f"[{u}]" for u in units if u not in ("°", "N·m", "Nm", "-"))
                found = f"[{unit}]" if unit else "none"
                raise PathFileError(
                    f"{self.path}, line {self.header_line}, column {name!r}: expected the unit "
                    f"{known or 'to be left out'}, found {found}"
                )
            for i, (line, cells) in enumerate(self.rows):
                where = f"{self.path}, line {line}, column {name!r}"
                result[i, j] = units[unit] * self._number(cells[index], where)
        return result

    def _number(self, cell: str, where: str) -> float:
        try:
            value = float(cell.replace(",", ".") if self.decimal_comma else cell)
        except ValueError:
            raise PathFileError(f"{where}: expected a number, found {cell[:40]!r}") from None
        if not abs(value) < _LARGEST:
            raise PathFileError(f"{where}: expected a finite number, found {cell[:40]!r}")
        return value


def read_table(path: Path) -> Table:
    """The table in a CSV file; separated by commas, or by semicolons with decimal commas or points.

    Raises:
        PathFileError: no table, no rows, rows of another length than the header, a column twice.
    """
    text = read_text(path)
    first = next((line for line in text.splitlines() if line.strip()), "")
    separator = ";" if ";" in first else ","
    try:
        reader = csv.reader(io.StringIO(text, newline=None), delimiter=separator)
        lines = [(reader.line_num, [cell.strip() for cell in row]) for row in reader]
    except csv.Error as error:
        raise PathFileError(f"{path}: not a table of separated values: {error}") from None
    filled = [(line, row) for line, row in lines if any(row)]
    if len(filled) < 2:
        raise PathFileError(f"{path}: expected a header and at least one row of numbers")
    header_line, header = filled[0]
    for line, row in filled[1:]:
        if len(row) != len(header):
            raise PathFileError(
                f"{path}, line {line}: {len(row)} cells where the header has {len(header)}"
            )
    columns = tuple(_named(cell) for cell in header)
    names = [name for name, _ in columns]
    for name in names:
        if name and names.count(name) > 1:
            raise PathFileError(f"{path}, line {header_line}: column {name!r} is there twice")
    rows = tuple((line, tuple(row)) for line, row in filled[1:])
    return Table(path, header_line, columns, rows, separator == ";")


def _named(cell: str) -> tuple[str, str]:
    """Name and unit of a header such as 'A1 [deg]'."""
    found = re.fullmatch(r"(.*?)\s*\[([^\]]*)\]", " ".join(cell.split()))
    return (found[1], found[2].strip()) if found else (" ".join(cell.split()), "")
