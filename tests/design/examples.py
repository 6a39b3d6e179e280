"""Every criterion there is, ready to be put to the same tests."""

from __future__ import annotations

import numpy as np

from elastocal.design.criterion import Criterion, InformationFunction
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.observability import SingularValueRatio
from elastocal.design.part import InformationOnPart, OnPart
from elastocal.design.power_mean import PowerMean, floored
from elastocal.design.test_pose import TestPosePrecision
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.measuring.instrument import Isotropic
from elastocal.robot.sources import three_link
from elastocal.study.criteria import CRITERIA
from elastocal.study.study import Experiments, Study, test_pose
from tests.design.worst import Worst

PARAMETERS = 3


def study_with_two_test_poses() -> Study:
    """The three-link arm, judged in two poses of unequal weight."""
    robot = three_link()
    springs, tip = joint_springs(robot), robot.tools["tip"]
    tasks = [((0.0, 1.0, -0.8), (0.3, 0.3, -1.0), 1.0), ((0.4, 0.2, 0.9), (1.0, -0.5, 0.2), 3.0)]
    poses = tuple(
        test_pose(
            ElasticArm(robot, springs, tip),
            LoadCases(np.array([q]), np.array([[*force, 0.0, 0.0, 0.0]])),
            weight,
            f"task {i + 1}",
        )
        for i, (q, force, weight) in enumerate(tasks)
    )
    experiments = Experiments(tip, FixedVector(np.array([0.0, 0.6, -0.8])), 4)
    return Study(robot, springs, poses, experiments, Isotropic(1.0))


def _members() -> list[InformationFunction]:
    rng = np.random.default_rng(0)
    return [
        TestPosePrecision(root @ root.T) for root in rng.normal(size=(4, PARAMETERS, PARAMETERS))
    ]


def _information_functions() -> dict[str, InformationFunction]:
    study = study_with_two_test_poses()
    by_name = {name: criterion.function(study) for name, criterion in CRITERIA.items()}
    functions = {n: c for n, c in by_name.items() if isinstance(c, InformationFunction)}
    for order in (0.0, -0.5, -1.0, -2.0, -7.5, -np.inf):
        functions[f"matrix mean of order {order:g}"] = MatrixMean(order)
    functions["rank-deficient test pose"] = TestPosePrecision(np.diag([1.0, 2.0, 0.0]))
    functions["worst of four"] = Worst(_members())
    functions["power mean of four"] = PowerMean(_members(), sharpness=3.0)
    functions["sharp power mean of four"] = PowerMean(_members())
    functions["worst of D and E"] = Worst([MatrixMean(0.0), MatrixMean(-np.inf)])
    functions["floored test pose"] = floored(
        TestPosePrecision(np.diag([1.0, 2.0, 0.0])), np.diag([1.0, 4.0, 100.0]), 1e-2
    )
    for name, order in (("A", -1.0), ("D", 0.0), ("E", -np.inf)):
        functions[f"{name} of two"] = InformationOnPart(MatrixMean(order), (2, 1))
    functions["floored E"] = floored(MatrixMean(-np.inf), np.diag([1.0, 4.0, 100.0]), 1e-2)
    return functions


INFORMATION_FUNCTIONS = _information_functions()
SMOOTH = {name: f for name, f in INFORMATION_FUNCTIONS.items() if f.smooth is f}
ALL: dict[str, Criterion] = {
    **{name: c.function(study_with_two_test_poses()) for name, c in CRITERIA.items()},
    "O2 of two": OnPart(SingularValueRatio(1), (0, 1)),
    **INFORMATION_FUNCTIONS,
}


def information_matrix(rng: np.random.Generator, p: int = PARAMETERS) -> np.ndarray:
    """A random information matrix of condition number up to a thousand or so."""
    rows = rng.normal(size=(p + 2, p)) * 10.0 ** rng.uniform(-1.0, 1.0, p)
    return rows.T @ rows
