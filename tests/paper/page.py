"""The tables of docs/validation.md, so that tests hold every number that is printed there."""

from __future__ import annotations

import re
from decimal import Decimal
from functools import cache
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "validation.md"
_NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@cache
def tables() -> dict[str, dict[str, tuple[str, ...]]]:
    """Rows by their first cell, of every table by its heading and its first header cell."""
    found: dict[str, dict[str, tuple[str, ...]]] = {}
    heading = name = ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            heading = line.lstrip("# ").partition(":")[0]
        if not line.startswith("|"):
            name = ""
            continue
        first, *rest = (cell.strip().replace("**", "") for cell in line.strip("|").split("|"))
        if not name:
            name = f"{heading}: {first}"
            assert name not in found, f"two tables are called {name!r}"
            found[name] = {}
        elif not set(first) <= {"-"} or not first:
            found[name][first] = tuple(rest)
    return found


def numbers(cell: str) -> list[Decimal]:
    """The numbers of a cell, with as many digits as are shown."""
    return [Decimal(text) for text in _NUMBER.findall(cell)]


def shows(cell: str, *values: float, units: float = 0.5) -> bool:
    """Whether a cell shows these values, each within so many units of its last digit."""
    shown = numbers(cell)
    assert len(shown) == len(values), f"{cell!r} has {len(shown)} numbers, expected {len(values)}"
    return all(
        abs(float(number) - value) <= (units + 1e-6) * 10.0 ** number.as_tuple().exponent  # type: ignore[operator]
        for number, value in zip(shown, values, strict=True)
    )
