"""Plans compared along the paths of a study: at how many of the points is one better?"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from elastocal.arrays import Array
from elastocal.matrices import scaled_inverse
from elastocal.planning.assessment import Assessment
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath, errors_along

Shares = dict[str, dict[str, dict[str, float]]]
"""By path, by plan, by another plan: share of the points at which the plan has the smaller ρ0."""


def better_along(study: Study, plans: Mapping[str, Assessment]) -> Shares:
    """How often each plan is better than each other one, along every path of the study.

    Source: paper, section 5: an optimal plan is better in other configurations, too.
    """
    shares: Shares = {}
    for path in study.test_poses:
        if not isinstance(path, TestPath):
            continue
        errors = {name: _errors(path, worth) for name, worth in plans.items()}
        shares[path.name] = {
            name: {
                other: float((own < theirs).mean())
                for other, theirs in errors.items()
                if other != name
            }
            for name, own in errors.items()
        }
    return shares


def _errors(path: TestPath, worth: Assessment) -> Array:
    """(N,) ρ0 along a path [m]; infinite if the compliances are not identified."""
    if not worth.identifiable:
        return np.full(len(path.cases), np.inf)
    return errors_along(path, scaled_inverse(worth.information[None])[0])
