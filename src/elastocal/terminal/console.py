"""Consoles, tables, and how numbers are written."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from copy import copy
from dataclasses import replace
from typing import IO, Any

import numpy as np
from rich.console import Console, ConsoleOptions, RenderableType
from rich.measure import Measurement
from rich.segment import Segment
from rich.table import Table
from rich.text import TextType

from elastocal.arrays import Array
from elastocal.terminal.plain import visible
from elastocal.wording.numbers import shown_unit


class _SafeConsole(Console):
    """Steers the terminal itself, and lets no text of others do it."""

    @property
    def file(self) -> IO[str]:
        """The stream that takes what rich writes as it is."""
        file: Any = super().file
        return getattr(file, "rich_proxied_file", file)

    @file.setter
    def file(self, file: IO[str]) -> None:
        self._file = file

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """What rich makes of it, with texts as they are safe to show."""
        for part in super().render(renderable, options):
            yield part if part.control else part._replace(text=visible(part.text))


out = _SafeConsole(highlight=False, soft_wrap=False)
err = _SafeConsole(stderr=True, highlight=False)


def whole(table: Table) -> None:
    """Print a table without cutting numbers off.

    One that is too wide for a terminal comes in parts, each with the first column; in a file a row
    stays a line.
    """
    narrow = out.is_terminal or "COLUMNS" in os.environ
    for part in _parts(table) if narrow and _width(table) > out.width else [table]:
        # A console never prints wider than itself, whatever it is told.
        wide = _SafeConsole(file=out.file, width=max(out.width, _width(part)), highlight=False)
        wide.print(part, crop=False, no_wrap=True, overflow="ignore", soft_wrap=True)


def _width(table: Table) -> int:
    room = out.options.update(width=1000, max_width=1000)
    return Measurement.get(out, room, table).maximum


def _parts(table: Table) -> Iterator[Table]:
    """The columns one after the other, as many as find room beside the first."""
    left = list(range(1, len(table.columns)))
    title = table.title
    while left:
        count = len(left)
        while count > 1 and (
            _width(_some(table, left[:count], title)) > out.width
            or _is_unit(table, left[count : count + 1])
        ):
            count -= 1
        yield _some(table, left[:count], title)
        left, title = left[count:], None


def _is_unit(table: Table, columns: list[int]) -> bool:
    """Whether a column, if there is one, is that of the units of the one before."""
    return any(str(table.columns[i].header) == "unit" for i in columns)


def _some(table: Table, columns: list[int], title: TextType | None) -> Table:
    """The first column of a table and some others."""
    part = copy(table)
    chosen = [table.columns[i] for i in (0, *columns)]
    part.title, part.columns = title, [replace(c, _index=i) for i, c in enumerate(chosen)]
    return part


def numbers(vector: Array) -> str:
    """Numbers of a vector, five digits each; what is rounding beside the largest is 0."""
    rounding = 1e-9 * np.abs(vector).max(initial=0.0)
    return " ".join(f"{value if abs(value) > rounding else 0.0:.5g}" for value in vector)


def micrometres(value: float, si: str = "m") -> str:
    """A length in micrometres, or millimetres if it is large, with four digits; so angles [rad]."""
    factor, unit = shown_unit(si, [abs(value)])
    return f"{factor * value:.4g} {unit}" if np.isfinite(value) else "∞"
