"""Load cases: the noun that runs through everything.

A load case is a configuration together with the wrench that acts on the tool. Candidates, test
poses, the support of a plan and what was measured are all batches of load cases.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray, freeze, frozen
from elastocal.errors import InputError


@dataclass(frozen=True)
class LoadCases:
    """N configurations, each with the wrench that acts at the load point of the tool.

    Attributes:
        q: (N, n) joint values [rad or m].
        wrench: (N, 6) force then moment, in the base frame [N, N·m].
    """

    q: Array
    wrench: Array

    def __post_init__(self) -> None:
        freeze(self, "q", "wrench")
        q, wrench = self.q, self.wrench
        if q.ndim != 2 or wrench.shape != (len(q), 6):
            raise InputError(
                f"load cases need q of shape (N, n) and wrench of shape (N, 6); found {q.shape} "
                f"and {wrench.shape}"
            )
        if not (np.isfinite(q).all() and np.isfinite(wrench).all()):
            raise InputError("load cases must be finite numbers; found NaN or infinity")

    @cached_property
    def distinct(self) -> IntArray:
        """(N,) number of each among the distinct load cases."""
        together = np.asarray(np.round(np.hstack([self.q, self.wrench]), 9), dtype=np.float64)
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
