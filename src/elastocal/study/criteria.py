"""The criteria by name: what each maximises, and what it is worth to a user.

`CRITERIA` is the only place that knows a name: files, screen, report and evaluation ask the entry
for its loss, unit and direction.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import Criterion
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.observability import SingularValueRatio
from elastocal.design.part import information_on, on_part
from elastocal.design.test_pose import TestPosePrecision
from elastocal.design.worst_pose import WorstPose
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import Doubt, InputError
from elastocal.study.study import Study


def root_inverse(study: Study, information: Array, function: Criterion) -> float:
    """1/√φ of a (p, p) information matrix: the loss of an information function."""
    value = float(function.value(information[None])[0])
    return float(1.0 / np.sqrt(value)) if value > 0.0 else np.inf


def metres(springs: VirtualJoints) -> str:
    """Unit of a position error."""
    return "m"


def compliances(springs: VirtualJoints) -> str:
    """Unit of a standard error of a compliance."""
    return "SI, mixed" if _mixed(springs) else springs.kinds[0].compliance


def _mixed(springs: VirtualJoints) -> bool:
    """Whether some springs turn and others slide."""
    return bool(springs.prismatic.any() and not springs.prismatic.all())


@dataclass(frozen=True)
class PlanCriterion:
    """All that is true of a criterion.

    Attributes:
        name: By which studies and the command line ask for it.
        function: Makes of a study what a search maximises.
        meaning: What it measures, in a few words.
        unit: SI unit of its loss, of the springs of a study; empty if it has none.
        measured: Its loss [unit] of a study, a (p, p) information matrix and its function.
        larger_is_better: Whether plans with a larger loss are better.
        symbol: What sentences call the loss; the name if not given.
        key: What the keys of files call the loss; the name if not given.
    """

    name: str
    function: Callable[[Study], Criterion]
    meaning: str
    unit: Callable[[VirtualJoints], str]
    measured: Callable[[Study, Array, Criterion], float] = root_inverse
    larger_is_better: bool = False
    symbol: str = ""
    key: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "symbol", self.symbol or self.name)
        object.__setattr__(self, "key", self.key or self.name)

    @property
    def is_position_error(self) -> bool:
        """Whether the loss is a position error [m]."""
        return self.unit is metres

    def loss(self, study: Study, information: Array) -> float:
        """Its value of a (p, p) information matrix [unit]."""
        return self.measured(study, information, self.function(study))


def mean_test_pose(study: Study) -> TestPosePrecision:
    """The paper's criterion (20), as weighted mean over the test poses and points of paths."""
    loss = sum(
        share * pose.regressor.T @ pose.regressor
        for share, pose in zip(study.shares, study.test_poses, strict=True)
        if share
    )
    return TestPosePrecision(np.asarray(loss))


def _worst_test_pose(study: Study) -> Criterion:
    return WorstPose(_stacked([pose.regressors for pose in study.planned_for]))


def _worst_coordinate(study: Study) -> Criterion:
    rows = np.concatenate([p.regressors.reshape(-1, len(study.fitted)) for p in study.planned_for])
    return _worst_of(rows[np.abs(rows).sum(axis=1) > 0.0])


def _worst_compliance(study: Study) -> Criterion:
    return _worst_of(np.eye(len(study.fitted))[study.wanted])


def _worst_of(rows: Array) -> Criterion:
    """1 over the largest variance of the combinations `rows` (K, p) of the compliances."""
    return WorstPose(rows[:, None, :])


def _stacked(blocks: list[Array]) -> Array:
    """Blocks (N, r, p) of different r, one below the other; rows of zeros add nothing."""
    most = max(block.shape[1] for block in blocks)
    return np.concatenate(
        [np.pad(block, ((0, 0), (0, most - block.shape[1]), (0, 0))) for block in blocks]
    )


def _mean(name: str, order: float, meaning: str) -> PlanCriterion:
    return PlanCriterion(name, partial(_of_wanted, MatrixMean(order)), meaning, compliances)


def _of_wanted(function: Criterion, study: Study) -> Criterion:
    """`function` of the compliances to identify, whatever the known ones are."""
    return on_part(function, study.wanted, len(study.fitted))


def _observability(
    name: str,
    function: Criterion,
    index: Callable[[Array], float],
    meaning: str,
    units: tuple[str, str] = ("N·m²", "N"),
    larger_is_better: bool = True,
) -> PlanCriterion:
    """An index of the singular values of the stacked regressor, as Table 1 of the paper.

    `units` are its units where all springs turn, and where all slide.
    """

    def unit_of(springs: VirtualJoints) -> str:
        if _mixed(springs):
            return "SI" if units[0] else ""
        return units[int(springs.prismatic.all())]

    def measured(study: Study, information: Array, _: Criterion) -> float:
        if len(study.fitted) > len(study.springs):
            information = information_on(study.wanted, information[None])[0]
        eigenvalues = np.linalg.eigvalsh(information)
        return index(study.sigma * np.sqrt(np.maximum(eigenvalues, 0.0)))

    made = partial(_of_wanted, function)
    return PlanCriterion(name, made, meaning, unit_of, measured, larger_is_better)


def _o1(singular: Array) -> float:
    return float(np.exp(np.log(np.maximum(singular, 1e-300)).mean()))


def _o2(singular: Array) -> float:
    return float(singular[0] / singular[-1]) if singular[-1] else 0.0


def _o3(singular: Array) -> float:
    return float(singular[0])


def _o4(singular: Array) -> float:
    return float(singular[0] ** 2 / singular[-1]) if singular[-1] else 0.0


def _o5(singular: Array) -> float:
    return float((1.0 / singular).sum()) if singular[0] > 0.0 else np.inf


RHO0 = PlanCriterion(
    "test-pose",
    mean_test_pose,
    "mean position error after compensation at the test poses",
    metres,
    symbol="ρ0",
    key="rho0",
)
"""The criterion whose loss is ρ0, the figure of merit of every plan."""

CRITERIA: dict[str, PlanCriterion] = {
    criterion.name: criterion
    for criterion in (
        RHO0,
        PlanCriterion(
            "worst",
            _worst_test_pose,
            "largest position error over the test poses",
            metres,
            symbol="worst ρ0",
        ),
        PlanCriterion(
            "coordinate",
            _worst_coordinate,
            "largest error of one coordinate over the test poses",
            metres,
            symbol="worst coordinate",
        ),
        _mean("A", -1.0, "root mean square standard error of the compliances"),
        _mean("D", 0.0, "volume of the confidence ellipsoid"),
        _mean("E", -np.inf, "longest axis of the confidence ellipsoid"),
        PlanCriterion(
            "G", _worst_compliance, "largest standard error of a compliance", compliances
        ),
        _observability("O1", MatrixMean(0.0), _o1, "geometric mean of the singular values (as D)"),
        _observability(
            "O2", SingularValueRatio(1), _o2, "inverse condition number; no certificate", ("", "")
        ),
        _observability("O3", MatrixMean(-np.inf), _o3, "smallest singular value (as E)"),
        _observability("O4", SingularValueRatio(2), _o4, "noise amplification; no certificate"),
        _observability(
            "O5",
            MatrixMean(-0.5),
            _o5,
            "sum of the inverse singular values",
            ("1/(N·m²)", "1/N"),
            False,
        ),
    )
}


RENAMED = {"G": "coordinate"}
"""Names that meant something else in 0.1.0, and what that is called now."""


def renamed(study: Study) -> tuple[Doubt, ...]:
    """That the criterion of a study has a name which once meant another."""
    old = study.criterion
    return (Doubt("criterion-renamed", (old, RENAMED[old])),) if old in RENAMED else ()


def criterion_of(study: Study) -> Criterion:
    """The criterion the study plans for.

    Raises:
        InputError: unknown name.
    """
    if study.criterion not in CRITERIA:
        raise InputError(f"no criterion {study.criterion!r}; there are {', '.join(CRITERIA)}")
    return CRITERIA[study.criterion].function(study)


def losses(study: Study, information: Array) -> dict[str, float]:
    """Every criterion's value of a (p, p) information matrix, in SI units; see its entry."""
    return {name: criterion.loss(study, information) for name, criterion in CRITERIA.items()}
