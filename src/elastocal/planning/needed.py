"""Needed: compliances that the task hardly depends on, and those that a plan hardly tells.

In: a study that knows how soft joints usually are, what a plan is worth. Out: doubts.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.errors import Doubt
from elastocal.planning.assessment import Assessment
from elastocal.study.study import Study

_LITTLE = 0.01  # share of what is promised
_HALF = 0.5  # standard error over the usual compliance


def hardly_needed(study: Study, worth: Assessment) -> Iterator[Doubt]:
    """Joints that move the tool at the test poses by less than counts in what is promised.

    Even if nobody compensated them the promise would grow by less than 1 %; by name, what they move
    it by [m].
    """
    if worth.promise is None or not np.isfinite(worth.promise.rho0):
        return
    little = np.sqrt((1.0 + _LITTLE) ** 2 - 1.0) * worth.promise.rho0
    moved = {
        name: usual * _root_mean_square(study, study.fitted.names.index(name))
        for name, usual in _usual(study).items()
    }
    if few := {name: size for name, size in moved.items() if size < little}:
        yield Doubt("hardly-needed", tuple(few), numbers=few, unit="m")


def half_known(study: Study, worth: Assessment) -> Iterator[Doubt]:
    """Joints whose standard errors are no less than half of their usual compliances."""
    if worth.promise is None:
        return
    errors = dict(zip(study.springs.names, worth.promise.standard_error.tolist(), strict=True))
    shares = {name: errors[name] / usual for name, usual in _usual(study).items()}
    if bad := {name: share for name, share in shares.items() if _HALF < share < np.inf}:
        yield Doubt("half-known", tuple(bad), numbers=bad)


def _usual(study: Study) -> dict[str, float]:
    """Usual compliances of the joints to identify, as far as they are known."""
    if study.nuisance is None:
        return {}
    nominal = zip(study.robot.joint_names, study.nuisance.nominal.tolist(), strict=True)
    return {name: usual for name, usual in nominal if usual and name in study.springs.names}


def _root_mean_square(study: Study, column: int) -> float:
    """How far one of an unknown moves the tool at the test poses [m]."""
    squares = [
        float((p.regressors[:, :, column] ** 2).sum(axis=1).mean()) for p in study.test_poses
    ]
    return float(np.sqrt(study.shares @ squares))
