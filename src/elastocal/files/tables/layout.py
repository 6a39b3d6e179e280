"""Layout of a table in text: delimiter, header, where the data begin."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import TYPE_CHECKING

from elastocal.files.tables.decoding import FileText

if TYPE_CHECKING:
    import _csv

DELIMITERS = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar"}
WIDEST = 10_000
_NUMBER = re.compile(r"\s*'?[-+−]?[\d.,]+([eE][-+]?\d+)?\s*")
_VERSION = re.compile(r"#\s*elastocal measurements, version (\S+)")
COMMENTS = ("#", "//")
"""What comment lines begin with, if nobody says otherwise."""
_SEPARATOR = re.compile(r"""\s*["']?sep\s*= *(\\t|tab|[^\s"']|\t)["']?[\s,;|]*""", re.IGNORECASE)
"""What Excel writes and reads in front of a table: sep=; for example."""


@dataclass(frozen=True)
class Style:
    """How a file is written, as far as somebody says so; None: found out.

    Attributes:
        delimiter: Between cells; " " stands for any run of spaces.
        decimal: Decimal sign, "." or ",".
        encoding: Encoding of the text.
        skip_lines: Lines before the header that mean nothing.
        header: Whether there is a header.
        comments: What comment lines begin with.
    """

    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    skip_lines: int = 0
    header: bool = True
    comments: tuple[str, ...] = COMMENTS


@dataclass(frozen=True)
class Layout:
    """A file whose header is known.

    Attributes:
        file: Its text.
        delimiter: Between cells.
        header: Names of the columns, as written, single spaces; numbers if there is no header.
        first: Index of the first line of data in `lines`.
        start: Where it begins in the text.
        remark: What is odd about comments and the end, empty if nothing is.
        comments: What comment lines begin with.
    """

    file: FileText
    delimiter: str
    header: tuple[str, ...]
    first: int
    start: int
    remark: str = ""
    comments: tuple[str, ...] = COMMENTS

    @cached_property
    def lines(self) -> list[str]:
        """Its lines; comments are empty. Made when first asked for: large files do without."""
        lines = self.file.text.split("\n")
        if not any(begin in self.file.text for begin in self.comments):
            return lines
        return ["" if is_comment(line, self.comments) else line for line in lines]

    @property
    def plain(self) -> bool:
        """Whether no line of data can be a comment."""
        return not any(_comment_within(self.file.text, b, self.start) for b in self.comments)

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """(line, cells) of every row of data that is not blank.

        Raises:
            InputError: a quote that is not closed, a row with more or fewer cells.
        """
        path, width = self.file.path, len(self.header)
        last = len(self.lines)
        reader = _reader(islice(self.lines, self.first, None), self.delimiter)
        begun = 0
        try:
            for row in reader:
                line, begun = self.first + begun + 1, reader.line_num
                if self.delimiter == " ":
                    row = [cell for cell in row if cell]
                if len(row) != width:
                    row = self._mended(row, line, begun + self.first, last)
                if any(row) and any(cell.strip() for cell in row):
                    yield line, row
        except csv.Error as error:
            raise self.file.error(
                f"{path}, line {self.first + reader.line_num}: not a table: {error}"
            ) from None

    def _mended(self, row: list[str], line: int, end: int, last: int) -> list[str]:
        """The row without empty cells at its end, if that makes its length right."""
        width = len(self.header)
        if not any(cell.strip() for cell in row):
            return []
        if not any(cell.strip() for cell in row[width:]) and len(row) >= width:
            return row[:width]
        where = f"{self.file.path}, line {line}"
        if end > line:
            raise self.file.error(f"{where}: a quote that opens here is not closed")
        unended = end == last and self.lines[-1] != ""
        if len(row) < width and unended:
            raise self.file.error(
                f"{where}: the last line is only half written, {len(row)} of {width} cells; "
                "complete or delete it"
            )
        hint = ""
        if self.delimiter == "," and len(row) > width:
            hint = "; if commas are decimal signs here, the delimiter must be a semicolon or tab"
        raise self.file.error(f"{where}: {len(row)} cells where the header has {width}{hint}")


def _reader(lines: Iterable[str], delimiter: str) -> _csv.Reader:
    return csv.reader(lines, delimiter=delimiter, skipinitialspace=delimiter != " ")


def layout(file: FileText, style: Style) -> Layout:
    """Find delimiter and header.

    Raises:
        InputError: no header, or no data below it.
    """
    text = file.text
    _check_version(file, list(islice(_lines(text), 5)))
    begins = style.comments
    lines = _head(text, style)
    named = _named_delimiter(file, lines, style)
    for i in range(min(style.skip_lines, len(lines))):
        lines[i] = ""
    first = _first(lines)
    if first is None:
        raise file.error(f"{file.path}: no table in it, only comments or blank lines")
    delimiter = style.delimiter or named or _delimiter(lines[first])
    cells = _cells(lines[first], delimiter)
    while len(cells) > 1 and not cells[-1]:
        cells.pop()
    if len(cells) == 1 and lines[first].count("[") > 1:
        raise file.error(
            f"{file.path}, line {first + 1}: the header is one cell, {cells[0][:60]!r}; expected "
            f"its columns apart, by {', '.join(f'{name}s' for name in DELIMITERS.values())}"
            + (f", and not by {DELIMITERS[delimiter]}s alone" if named else "")
        )
    if len(cells) > WIDEST:
        raise file.error(
            f"{file.path}, line {first + 1}: {len(cells)} columns, more than the {WIDEST} "
            "that are read"
        )
    if not style.header:
        names = tuple(str(i + 1) for i in range(len(cells)))
        return Layout(file, delimiter, names, first, _start_of(text, first), comments=begins)
    if all(_NUMBER.fullmatch(cell) for cell in cells):
        there = next((begin for begin in begins if begin in text), "")
        why = f" (comments beginning with {there} are left out)" if there else ""
        raise file.error(
            f"{file.path}, line {first + 1}: numbers where the names of the columns belong{why}; "
            "expected a header such as 'experiment,marker,A1 [deg],...'"
        )
    start = _start_of(text, first + 1)
    if not any(_says_something(line, begins) for line in _lines(text, start)):
        raise file.error(f"{file.path}: there is a header, but no row of data below it")
    remark = "; ".join(_oddities(file, delimiter, len(cells), first, start, begins))
    return Layout(file, delimiter, tuple(cells), first + 1, start, remark, begins)


def _lines(text: str, start: int = 0) -> Iterator[str]:
    """The lines from a place in the text on, one after the other."""
    while start <= len(text):
        end = text.find("\n", start)
        end = end if end >= 0 else len(text)
        yield text[start:end]
        start = end + 1


def _start_of(text: str, line: int) -> int:
    """Where the line with this index begins."""
    return min(sum(len(above) + 1 for above in islice(_lines(text), line)), len(text))


def _head(text: str, style: Style) -> list[str]:
    """The lines down to the header, comments empty."""
    head: list[str] = []
    for line in _lines(text):
        head.append("" if is_comment(line, style.comments) else line)
        said = _says_something(line, style.comments) and not _SEPARATOR.fullmatch(line)
        if len(head) > style.skip_lines and said:
            break
    return head


def _says_something(line: str, comments: tuple[str, ...]) -> bool:
    """Whether there is more in a line than delimiters, and it is no comment."""
    return bool(line.strip(" \t,;|\"'")) and not is_comment(line, comments)


def _first(lines: list[str]) -> int | None:
    """Index of the first line with something in it."""
    return next((i for i, line in enumerate(lines) if line.strip(" \t,;|\"'")), None)


def _named_delimiter(file: FileText, lines: list[str], style: Style) -> str | None:
    """The delimiter that a line such as sep=; names before all others; that line is blanked.

    Raises:
        InputError: another delimiter than is asked for, or one that none of these files has.
    """
    first = _first(lines)
    found = _SEPARATOR.fullmatch(lines[first or 0])
    if first is None or found is None:
        return None
    lines[first] = ""
    named = "\t" if found[1].lower() in ("\\t", "tab") else found[1]
    where = f"{file.path}, line {first + 1}"
    if named not in DELIMITERS:
        raise file.error(
            f"{where}: cells are separated by {named!r} as this line says; expected one of "
            f"{', '.join(f'{name}s' for name in DELIMITERS.values())}"
        )
    if style.delimiter not in (None, named):
        asked = {**DELIMITERS, " ": "space"}[style.delimiter]
        raise file.error(
            f"{where}: cells are separated by {DELIMITERS[named]}s as this line says, but the "
            f"mapping says {asked}"
        )
    return named


def is_comment(line: str, comments: tuple[str, ...]) -> bool:
    """Whether a line begins as comments do."""
    return line.lstrip().startswith(comments)


def _comment_within(text: str, begin: str, start: int) -> bool:
    """Whether a line from `start` on may begin with this."""
    if text.find(begin, start) < 0:
        return False
    return len(begin) == 1 or bool(re.search(rf"^\s*{re.escape(begin)}", text[start:], re.M))


def _oddities(
    file: FileText, delimiter: str, width: int, first: int, start: int, comments: tuple[str, ...]
) -> Iterator[str]:
    """What is odd about rows that are commented out, and about the end."""
    text = file.text
    for begin in comments if width > 1 else ():
        if text.find(begin, start) < 0:
            continue
        rows = [
            number
            for number, line in enumerate(_lines(text, start), first + 2)
            if line.count(delimiter) >= width - 1 and is_comment(line, (begin,))
        ]
        if rows:
            yield (
                f"{file.path.name}, line {rows[0]}: what begins with {begin} is left out "
                f"as a comment, but has the cells of a row ({len(rows)} such lines)"
            )
    last = text[text.rfind("\n") + 1 :]
    if last and not is_comment(last, comments):
        number = text.count("\n") + 1
        if number > first + 2:
            yield (
                f"{file.path.name}, line {number}: the last line has no line end: is its last "
                "number complete?"
            )


def _check_version(file: FileText, lines: list[str]) -> None:
    for number, line in enumerate(lines, 1):
        found = _VERSION.match(line.strip())
        if found and found[1] != "1":
            raise file.error(
                f"{file.path}, line {number}: format version {found[1]!r} is not known; this "
                "program reads 1"
            )


def _delimiter(header: str) -> str:
    """The delimiter of which the header has most, outside quotes and brackets."""
    bare = re.sub(r'"[^"]*"|\[[^\]]*\]', "", header)
    return max(DELIMITERS, key=bare.count)


def _cells(line: str, delimiter: str) -> list[str]:
    try:
        row = next(_reader([line], delimiter), [])
    except csv.Error:
        row = line.split(delimiter)
    if delimiter == " ":
        row = [cell for cell in row if cell]
    return [" ".join(cell.split()).removeprefix("'").strip() for cell in row]
