"""When something was read: numbers with a unit, or time stamps, as seconds."""

from __future__ import annotations

import re
from datetime import UTC, datetime

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.columns import STAMP, TIME
from elastocal.files.measurements.table import Table

_GERMAN = re.compile(
    r"(\d{1,2})\.(\d{1,2})\.(\d{4})[ T,]+(\d{1,2}):(\d{2})(?::(\d{2})(?:[.,](\d{1,6}))?)?"
)


def times(table: Table) -> Array:
    """(R,) seconds; NaN where nothing is said, the same zero for all rows.

    Raises:
        MeasurementFileError: a time stamp that is none, or only some with a time zone.
    """
    if TIME in table.numbers:
        return table.numbers[TIME]
    if STAMP not in table.words:
        return np.full(table.rows, np.nan)
    words = table.words[STAMP]
    found = np.full(len(words.names), np.nan)
    zoned: dict[bool, int] = {}
    for code, name in enumerate(words.names):
        if not name:
            continue
        stamp = _stamp(name)
        if stamp is None:
            raise MeasurementFileError(
                f"{_where(table, code)}: expected a time such as 2026-11-28T14:05:09, or "
                f"28.11.2026 14:05:09, found {name[:40]!r}"
            )
        zoned.setdefault(stamp.tzinfo is not None, code)
        if len(zoned) == 2:
            raise MeasurementFileError(
                f"{_where(table, code)}: {name[:40]!r} and {words.names[zoned[not stamp.tzinfo]]!r}"
                " cannot be compared; expected all times with a time zone, or none"
            )
        found[code] = (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()
    return np.asarray(found[words.codes])


def _where(table: Table, code: int) -> str:
    row = int(np.flatnonzero(table.words[STAMP].codes == code)[0])
    return table.where(row, STAMP)


def _stamp(text: str) -> datetime | None:
    """The date and time in a text, None if it has none."""
    try:
        if german := _GERMAN.fullmatch(text):
            day, month, year, hour, minute, second, part = german.groups()
            micro = int((part or "0").ljust(6, "0"))
            return datetime(
                int(year), int(month), int(day), int(hour), int(minute), int(second or 0), micro
            )
        return datetime.fromisoformat(text.replace(",", ".")) if ":" in text else None
    except ValueError:
        return None
