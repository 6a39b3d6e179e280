"""A statement reduced: fewer variables, and less of their ranges, with the same largest value.

Sum coordinates, variables that change nothing, ranges cut to a turn and to halves by symmetry: each
is proved (`dropped.py`, `symmetries.py`) before it is used.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.errors import Doubt
from elastocal.proof.dropped import base_joint, dependent
from elastocal.proof.roots import TURN, Interval, circles, sums, with_root
from elastocal.proof.series import FiniteSeries, constraint_series, rows_series
from elastocal.proof.statement import HalvedVariable, HeldVariable, Statement
from elastocal.proof.symmetries import Symmetry, symmetries

_FEW = 5  # active variables that are few: more take minutes


@dataclass(frozen=True)
class Reduced:
    """A statement that is quicker to prove.

    Attributes:
        statement: With its mix, its root, what is held and what is halved, and why.
        doubts: Constraints that were left out so that a variable could be held.
    """

    statement: Statement
    doubts: tuple[Doubt, ...] = ()


def reduced(statement: Statement) -> Reduced:
    """The statement with every reduction that can be proved.

    Args:
        statement: As `posed` makes it: the joints' own coordinates and whole ranges.
    """
    base = base_joint(statement)
    held = () if base is None else (HeldVariable(base, "base"),)
    s = with_root(replace(statement, mix=sums(statement.joints)), held)
    series, constraints = rows_series(s), constraint_series(s)
    s, doubts = _without_flat(s, series, constraints)
    if s.held != held:
        series, constraints = rows_series(s), constraint_series(s)
    return Reduced(_halved(s, symmetries(s, series, constraints)), doubts)


def _without_flat(
    s: Statement, rows: FiniteSeries, constraints: tuple[FiniteSeries, ...]
) -> tuple[Statement, tuple[Doubt, ...]]:
    """Variables held on which no row depends.

    Where a constraint depends on one it stays, if few are left anyway; else the constraint goes.
    """
    needed = dependent(rows)
    flat = [i for i in s.active.tolist() if i not in needed]
    asked = [dependent(one) for one in constraints]
    held, left_out, active = list(s.held), set[int](), len(needed)
    for i in flat:
        asking = {k for k, variables in enumerate(asked) if i in variables} - left_out
        if asking and active < _FEW:
            active += 1
            continue
        left_out |= asking
        held.append(HeldVariable(i, "flat"))
    names = tuple(dict.fromkeys(s.constraints[k].name for k in sorted(left_out)))
    kept = tuple(one for k, one in enumerate(s.constraints) if k not in left_out)
    order = sorted(held, key=lambda one: one.variable)
    s = replace(s, constraints=kept, left_out=(*s.left_out, *names))
    doubts = (Doubt("proof-leaves-out", names),) if names else ()
    return with_root(s, tuple(order)), doubts


def _halved(s: Statement, known: tuple[Symmetry, ...]) -> Statement:
    """The statement with as many variables halved as its symmetries allow."""
    group, halves, used = list(known), dict[int, Interval](), list[HalvedVariable]()
    round_ = circles(s)
    while True:
        choices: list[tuple[int, int, int, Interval, Symmetry, list[Symmetry]]] = []
        for one in group:
            for i in s.active.tolist():
                if i not in halves and (half := _half(s, one, i, bool(round_[i]))) is not None:
                    left = [other for other in group if _keeps(other, i, half)]
                    choices.append((len(left), -len(choices), i, half, one, left))
        if not choices:
            break
        _, _, i, half, one, group = max(choices, key=lambda choice: choice[:2])
        halves[i] = half
        shifts = np.pi * np.mod(np.round(s.mix @ one.shifts / np.pi), 2.0)
        used.append(HalvedVariable(i, one.signs, shifts))
    return replace(with_root(s, s.held, halves), halved=tuple(used))


def _half(s: Statement, one: Symmetry, i: int, round_: bool) -> Interval | None:
    """The half of the range of a variable that is left by a symmetry; None if it does not move."""
    low, high = s.root[:, i].tolist()
    if one.signs[i] > 0.0:
        return (low, low + np.pi) if one.shifts[i] else None
    if round_:
        return float(one.shifts[i] / 2.0), float(one.shifts[i] / 2.0 + np.pi)
    return 0.0, max(high, -low)


def _keeps(one: Symmetry, i: int, half: Interval) -> bool:
    """Whether a symmetry takes a half to itself, so that it can still be used."""
    if one.signs[i] > 0.0:
        return not one.shifts[i]
    off = (sum(half) - one.shifts[i]) / TURN
    return bool(abs(off - np.round(off)) < 1e-12)
