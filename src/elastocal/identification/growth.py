"""Whether residuals grow with the load: as those of a wrong load do, or of a missing spring.

In: an identification. Out: the rank correlation of both, with its probability.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.fitting.chances import ratio_above
from elastocal.identification.result import Identification

_FEWEST = 8  # experiments below which ranks tell nothing
_ALIKE = 1.2  # largest load over the smallest, up to which all are the same one


@dataclass(frozen=True)
class Growth:
    """How residuals go with the load.

    Attributes:
        correlation: Rank correlation of the residuals of the experiments and their loads.
        p_value: Probability of so large a one if they have nothing to do with each other.
    """

    correlation: float
    p_value: float


def growth(found: Identification) -> Growth | None:
    """How residuals go with the load; None where loads are alike or experiments few.

    Source: Spearman's rank correlation with Student's t; one side, as only growth is asked for.
    """
    data = found.measurements
    wrench = data.cases.wrench
    load = np.linalg.norm(wrench[:, :3] if wrench[:, :3].any() else wrench[:, 3:], axis=1)
    count = np.bincount(data.case, minlength=len(load))
    # What an experiment decides by itself it cannot contradict: residuals, each by its freedom.
    freedom = np.maximum(1.0 - found.influence.leverage / np.maximum(3 * count, 1), 1e-3)
    size = data.by_experiment(found.residual / data.deviation) / np.sqrt(freedom)
    there = (count > 0) & (load > 0.0)
    load, size = load[there], size[there]
    if len(load) < _FEWEST or load.max() <= _ALIKE * load.min():
        return None
    ranks = [_ranks(values) - 0.5 * (len(load) - 1) for values in (load, size)]
    correlation = float(ranks[0] @ ranks[1] / np.sqrt(np.prod([r @ r for r in ranks])))
    dof = len(load) - 2
    both = ratio_above(correlation**2 * dof / max(1.0 - correlation**2, 1e-12), 1.0, dof)
    return Growth(correlation, 0.5 * both if correlation > 0.0 else 1.0 - 0.5 * both)


def _ranks(values: Array) -> Array:
    """(N,) ranks from 0; equal values share the mean of theirs."""
    _, which, count = np.unique(values, return_inverse=True, return_counts=True)
    middle = np.cumsum(count) - 0.5 * (count + 1)
    return np.asarray(middle[which], dtype=float).reshape(len(values))
