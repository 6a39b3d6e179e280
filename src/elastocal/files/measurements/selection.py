"""Rows that somebody marked as not to be used, and words that are one of a few."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import BoolArray
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import NOT_USED
from elastocal.files.measurements.table import Table

_USED = {"valid": ("1", "true", "yes"), "delete": ("0", "false", "no", "")}


def usable(table: Table) -> BoolArray:
    """(R,) rows that are valid and not deleted.

    Raises:
        MeasurementFileError: a mark that is neither yes nor no.
    """
    keep = np.ones(table.rows, dtype=bool)
    for key, good in _USED.items():
        if key in table.words:
            allowed = dict.fromkeys(good, True) | dict.fromkeys(NOT_USED[key], False)
            keep &= chosen_word(table, key, allowed)
    if not keep.any():
        raise MeasurementFileError(f"{table.where(0)}: every row is marked as invalid or deleted")
    return keep


def chosen_word(table: Table, key: str, allowed: dict[str, bool]) -> BoolArray:
    """(R,) what the words of a column mean, in any case.

    Raises:
        MeasurementFileError: a word that is not allowed, by row and column.
    """
    words = table.words[key]
    meaning = np.array([allowed.get(name.lower(), -1) for name in words.names], dtype=np.int64)
    found = meaning[words.codes]
    wrong = np.flatnonzero(found < 0)
    if len(wrong):
        row = int(wrong[0])
        name = words.names[words.codes[row]]
        raise MeasurementFileError(
            f"{table.where(row, key)}: expected one of {', '.join(w for w in allowed if w)}, "
            f"found {name[:40]!r}"
        )
    return np.asarray(found > 0)
