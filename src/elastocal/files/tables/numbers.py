"""Numbers in the cells of tables: what is one, and why a cell is none."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError

LARGEST = 1e9
"""Numbers beyond this are mistakes in any unit of these files."""

_MINUS = "-−–‐‑﹣－"
"""What is printed for a minus."""
_DASHES = str.maketrans(dict.fromkeys(_MINUS, "-"))
_SIGNED = re.compile(rf"\s*'?[{_MINUS}+]?\d*[.,]\d+([eEdD][-+]?\d+)?\s*")
_EXPONENT = re.compile(r"(?<=[\d.,])[dD](?=[-+]?\d)")
"""Fortran writes 1.5D+01."""
_THOUSANDS = re.compile(rf"\s*'?[{_MINUS}+]?[1-9]\d{{0,2}},\d{{3}}\s*")


def decimal_in(cell: str, delimiter: str) -> str:
    """The decimal sign of the number in a cell, empty if it shows none.

    Between commas "1,200" may be a thousand in quotes as well, so it shows none there.
    """
    if not _SIGNED.fullmatch(cell) or (delimiter == "," and _THOUSANDS.fullmatch(cell)):
        return ""
    return "," if "," in cell else "."


def plain(cell: str) -> str:
    """A word without what spreadsheets put around it."""
    return cell.strip().removeprefix("'").strip()


def matches(word: str, values: Sequence[str]) -> bool:
    """Whether a word is one of some, as text or as the same number."""
    return word in values or any(_same_number(word, value) for value in values)


def _same_number(word: str, value: str) -> bool:
    try:
        return float(word.replace(",", ".")) == float(value)
    except ValueError:
        return False


def numbers_of(
    cells: Sequence[str], decimal: str, where: Callable[[int], str], error: type[InputError]
) -> Array:
    """The numbers in cells.

    Args:
        cells: The cells of a column.
        decimal: Decimal sign.
        where: Place of the cell with an index, for messages.
        error: What to raise.

    Raises:
        InputError: the first cell that is no number; of the type `error`.
    """
    together = "".join(cells)
    good = not (decimal == "," and "." in together) and "_" not in together
    if not together.isascii() or "'" in together or "d" in together.lower():
        cells = [_EXPONENT.sub("e", plain(cell).translate(_DASHES)) for cell in cells]
        good = good and "".join(cells).isascii()  # Python takes digits of any script
    ready = [cell.replace(",", ".") for cell in cells] if decimal == "," else cells
    try:
        values = np.fromiter(map(float, ready), dtype=np.float64, count=len(ready))
    except ValueError:
        good = False
    if good and bool((np.abs(values) < LARGEST).all()):
        return values
    for i, cell in enumerate(cells):
        problem = _problem(cell, decimal)
        if problem:
            raise error(f"{where(i)}: {problem}")
    raise AssertionError("a number was refused without a reason")


def _problem(cell: str, decimal: str) -> str:
    """Why a cell is no number, empty if it is one."""
    shown = repr(cell.strip()[:40])
    text = cell.strip()
    if not text:
        return "the cell is empty; expected a number"
    if decimal == "," and "." in text:
        return f"expected a number with a decimal comma as in the rows before, found {shown}"
    try:
        value = float(text.replace(",", ".") if decimal == "," else text)
        if "_" not in text and text.isascii():
            if abs(value) < LARGEST:
                return ""
            more = f"; none here is {LARGEST:g} or more" if np.isfinite(value) else ""
            return f"expected a finite number, found {shown}{more}"
    except ValueError:
        pass
    if re.fullmatch(r"[-+]?\d{1,3}([,.\s’']\d{3})+([.,]\d*)?", text) and (
        decimal not in text[:-4] or text.count(decimal) > 1
    ):
        return f"expected a number without thousands separators, found {shown}"
    if decimal == "." and re.fullmatch(r"[-+]?\d*,\d+", text):
        return f"expected a number with a decimal point, found {shown}"
    if re.match(r"[-+]?[\d.,]+\s*[A-Za-z°µ]", text) and not re.match(r"[-+]?[\d.]+[eE]", text):
        return f"expected a bare number, found {shown}; the unit belongs in the header"
    return f"expected a number, found {shown}"
