"""What a campaign is compared with: measuring in the test poses themselves.

In: a study. Out: load cases with repeats, which may break its constraints or identify nothing.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.elastic.allowed_loads import FixedVector, Load, ThereOrNot
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.study.study import Study


def in_test_poses(study: Study, count: int) -> tuple[LoadCases, IntArray]:
    """Load cases (S, n), (S, 6) and repeats (S,) of `count` experiments in the test poses.

    The calibration tool is loaded as the task loads its own, with the largest load that is
    allowed: direction of the task, size of the study. A fixed load stays as it is; where the task
    has no force, or no moment, there is none. Repeats are spread evenly; of more points than
    experiments, those of paths among them, as many are taken in equal steps. Poses of weight zero
    are left out.

    Raises:
        InputError: a test pose is given as a matrix, so that nobody can measure there.

    Source: paper section 5, "calibration in the test configuration".
    """
    cases = []
    for place in study.planned_for:
        if place.cases is None:
            raise InputError(
                f"test pose {place.name!r} is given as a matrix: it has no configuration to "
                "measure in"
            )
        cases.append(place.cases)
    q = np.concatenate([case.q for case in cases])
    wrench = np.concatenate([case.wrench for case in cases])
    taken = np.linspace(0, len(q) - 1, min(count, len(q))).round().astype(int)
    allowed = (study.experiments.force, study.experiments.moment)
    loads = [_like(load, wrench[taken, i : i + 3]) for load, i in zip(allowed, (0, 3), strict=True)]
    share, rest = divmod(count, len(taken))
    repeats = np.full(len(taken), share) + (np.arange(len(taken)) < rest)
    return LoadCases(q[taken], np.hstack(loads)), frozen(repeats, np.int64)


def _like(load: Load, wanted: Array) -> Array:
    """(S, 3) vectors along those of the task (S, 3), as large as the study allows."""
    if isinstance(load, FixedVector | ThereOrNot):
        return np.tile(load.value, (len(wanted), 1))
    size = np.linalg.norm(wanted, axis=1, keepdims=True)
    return np.asarray(load.largest * wanted / np.where(size > 0.0, size, 1.0))
