"""Plain tables read by whole columns; whatever is not plain is left to `cells`.

In: a table whose header is known. Out: the numbers and words that `cells` would find, to the last
bit. Nothing is refused here: `cells` reads a file again from which no plain table came, and finds
the line and the column.

The bytes of a block are searched once for what ends a cell and for decimal signs. The last sixteen
bytes of a number are two 64-bit words, out of which the decimal sign is shifted; their digits are
added up for all rows at once. Digits up to 2⁵³ over a power of ten up to 10²² are one division of
two exact numbers, so it is rounded as `float` rounds. Source: Clinger, How to read floating point
numbers accurately (1990), for the division; the rest is ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import as_strided
from numpy.typing import NDArray

from elastocal.arrays import Array, IntArray
from elastocal.errors import InputError
from elastocal.files.measurements.columns import Column
from elastocal.files.tables.layout import Layout
from elastocal.files.tables.numbers import LARGEST, numbers_of, plain

LEAST = 4000
"""Characters from which whole columns are faster than cell by cell."""
_BLOCK = 1 << 18  # characters; what stays in the cache
_MARGIN = b" " * 16  # around a block: a cell may be loaded from before its beginning
_EXACT = 1 << 53  # integers up to it are exact as floats
_NEWLINE, _SPACE, _MINUS, _PLUS = b"\n -+"

Loads = NDArray[np.uint64]


@dataclass(frozen=True)
class _Block:
    """Cells of R rows of a table.

    Attributes:
        raw: The bytes, with a margin.
        start: (width, R) where each cell begins.
        point: (width, R) where its decimal sign is, or its end if it has none.
        end: (width, R) behind its last byte.
        lines: (R,) line of each row, counted from the first of the block as zero.
        count: Lines in the block, blank ones too.
    """

    raw: bytes
    start: IntArray
    point: IntArray
    end: IntArray
    lines: IntArray
    count: int

    @cached_property
    def data(self) -> NDArray[np.uint8]:
        """The bytes as numbers."""
        return np.frombuffer(self.raw, dtype=np.uint8)

    @cached_property
    def loads(self) -> Loads:
        """Eight bytes from each place on as one number, the first of them lowest."""
        return as_strided(self.data[:8].view("<u8"), (len(self.raw) - 7,), (1,), writeable=False)

    def texts(self, column: int, rows: IntArray) -> list[str]:
        """The cells of some rows."""
        raw, ends = self.raw, self.end[column, rows].tolist()
        return [
            raw[a:b].decode() for a, b in zip(self.start[column, rows].tolist(), ends, strict=True)
        ]


def plain_columns(
    table: Layout, columns: dict[str, Column], decimal: str
) -> tuple[IntArray, dict[str, Any]] | None:
    """Lines (R,) and columns of a plain table: numbers in SI units, (codes, names) for words.

    None if the table is small or not plain: with quotes, comments, cells apart by spaces, rows of
    different lengths, or anything that `cells` would refuse.
    """
    text, start = table.file.text, table.start
    if table.delimiter in (" ", decimal) or len(text) - start < LEAST:
        return None
    if text.find('"', start) >= 0 or not table.plain:
        return None
    if not any(column.meaning.kind and not column.optional for column in columns.values()):
        return None  # rows of nothing but delimiters would not be noticed
    numeric = {key: column for key, column in columns.items() if column.meaning.kind}
    known: dict[str, dict[str, int]] = {key: {} for key in columns if key not in numeric}
    lines, numbers = [], []
    codes: dict[str, list[IntArray]] = {key: [] for key in known}
    line = table.first + 1
    for body in _bodies(text, start):
        block = _block(body, table.delimiter.encode(), decimal.encode(), len(table.header))
        values = None if block is None else _numbers(block, list(numeric.values()), decimal)
        if block is None or values is None:
            return None
        numbers.append(values)
        for key, names in known.items():
            codes[key].append(_words(block, columns[key].index, names))
        lines.append(block.lines + line)
        line += block.count
    if not sum(map(len, lines)):
        return None
    found: dict[str, Any] = dict(zip(numeric, np.concatenate(numbers, axis=1), strict=True))
    found |= {key: (np.concatenate(codes[key]), tuple(names)) for key, names in known.items()}
    return np.concatenate(lines), {key: found[key] for key in columns}


def _bodies(text: str, start: int) -> Iterator[bytes]:
    """The text from `start` on as blocks of whole lines."""
    while start < len(text):
        end = text.find("\n", start + _BLOCK) + 1 or len(text)
        yield text[start:end].encode()
        start = end


def _block(body: bytes, delimiter: bytes, decimal: bytes, width: int) -> _Block | None:
    """Where the cells are; None if a row has more or fewer than `width`."""
    raw = _MARGIN + body + (_MARGIN if body.endswith(b"\n") else b"\n" + _MARGIN)
    data = np.frombuffer(raw, dtype=np.uint8)
    inside = data[len(_MARGIN) : -len(_MARGIN)]
    is_point, is_line = inside == decimal[0], inside == _NEWLINE
    marks = np.flatnonzero((inside == delimiter[0]) | is_point | is_line)
    points = is_point[marks]
    ends = marks[~points]
    last = is_line[ends]
    # The sign after n ends is in cell n; of two in one cell the last counts, and is found wrong.
    point = ends.copy()
    point[np.cumsum(~points)[points]] = marks[points]
    start = np.concatenate([[0], ends[:-1] + 1])
    blank = last & (start == ends)
    blank[1:] &= last[:-1]
    line = np.cumsum(last) - 1
    if blank.any():
        start, point, ends, last, line = (each[~blank] for each in (start, point, ends, last, line))
    if len(ends) % width or np.count_nonzero(last) * width != len(ends):
        return None
    if not last[width - 1 :: width].all():
        return None
    start, point, end = (
        np.ascontiguousarray(each.reshape(-1, width).T) + len(_MARGIN)
        for each in (start, point, ends)
    )
    return _Block(raw, start, point, end, line[width - 1 :: width], int(np.count_nonzero(is_line)))


def _numbers(block: _Block, columns: list[Column], decimal: str) -> Array | None:
    """(k, R) numbers of some columns in SI units, or None if a cell has none that may be there.

    NaN where an optional cell is empty.
    """
    chosen = [column.index for column in columns]
    start, point, end = block.start[chosen], block.point[chosen], block.end[chosen]
    first = block.data[start]
    while ((first == _SPACE) & (start < end)).any():
        start += (first == _SPACE) & (start < end)
        first = block.data[start]
    negative = first == _MINUS
    start += negative | (first == _PLUS)
    behind = end - point  # one more than the decimal places, or zero
    count = end - start
    count -= behind > 0
    # Of the sixteen last bytes those before the decimal sign move one place on.
    low, high = block.loads[end - 8], block.loads[end - 16]
    kept = _LAST.take(behind - 1, mode="clip")
    kept[behind == 0] = _ALL
    moved = low << _BYTE
    moved |= high >> np.uint64(56)
    low = _chosen(kept, low, moved)
    kept = _LAST.take(behind - 9, mode="clip")
    kept[behind == 0] = _ALL
    high = _chosen(kept, high, high << _BYTE)
    wrong = _into_digits(low, _LAST.take(count, mode="clip"))
    wrong |= _into_digits(high, _LAST.take(count - 8, mode="clip"))
    low += high * np.uint64(10**8)
    good = (wrong & _HIGHEST) == 0
    good &= low <= np.uint64(_EXACT)
    good &= (count > 0) & (count <= 16)
    values = low.astype(np.float64)
    values /= _POWERS.take(behind, mode="clip")
    np.negative(values, out=values, where=negative)
    for row in np.flatnonzero(~good.all(axis=1)).tolist():
        if not _odd_cells(block, columns[row], decimal, np.flatnonzero(~good[row]), values[row]):
            return None
    if (np.abs(values) >= LARGEST).any():
        return None
    values *= [[column.factor] for column in columns]
    return values


def _odd_cells(block: _Block, column: Column, decimal: str, rows: IntArray, values: Array) -> bool:
    """Put what cells of other forms say into the `values` of a column; False if one is wrong."""
    cells = block.texts(column.index, rows)
    empty = np.array([column.optional and not cell.strip() for cell in cells])
    values[rows[empty]] = np.nan
    try:
        values[rows[~empty]] = numbers_of(
            [cell for cell, no in zip(cells, empty, strict=True) if not no],
            decimal,
            str,
            InputError,
        )
    except InputError:
        return False
    return True


_ALL, _BYTE = np.uint64((1 << 64) - 1), np.uint64(8)
_LAST = np.array([(1 << 64) - (1 << 8 * (8 - n)) for n in range(9)], dtype=np.uint64)
"""The last n bytes of eight."""
_FIRST = np.array([(1 << 8 * n) - 1 for n in range(9)], dtype=np.uint64)
"""The first n bytes of eight."""
_POWERS = np.array([1.0, *(10.0**n for n in range(17))])
"""What digits are divided by, if the decimal sign stands so many bytes before the end."""
_ZEROS, _BEYOND_NINE, _HIGHEST = (np.uint64(0x0101010101010101 * n) for n in (0x30, 0x76, 0x80))
_PAIRS = [
    (np.uint64(1 + (10 << 8)), np.uint64(8), np.uint64(0x00FF00FF00FF00FF)),
    (np.uint64(1 + (100 << 16)), np.uint64(16), np.uint64(0x0000FFFF0000FFFF)),
    (np.uint64(1 + (10_000 << 32)), np.uint64(32), np.uint64(0x00000000FFFFFFFF)),
]


def _chosen(mask: Loads, here: Loads, there: Loads) -> Loads:
    """The bits of `here` where the mask is set, else those of `there`, which is overwritten."""
    there ^= here
    there &= ~mask
    there ^= here
    return there


def _into_digits(loads: Loads, mask: Loads) -> Loads:
    """Make of loads the values of their digits; the highest bit is set of a byte that is none."""
    loads ^= _ZEROS
    loads &= mask
    wrong = loads + _BEYOND_NINE
    wrong |= loads
    for factor, half, kept in _PAIRS:  # neighbours of one, two and four digits become one number
        loads *= factor
        loads >>= half
        loads &= kept
    return wrong


def _words(block: _Block, column: int, known: dict[str, int]) -> IntArray:
    """(R,) numbers of the words of a column; new words are added to the `known` ones."""
    start, size = block.start[column], block.end[column] - block.start[column]
    if not len(size):
        return np.zeros(0, dtype=np.int64)
    if size.max() > 8:
        return _numbered(block.texts(column, np.arange(len(size))), known)
    key = block.loads[start] & _FIRST[size]
    head = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    _, first, same = np.unique(key[head], return_index=True, return_inverse=True)
    order = np.argsort(first)
    code = np.empty(len(first), dtype=np.int64)
    code[order] = _numbered(block.texts(column, head[first[order]]), known)
    return np.asarray(np.repeat(code[same], np.diff(np.append(head, len(key)))))


def _numbered(texts: list[str], known: dict[str, int]) -> IntArray:
    """Numbers of words; those that are new get the next ones."""
    together = "".join(texts)
    if " " in together or "'" in together or not together.isprintable():
        texts = [plain(text) for text in texts]
    # Most often all are new but the first: the experiment that the block before ended with.
    old = [known[text] for text in texts[:1] if text in known]
    new = texts[len(old) :]
    if len({*new}) == len(new) and known.keys().isdisjoint(new):
        codes = range(len(known), len(known) + len(new))
        known.update(zip(new, codes, strict=True))
        return np.array([*old, *codes], dtype=np.int64)
    return np.array([known.setdefault(text, len(known)) for text in texts], dtype=np.int64)
