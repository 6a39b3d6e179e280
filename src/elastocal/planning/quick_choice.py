"""Quick choice: load cases of a pool that promise much, one after the other and once exchanged.

For estimates: what other loads or tools would be worth, without planning for them.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.with_errors import WithErrors
from elastocal.study.study import Study

_FLOOR = 1e-9  # of the information of the pool: what is not seen yet can be chosen for
_SWEEPS = 2


def chosen(
    study: Study,
    pool: LoadCases,
    repeats: IntArray,
    beside: tuple[LoadCases, IntArray] | None = None,
) -> LoadCases:
    """S load cases of a pool, by what they promise together.

    Args:
        study: A study that knows nuisance.
        pool: N load cases.
        repeats: (S,) how often they are measured.
        beside: Load cases with repeats that are measured anyway.
    """
    assert study.nuisance is not None
    told = WithErrors(study, study.nuisance)
    times = np.unique(repeats).tolist()
    each = {n: told.informations(pool, np.full(len(pool), n)) for n in times}
    known = told.base if beside is None else told.total(*beside)
    mean = each[times[-1]].mean(axis=0)
    scale = 1.0 / np.sqrt(np.diagonal(known + mean))
    grid = np.outer(scale, scale)
    each = {n: found * grid for n, found in each.items()}
    columns = _columns(told) * scale
    total = known * grid + _FLOOR * np.eye(len(scale))
    picks: list[int] = []
    for n in repeats.tolist():
        picks.append(_best(total, each[n], columns))
        total = total + each[n][picks[-1]]
    for _ in range(_SWEEPS):
        for place, n in enumerate(repeats.tolist()):
            total = total - each[n][picks[place]]
            picks[place] = _best(total, each[n], columns)
            total = total + each[n][picks[place]]
    return pool.chosen(np.array(picks))


def _columns(told: WithErrors) -> Array:
    """(r, q) what is left at the test poses by the root of a covariance, few rows for all."""
    rows = [
        np.sqrt(share / len(pose.regressors)) * np.concatenate(list(told.blocks(pose)))
        for share, pose in zip(told.study.shares, told.study.test_poses, strict=True)
    ]
    return np.asarray(np.linalg.qr(np.concatenate(rows), mode="r"))


def _best(total: Array, more: Array, columns: Array) -> int:
    """Which of (N, q, q) informations leaves least beside a total (q, q)."""
    totals = total + more
    right = np.broadcast_to(columns.T, (len(totals), *columns.T.shape))
    left = (columns.T * np.linalg.solve(totals, right)).sum(axis=(1, 2))
    return int(left.argmin())
