"""Uncertainties of readings that came with them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import MeasurementFileError

if TYPE_CHECKING:
    from elastocal.files.measurements.columns import Triple
    from elastocal.files.measurements.table import Table

COVERAGE = 2.0
"""U95 is this many standard uncertainties."""
LEAST, MOST = 1e-12, 10.0
"""Uncertainties that an instrument can have [m, rad]; others are mistakes."""
_SIX = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def kind_of_uncertainty(keys: object, where: str, of: Triple) -> tuple[str, ...]:
    """The columns with uncertainties of a reading, () if there are none.

    Raises:
        MeasurementFileError: some of three axes, or more than one kind.
    """
    assert hasattr(keys, "__contains__")
    found = [names for names in of.uncertainties if any(name in keys for name in names)]
    if len(found) > 1:
        raise MeasurementFileError(
            f"{where}: columns {found[0][0]!r} and {found[1][0]!r} both give an uncertainty; "
            "keep one of them"
        )
    names = found[0] if found else ()
    absent = [name for name in names if name not in keys]
    if absent:
        raise MeasurementFileError(
            f"{where}: column '{absent[0]} [{of.unit}]' is missing beside those of the other axes"
        )
    crossed = [name for name in of.covariances if name in keys]
    axes = of.uncertainties[1]
    if crossed and (len(crossed) < 3 or names != axes):
        *most, last = *axes, *of.covariances
        raise MeasurementFileError(
            f"{where}: column {crossed[0]!r} needs all of {', '.join(most)} and {last}"
        )
    return names


def variances(table: Table, names: tuple[str, ...], of: Triple) -> Array:
    """(R, 6) variances xx, yy, zz and covariances xy, xz, yz of every row [m² or rad²].

    Args:
        table: Rows that all have such a reading.
        names: Columns with its uncertainties.
        of: What is read.

    Raises:
        MeasurementFileError: an uncertainty that is not positive, or that no instrument has, by
            row and column.
    """
    six = np.zeros((table.rows, 6))
    scale = 1.0 / COVERAGE if names[0].startswith("U95") else 1.0
    for name in names:
        found = table.numbers[name]
        wrong = np.flatnonzero(~((found >= LEAST) & (found <= MOST)))
        if len(wrong):
            row = int(wrong[0])
            raise MeasurementFileError(f"{table.where(row, name)}: {_problem(found[row], of)}")
    for axis in range(3):
        six[:, axis] = (scale * table.numbers[names[axis % len(names)]]) ** 2
    if table.has(*of.covariances):
        for i, key in enumerate(of.covariances):
            six[:, 3 + i] = table.numbers[key]
        _check_positive(six, table, of)
    return six


def _problem(value: float, of: Triple) -> str:
    """Why an uncertainty [m, rad] is none."""
    if np.isnan(value):
        return "an uncertainty must be positive, the cell is empty"
    found = f"found {1e3 * value:g} {of.unit}"
    if not value > 0.0:
        return f"an uncertainty must be positive, {found}"
    return (
        f"no instrument has this uncertainty; expected {1e3 * LEAST:g} to {1e3 * MOST:g} "
        f"{of.unit}, {found}"
    )


def matrices(six: Array) -> Array:
    """(R, 3, 3) covariances of (R, 6) [m² or rad²]."""
    result = np.empty((len(six), 3, 3))
    for k, (i, j) in enumerate(_SIX):
        result[:, i, j] = result[:, j, i] = six[:, k]
    return result


def six_of(covariance: Array) -> Array:
    """(R, 6) of (R, 3, 3) covariances [m² or rad²]."""
    return np.stack([covariance[:, i, j] for i, j in _SIX], axis=1)


def averaged(six: Array, group: IntArray, count: IntArray) -> Array:
    """(G, 6) covariances of the means over G groups of `count` independent rows [m²]."""
    total = np.stack([np.bincount(group, six[:, k], len(count)) for k in range(6)], axis=1)
    return np.asarray(total / np.maximum(count, 1)[:, None] ** 2)


def _check_positive(six: Array, table: Table, of: Triple) -> None:
    scale = np.sqrt(six[:, :3])
    unit = matrices(six) / (scale[:, :, None] * scale[:, None, :])
    empty = np.flatnonzero(np.isnan(unit).any(axis=(1, 2)))
    if len(empty):
        row = int(empty[0])
        name = next(n for n in of.covariances if np.isnan(table.numbers[n][row]))
        raise MeasurementFileError(f"{table.where(row, name)}: the cell is empty")
    wrong = np.flatnonzero(~(np.linalg.eigvalsh(unit)[:, 0] > 1e-9))
    if len(wrong):
        cross, axes = of.covariances, of.uncertainties[1]
        raise MeasurementFileError(
            f"{table.where(int(wrong[0]))}: {cross[0]}, {cross[1]} and {cross[2]} do not fit to "
            f"{axes[0]}, {axes[1]} and {axes[2]}; their matrix must be positive definite"
        )
