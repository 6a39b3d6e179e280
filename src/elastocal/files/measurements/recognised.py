"""Whether a table has readings or is a plan: its columns say so."""

from __future__ import annotations

from pathlib import Path

from elastocal.errors import InputError
from elastocal.files.measurements.columns import DEFLECTIONS, ROTATION
from elastocal.files.tables.csv_table import is_table
from elastocal.files.tables.decoding import decoded
from elastocal.files.tables.layout import Style, layout
from elastocal.files.tables.units import split_header

_READ = {"state", *DEFLECTIONS, *ROTATION.values}
_PLANNED = "repeats"


def has_readings(path: Path, *, foreign: bool = False) -> bool:
    """Whether a file has measurements, and not a plan.

    Args:
        path: The file.
        foreign: Whether a mapping says what columns mean that are none of ours.

    Raises:
        InputError: a table with columns of both, or of neither.
    """
    if not is_table(path):
        return False
    try:
        table = layout(decoded(path, InputError), Style())
    except InputError:
        if foreign:  # the mapping may know how to read it
            return True
        raise
    names = {split_header(cell)[0].lower() for cell in table.header}
    read = sorted(names & _READ)
    if not read and not foreign and _PLANNED not in names:
        raise InputError(
            f"{path}, line {table.first}: neither a plan, which has a column {_PLANNED!r}, nor "
            "measurements, which have 'dx [mm]' or 'state'; of foreign files a --mapping says what "
            "the columns mean"
        )
    if read and _PLANNED in names:
        raise InputError(
            f"{path}, line {table.first}: column {_PLANNED!r} is that of a plan and column "
            f"{read[0]!r} that of measurements; expected one or the other"
        )
    return _PLANNED not in names
