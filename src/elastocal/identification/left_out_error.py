"""How far off predictions of left-out experiments are: seen, and promised."""

from __future__ import annotations

import numpy as np

from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.result import Identification


def left_out_error(found: Identification) -> tuple[float, float]:
    """Root mean square error of left-out positions, three coordinates together: seen, promised [m].

    Readings that cannot be predicted without their experiment do not count; NaN if none can.
    """
    expected = np.trace(left_out_covariance(found), axis1=1, axis2=2)
    known = ~found.measurements.rotations & np.isfinite(expected)
    if not known.any():
        return float("nan"), float("nan")
    seen = np.sum(found.left_out[known] ** 2, axis=1)
    return float(np.sqrt(np.mean(seen))), float(np.sqrt(np.mean(expected[known])))


def repeats_go_along(found: Identification) -> bool:
    """Whether an experiment is left out with its repeats, as they share an error with it.

    Without nuisance they stay, and say what the experiment reads: the two errors do not compare.
    """
    distinct, nuisance = found.measurements.cases.distinct, found.nuisance
    shared = nuisance is not None and nuisance.errors.any_shared
    return shared and len(np.unique(distinct)) < len(distinct)
