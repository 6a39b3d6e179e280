"""Documents with one node replaced by something else, one after the other."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

ODD: tuple[Any, ...] = (
    None, "x", "", "2", 1, 0, -1, 2.5, 1e29, 1e-29, True, False, [], {}, [[]], [1, "x"], {"x": 1},
)  # fmt: skip
"""What may stand where something else should."""

Place = tuple[str | int, ...]


def damaged(document: Any, odd: tuple[Any, ...] = ODD) -> Iterator[tuple[Place, Any, Any]]:
    """Place, what stands there now, and the whole document with it; of lists the ends only."""
    for place in _places(document):
        for what in odd:
            changed = copy.deepcopy(document)
            inner = changed
            for part in place[:-1]:
                inner = inner[part]
            if type(inner[place[-1]]) is type(what) and inner[place[-1]] == what:
                continue
            inner[place[-1]] = copy.deepcopy(what)
            yield place, what, changed


def _places(value: Any, above: Place = ()) -> Iterator[Place]:
    parts: list[tuple[str | int, Any]] = []
    if isinstance(value, dict):
        parts = list(value.items())
    elif isinstance(value, list):
        parts = [(i, value[i]) for i in sorted({0, len(value) - 1}) if value]
    for part, inner in parts:
        yield (*above, part)
        yield from _places(inner, (*above, part))
