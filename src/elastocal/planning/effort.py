"""Effort: how many load cases to search with, and for how long.

In: an aim. Out: what is worth the time.
"""

from __future__ import annotations

from elastocal.design.exact import Effort
from elastocal.planning.aim import Aim

_MANY = 30
_WELL_ROUNDED = 8  # load cases from which on one search ends where others do


def enough(aim: Aim) -> int:
    """Distinct load cases to search with: more would cost time and gain next to nothing.

    Where repeats share errors they do gain: as long as there is time.
    """
    return max(_MANY if aim.shares else 6, aim.space.parameters + 1)


def effort_for(aim: Aim, distinct: int) -> Effort | None:
    """How long to search where repeats share errors; None: as ever.

    Single readings of many load cases: seeds of one search end .1 % apart.
    """
    if not aim.shares or distinct < _WELL_ROUNDED:
        return None
    return Effort(generations=20, patience=5, islands=1)
