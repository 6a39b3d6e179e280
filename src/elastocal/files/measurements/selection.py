"""Rows that somebody marked as not to be used, and words that are one of a few."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import BoolArray
from elastocal.errors import MeasurementFileError
from elastocal.files.measurements.cells import NOT_USED
from elastocal.files.measurements.table import Table, kept
from elastocal.files.tables.numbers import matches

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


def selected(
    table: Table, keep: dict[str, tuple[str, ...]], where: str, *, last: bool = False
) -> tuple[Table, list[str]]:
    """The rows that a mapping keeps by their words, and what is said of the others.

    Args:
        table: The rows.
        keep: Words of rows that are kept, by column; what is done is taken out of it.
        where: The mapping file.
        last: Whether all columns are there; else those that are not wait.

    Raises:
        MeasurementFileError: a word that no row has, or no row is left.
    """
    remarks = []
    for name, values in list(keep.items()):
        words = table.words.get(name) or table.words.get(f"raw:{name}")
        if words is None:
            if last:
                raise MeasurementFileError(
                    f"{where}: keep: no column gives {name!r}; expected the name of a column or "
                    "of a word that a pattern finds"
                )
            continue
        del keep[name]
        used = [words.names[code] for code in np.unique(words.codes)]
        for value in values:
            if not any(matches(word, (value,)) for word in used):
                there = ", ".join(repr(word[:40]) for word in used[:6])
                raise MeasurementFileError(
                    f"{where}: keep: no row has {value!r} in {name!r}; found {there}"
                    + (f" and {len(used) - 6} more" if len(used) > 6 else "")
                )
        good = np.array([matches(word, values) for word in words.names], dtype=bool)[words.codes]
        if not good.all():
            listed = ", ".join(repr(value) for value in values[:6])
            remarks.append(
                f"{int((~good).sum())} of {table.rows} rows left out that do not have {listed} in "
                f"{name!r}"
            )
            table = kept(table, good)
    if not table.rows:
        raise MeasurementFileError(f"{where}: keep: no row is left")
    return table, remarks
