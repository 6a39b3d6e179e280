"""The criteria by name, and their values as a user reads them.

`CRITERIA` maps a name to what it maximises; `losses` says what a plan is worth under all of them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import Criterion
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.observability import SingularValueRatio
from elastocal.design.test_pose import TestPosePrecision
from elastocal.design.worst import Worst
from elastocal.errors import InputError
from elastocal.study.study import Study


def mean_test_pose(study: Study) -> TestPosePrecision:
    """The paper's criterion (20), as weighted mean over the test poses."""
    weights = np.array([pose.weight for pose in study.test_poses])
    loss = sum(
        weight * pose.regressor.T @ pose.regressor
        for weight, pose in zip(weights / weights.sum(), study.test_poses, strict=True)
    )
    return TestPosePrecision(np.asarray(loss))


def _worst_test_pose(study: Study) -> Criterion:
    return Worst([TestPosePrecision(p.regressor.T @ p.regressor) for p in study.test_poses])


def _worst_coordinate(study: Study) -> Criterion:
    rows = np.concatenate([pose.regressor for pose in study.test_poses])
    rows = rows[np.abs(rows).sum(axis=1) > 0.0]
    return Worst([TestPosePrecision(np.outer(row, row)) for row in rows], "G")


CRITERIA: dict[str, tuple[Callable[[Study], Criterion], str]] = {
    "test-pose": (mean_test_pose, "mean position error after compensation at the test poses"),
    "worst": (_worst_test_pose, "largest position error over the test poses"),
    "G": (_worst_coordinate, "largest error of one coordinate over the test poses"),
    "A": (lambda s: MatrixMean(-1.0, "A"), "root mean square standard error of the compliances"),
    "D": (lambda s: MatrixMean(0.0, "D"), "volume of the confidence ellipsoid"),
    "E": (lambda s: MatrixMean(-np.inf, "E"), "longest axis of the confidence ellipsoid"),
    "O1": (lambda s: MatrixMean(0.0, "O1"), "geometric mean of the singular values (as D)"),
    "O2": (lambda s: SingularValueRatio(1, "O2"), "inverse condition number; no certificate"),
    "O3": (lambda s: MatrixMean(-np.inf, "O3"), "smallest singular value (as E)"),
    "O4": (lambda s: SingularValueRatio(2, "O4"), "noise amplification; no certificate"),
    "O5": (lambda s: MatrixMean(-0.5, "O5"), "inverse sum of singular values"),
}


POSITION_ERRORS = ("test-pose", "worst", "G")
"""The criteria whose loss is a position error [m]."""


def criterion_of(study: Study) -> Criterion:
    """The criterion the study plans for.

    Raises:
        InputError: unknown name.
    """
    if study.criterion not in CRITERIA:
        raise InputError(f"no criterion {study.criterion!r}; there are {', '.join(CRITERIA)}")
    return CRITERIA[study.criterion][0](study)


def losses(study: Study, information: Array) -> dict[str, float]:
    """Every criterion's value of a (p, p) information matrix, in physical units.

    test-pose, worst, G: position error [m], smaller is better. A, D, E: standard error of a
    compliance [rad/(N·m)]: root mean square, geometric mean of the axes, longest axis; smaller
    is better. O1 to O5: of the singular values of the stacked regressor [N·m²], as Table 1 of
    the paper; O5 smaller, the others larger is better.
    """
    matrix = information[None]

    def phi(name: str) -> float:
        return float(CRITERIA[name][0](study).value(matrix)[0])

    result = {name: _root_inverse(phi(name)) for name in POSITION_ERRORS}
    result |= {name: _root_inverse(phi(name)) for name in ("A", "D", "E")}
    p = len(information)
    singular = study.sigma * np.sqrt(np.maximum(np.linalg.eigvalsh(information), 0.0))
    smallest, largest = float(singular[0]), float(singular[-1])
    result["O1"] = float(np.exp(np.log(np.maximum(singular, 1e-300)).mean()))
    result["O2"] = smallest / largest if largest else 0.0
    result["O3"] = smallest
    result["O4"] = smallest**2 / largest if largest else 0.0
    result["O5"] = float((1.0 / singular).sum()) if smallest > 0.0 and p else np.inf
    return result


def _root_inverse(value: float) -> float:
    return float(1.0 / np.sqrt(value)) if value > 0.0 else np.inf
