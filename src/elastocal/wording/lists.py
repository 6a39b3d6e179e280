"""Names in a row, and how many of something."""

from __future__ import annotations

from collections.abc import Sequence

_MOST = 5  # names listed before the rest is counted


def listed(names: Sequence[str]) -> str:
    """Up to five names; of more, how many are left."""
    shown = ", ".join(names[:_MOST])
    return shown if len(names) <= _MOST else f"{shown} and {len(names) - _MOST} more"


def counted(count: int, noun: str) -> str:
    """A number with its noun: 1 reading, 2 readings."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
