"""Large plain tables read by pyarrow, if it is there; whatever is not plain is left to `cells`.

The result is the same, number by number. Nothing is refused here: `cells` reads a file again
from which no plain table came, and finds the row and the column.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.files.measurements.columns import Column
from elastocal.files.tables.layout import Layout

LEAST = 20_000
"""Rows from which it is worth importing pyarrow."""


def plain_columns(
    table: Layout, columns: dict[str, Column], decimal: str
) -> tuple[Any, dict[str, Any]] | None:
    """Lines (R,) and columns of a plain table: floats in its units, (codes, names) for words.

    None if the table is small or not plain, or there is no pyarrow.
    """
    if len(table.lines) < LEAST or table.delimiter == " " or '"' in table.file.text:
        return None
    if not any(column.meaning.kind for column in columns.values()):
        return None  # rows of nothing but delimiters would not be noticed
    lines = table.lines[table.first :]
    full = np.fromiter(map(len, lines), np.int64, len(lines)) > 0
    try:
        found = _read("\n".join(lines), table, columns, decimal)
    except ImportError:
        return None
    if found is None or any(len(v) != full.sum() for v in found.values() if len(v) != 2):
        return None
    return np.flatnonzero(full) + table.first + 1, found


def _read(
    body: str, table: Layout, columns: dict[str, Column], decimal: str
) -> dict[str, Any] | None:
    import pyarrow as pa
    from pyarrow import csv

    names = [str(i) for i in range(len(table.header))]
    types = {
        str(c.index): pa.float64() if c.meaning.kind else pa.string() for c in columns.values()
    }
    try:
        read = csv.read_csv(
            pa.BufferReader(body.encode()),
            csv.ReadOptions(column_names=names, block_size=1 << 24),
            csv.ParseOptions(delimiter=table.delimiter, quote_char=False),
            csv.ConvertOptions(
                column_types=types,
                include_columns=list(types),
                null_values=[],
                strings_can_be_null=False,
                decimal_point=decimal,
            ),
        )
    except pa.ArrowException:
        return None
    found: dict[str, Any] = {}
    for key, column in columns.items():
        values = read[str(column.index)]
        if column.meaning.kind:
            found[key] = values.to_numpy()
            continue
        coded = values.combine_chunks().dictionary_encode()
        coded = coded.combine_chunks() if isinstance(coded, pa.ChunkedArray) else coded
        found[key] = coded.indices.to_numpy(), coded.dictionary.to_pylist()
    return found
