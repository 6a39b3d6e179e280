"""Text patterns that split the words of one column: "P01 T1 loaded" is pose, reflector and state.

Regular expressions of Python, of which those are refused whose search may never end: repeats of
what repeats or chooses, and many open repeats. With them, and with short cells, the steps are
bounded by a power of the length.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import Cells, Words
from elastocal.files.measurements.columns import PLACES, WORDS

SPLIT = (*WORDS, *PLACES)
"""Words that a pattern may find."""
LONGEST_CELL = 100  # characters
_MOST_OPEN, _MOST = 6, 16
"""Repeats without a near end, and repeats of any kind, in one pattern."""
_NEAR = 9  # times; repeats up to it have a near end
_QUANTIFIER = re.compile(r"[*+?]|\{(\d*)(,?)(\d*)\}")


@dataclass(frozen=True)
class Pattern:
    """How the words of a column are split.

    Attributes:
        column: Name or number of the column.
        file: Number of the file from 1; None for any that has it.
        tried: Expressions, of which the first counts that matches a whole cell.
        where: Place in the mapping file.
    """

    column: str
    file: int | None
    tried: tuple[re.Pattern[str], ...]
    where: str

    @property
    def words(self) -> tuple[str, ...]:
        """What it finds."""
        return tuple(dict.fromkeys(name for one in self.tried for name in one.groupindex))


def pattern_of(text: str, where: str) -> re.Pattern[str]:
    """An expression that can be searched in short time, with named groups for our words.

    Raises:
        MeasurementFileError: it is none, or has other names, or its search may not end.
    """
    try:
        found = re.compile(text)
    except (re.error, RecursionError, OverflowError) as error:
        raise MeasurementFileError(
            f"{where}: {text[:60]!r} is no regular expression: {error}"
        ) from None
    others = [name for name in found.groupindex if name not in SPLIT]
    if others or not found.groupindex:
        what = f"a group {others[0]!r}" if others else "none"
        raise MeasurementFileError(
            f"{where}: a pattern has named groups such as (?P<experiment>\\d+), of "
            f"{', '.join(SPLIT)}; found {what} in {text[:60]!r}"
        )
    if wrong := _endless(text):
        raise MeasurementFileError(
            f"{where}: {text[:60]!r} has {wrong}, with which a search may take for ever; expected "
            "a plainer pattern"
        )
    return found


def _endless(text: str) -> str:
    """What may make the search long, empty if nothing does."""
    bare = re.sub(r"\\.", "a", text)  # an escaped sign is one sign
    bare = re.sub(r"\[\^?\]?[^\]]*\]", "a", bare)  # and so is a set
    bare = re.sub(r"\(\?(P?<\w+>|P=\w+|[:=!>]|<[=!]|[aiLmsux-]+:?|\(\w+\))", "(", bare)
    open_, count, branching = 0, 0, [False]
    closed = False  # whether a group that repeats or chooses ends just here
    i = 0
    while i < len(bare):
        sign = bare[i]
        repeat = _QUANTIFIER.match(bare, i)
        if sign == "(":
            branching.append(False)
        elif sign == "|":
            branching[-1] = True
        elif repeat:
            low, comma, high = repeat[1] or "", repeat[2], repeat[3]
            exact = sign == "{" and not comma
            most = {"?": 1.0}.get(sign, float(high or (low if exact else 0) or "inf"))
            if closed and not (sign == "?" or (exact and most <= 1)):
                return "a repeat of what repeats or chooses"
            if not exact:
                count += 1
                open_ += most > _NEAR
                branching[-1] = True
            i = repeat.end() - 1
        inner = branching.pop() if sign == ")" and len(branching) > 1 else False
        closed = inner
        branching[-1] = branching[-1] or inner
        i += 1
    if open_ > _MOST_OPEN:
        return f"{open_} open repeats, more than {_MOST_OPEN}"
    return f"{count} repeats, more than {_MOST}" if count > _MOST else ""


def split(cells: Cells, key: str, pattern: Pattern) -> Cells:
    """The cells with the words that a pattern finds in the column `key`, in place of that.

    Raises:
        MeasurementFileError: a name that does not match, by line and column.
    """
    given = cells.words[key]
    found: dict[str, list[str]] = {word: [] for word in pattern.words}
    used = np.bincount(given.codes, minlength=len(given.names)) > 0
    for code, name in enumerate(given.names):
        match = None
        if used[code] and len(name) <= LONGEST_CELL:
            match = next((m for one in pattern.tried if (m := one.fullmatch(name))), None)
        if used[code] and match is None:
            row = int(np.flatnonzero(given.codes == code)[0])
            long = f" of {len(name)} characters" if len(name) > LONGEST_CELL else ""
            raise MeasurementFileError(
                f"{cells.path}, line {cells.lines[row]}, column {cells.headers[key]!r}: expected "
                f"{_spelled(pattern.tried)}, found {name[:60]!r}{long}"
            )
        groups = match.groupdict() if match else {}
        for word, list_ in found.items():
            list_.append((groups.get(word) or "").strip())
    words = {name: numbers for name, numbers in cells.words.items() if name != key}
    headers = {name: header for name, header in cells.headers.items() if name != key}
    for word, names in found.items():
        known: dict[str, int] = {}
        codes = np.array([known.setdefault(name, len(known)) for name in names], dtype=np.int64)
        words[word] = Words(codes[given.codes], tuple(known))
        headers[word] = cells.headers[key]
    return Cells(cells.path, cells.lines, headers, cells.numbers, words)


def _spelled(tried: Sequence[re.Pattern[str]]) -> str:
    return "a name such as the pattern " + " or ".join(repr(one.pattern) for one in tried)
