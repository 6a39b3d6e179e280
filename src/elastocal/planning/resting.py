"""Resting: compliances that rest on one configuration of a plan, so that its loss takes them away.

In: load cases with repeats and their rows, what is known besides. Out: by how much the standard
errors of unknowns grow without each configuration, near ones taken together.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.elastic.load_cases import LoadCases
from elastocal.matrices import scaled_inverse
from elastocal.planning.near import near_configurations
from elastocal.study.study import Study

RESTS = 2.0
"""A compliance rests on a configuration without which its standard error is so many times as large.

Source: ours; of three configurations that tell of it alike the loss of one costs a factor of 1.2.
"""
_LEAST = 1e-9  # share of what is known that a loss leaves at least, for rounding


class Resting(NamedTuple):
    """The configuration on which compliances rest."""

    load_case: int  # number of its first load case, from 1
    times: dict[str, float]  # how many times as large standard errors are without it, by name


def resting(study: Study, cases: LoadCases, repeats: IntArray) -> Resting | None:
    """The configuration on which compliances rest most; None if none does.

    Args:
        study: The study.
        cases: S load cases.
        repeats: (S,) repeats.

    Source: ours.
    """
    which = soft(study)
    rows = study.space.evaluate(study.space.points(cases)).blocks * root(repeats)
    covariance = scaled_inverse((study.prior + np.einsum("srp,srq->pq", rows, rows))[None])[0]
    group = near_configurations(study.robot, cases.q)
    now = np.diagonal(covariance)[which]
    times = np.sqrt(without_each(covariance, together(rows, group), which) / now)
    if not times.size or times.max() <= RESTS:
        return None
    worst = int(times.max(axis=1).argmax())
    order = [i for i in np.argsort(-times[worst]).tolist() if times[worst, i] > RESTS]
    names = study.fitted.names
    first = int(np.flatnonzero(group == worst)[0]) + 1
    return Resting(first, {names[which[i]]: float(times[worst, i]) for i in order})


def soft(study: Study) -> IntArray:
    """Numbers of the compliances that are sought among all that is fitted."""
    return np.array(study.wanted, dtype=np.int64)[~study.springs.stiff]


def root(repeats: IntArray) -> Array:
    """(S, 1, 1) what rows of load cases are multiplied by, measured (S,) `repeats` times."""
    return np.asarray(np.sqrt(repeats.astype(float))[:, None, None])


def together(rows: Array, group: IntArray) -> Array:
    """(G, r', p) rows (S, r, p) of the load cases of each group (S,), filled up with zeros."""
    size = np.bincount(group)
    place = np.empty(len(group), dtype=np.int64)
    for g in range(len(size)):
        place[group == g] = np.arange(size[g])
    _, r, p = rows.shape
    found = np.zeros((len(size), int(size.max(initial=0)), r, p))
    found[group, place] = rows
    return found.reshape(len(size), -1, p)


def without_each(covariance: Array, rows: Array, which: IntArray) -> Array:
    """(G, k) variances of some unknowns without each of G groups of rows.

    Args:
        covariance: (p, p) of all unknowns with all rows.
        rows: (G, r, p) rows over their noise.
        which: (k,) unknowns.

    Source: Woodbury's identity.
    """
    moved = rows @ covariance
    rest = np.eye(rows.shape[1]) * (1.0 + _LEAST) - moved @ rows.transpose(0, 2, 1)
    some = moved[:, :, which]
    more = (some * np.linalg.solve(rest, some)).sum(axis=1)
    return np.asarray(np.diagonal(covariance)[which] + np.maximum(more, 0.0))
