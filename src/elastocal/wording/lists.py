"""Names in a row, and how many of something."""

from __future__ import annotations

from collections.abc import Sequence

LONGEST = 40
"""Characters of a name that are shown."""
_MOST = 5  # names listed before the rest is counted


def listed(names: Sequence[str]) -> str:
    """Up to five names; of more, how many are left."""
    shown = ", ".join(names[:_MOST])
    return shown if len(names) <= _MOST else f"{shown} and {len(names) - _MOST} more"


def springs_in_short(names: Sequence[str], joints: Sequence[str]) -> tuple[str, ...]:
    """Names of springs; those beside the joints as one that counts them, if they are many."""
    own = [name for name in names if name in joints]
    besides = len(names) - len(own)
    return tuple(names) if besides <= _MOST else (*own, f"{besides} springs besides")


def counted(count: int, noun: str) -> str:
    """A number with its noun: 1 reading, 2 readings."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def experiments(names: Sequence[str]) -> str:
    """'experiments 3, 5' and how many more."""
    return f"experiment{'s' if len(names) > 1 else ''} {listed([n[:LONGEST] for n in names])}"
