"""Load cases: the noun that runs through everything.

A load case is a configuration together with the wrench that acts on the tool. Candidates, test
poses, the support of a plan and what was measured are all batches of load cases.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze, frozen, unset
from elastocal.errors import InputError


@dataclass(frozen=True)
class LoadCases:
    """N configurations, each with the wrench that acts at the load point of the tool.

    Attributes:
        q: (N, n) joint values [rad or m].
        wrench: (N, 6) force then moment, in the base frame [N, N·m].
        before: (N, 6) what acts already before this load comes on top, as where the arm is read
            between two loads; none if not given.
    """

    q: Array
    wrench: Array
    before: Array = field(default_factory=unset)

    def __post_init__(self) -> None:
        freeze(self, "q", "wrench", "before")
        q, wrench = self.q, self.wrench
        if self.before.size and self.before.shape != wrench.shape:
            raise InputError(
                f"{len(q)} load cases need as many wrenches before them, or none; found "
                f"{self.before.shape}"
            )
        if q.ndim != 2 or wrench.shape != (len(q), 6):
            raise InputError(
                f"load cases need q of shape (N, n) and wrench of shape (N, 6); found {q.shape} "
                f"and {wrench.shape}"
            )
        if not (np.isfinite(q).all() and np.isfinite(wrench).all()):
            raise InputError("load cases must be finite numbers; found NaN or infinity")

    @property
    def preloaded(self) -> bool:
        """Whether anything acts before the load."""
        return self.before.size > 0

    @property
    def first(self) -> Array:
        """(N, 6) wrench of the first of the two states: nothing, if the arm is not preloaded."""
        return self.before if self.preloaded else np.zeros_like(self.wrench)

    @property
    def second(self) -> Array:
        """(N, 6) wrench of the second."""
        return self.wrench + self.before if self.preloaded else self.wrench

    def chosen(self, keep: BoolArray | IntArray) -> LoadCases:
        """Some of them, by a mask or by their numbers."""
        before = self.before[keep] if self.preloaded else self.before
        return LoadCases(self.q[keep], self.wrench[keep], before)

    def followed_by(self, others: LoadCases) -> LoadCases:
        """These, then others."""
        before = unset()
        if self.preloaded or others.preloaded:
            before = np.vstack([self.first, others.first])
        q = np.concatenate([self.q, others.q])
        return LoadCases(q, np.concatenate([self.wrench, others.wrench]), before)

    @cached_property
    def distinct(self) -> IntArray:
        """(N,) number of each among the distinct load cases."""
        parts = [self.q, self.wrench] + ([self.before] if self.preloaded else [])
        together = np.asarray(np.round(np.hstack(parts), 9), dtype=np.float64)
        return frozen(ranks_of_rows(together), np.int64)

    def __len__(self) -> int:
        return len(self.q)


def ranks_of_rows(rows: Array) -> IntArray:
    """(N,) place of each row of `rows`, (N, k), among the distinct ones in lexical order.

    Columns count one after the other until all rows are apart: for random ones that is the first.
    """
    rank = np.zeros(len(rows), dtype=np.int64)
    for column in rows.T:
        order = np.lexsort((column, rank)) if rank.any() else np.argsort(column)
        differ = (np.diff(column[order]) != 0.0) | (np.diff(rank[order]) != 0)
        rank[order[1:]] = np.cumsum(differ)
        rank[order[:1]] = 0
        if differ.all():
            break
    return rank
