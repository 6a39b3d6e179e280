"""How far off predictions of what is left out are: seen, and promised."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.result import Identification


@dataclass(frozen=True)
class LeftOutError:
    """Root mean square errors of left-out positions, three coordinates together.

    Attributes:
        seen: Of the readings [m]; NaN if nothing can be predicted without what is left out.
        promised: As the fit expects them [m].
        load_cases: Whether load cases went, with all their repeats; else single experiments did,
            because without a load case nothing is known of some compliance.
    """

    seen: float
    promised: float
    load_cases: bool


def left_out_error(found: Identification) -> LeftOutError:
    """How far off load cases are predicted from the others.

    Repeats go together: left out alone, an experiment is predicted by what its repeats read, errors
    of the model that they share with it included. Readings that cannot be predicted do not count.
    """
    by_case = _error(found, load_cases=True)
    return by_case if np.isfinite(by_case.seen) else _error(found, load_cases=False)


def _error(found: Identification, *, load_cases: bool) -> LeftOutError:
    expected = np.trace(left_out_covariance(found, load_cases=load_cases), axis1=1, axis2=2)
    known = ~found.measurements.rotations & np.isfinite(expected)
    if not known.any():
        return LeftOutError(float("nan"), float("nan"), load_cases)
    without = found.without_load_case if load_cases else found.without_experiment
    seen = np.sum(without.residual[known] ** 2, axis=1)
    return LeftOutError(
        float(np.sqrt(np.mean(seen))), float(np.sqrt(np.mean(expected[known]))), load_cases
    )


def repeats_left(found: Identification, error: LeftOutError) -> str:
    """What becomes of the repeats of what is left out, in brackets; empty if there are none."""
    distinct = found.measurements.cases.distinct
    if len(np.unique(distinct)) == len(distinct):
        return ""
    return " with their repeats" if error.load_cases else " (repeats stay)"
