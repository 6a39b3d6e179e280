"""A path as a test pose: the mean over its points, its worst point, and weights of zero."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import InputError
from elastocal.simulation.remaining_error import errors_left, judge
from elastocal.study.criteria import CRITERIA
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath
from tests.design.examples import study_with_two_test_poses

COVARIANCE = np.linalg.inv(np.diag([1.0, 4.0, 9.0]) + 0.3)


def along(study: Study, points: int, weight: float = 1.0) -> TestPath:
    """A path of the arm of a study."""
    rng = np.random.default_rng(4)
    q = np.linspace([0.1, 0.4, -0.9], [0.5, 0.9, 0.3], points)
    wrench = np.hstack([rng.normal(size=(points, 3)), np.zeros((points, 3))])
    return ec.test_path(study.arm, ec.LoadCases(q, wrench), weight, "path")


def with_path(points: int) -> tuple[Study, Study]:
    """A study with a path, and one with each of its points as a test pose."""
    study = study_with_two_test_poses()
    path = along(study, points)
    poses = tuple(
        ec.test_pose(study.arm, ec.LoadCases(q[None], w[None]), 1.0, f"point {i + 1}")
        for i, (q, w) in enumerate(zip(path.cases.q, path.cases.wrench, strict=True))
    )
    return replace(study, test_poses=(path,)), replace(study, test_poses=poses)


@pytest.mark.parametrize("points", [1, 2, 60])
def test_a_path_is_worth_what_its_points_are_worth(points: int) -> None:
    path, poses = with_path(points)
    information = np.linalg.inv(COVARIANCE)
    for name in ("test-pose", "worst", "coordinate"):
        found = CRITERIA[name].loss(path, information)
        assert found == pytest.approx(CRITERIA[name].loss(poses, information), rel=1e-12)
    regressor = path.test_poses[0].regressor
    assert len(regressor) <= 3
    each = [p.regressor for p in poses.test_poses]
    mean = np.mean([np.trace(a @ COVARIANCE @ a.T) for a in each])
    assert np.trace(regressor @ COVARIANCE @ regressor.T) == pytest.approx(mean, rel=1e-12)


def test_a_path_weighs_as_a_whole() -> None:
    """Not by its number of points: next to a pose of the same weight it counts one half."""
    study = study_with_two_test_poses()
    path = along(study, 50, weight=3.0)
    both = replace(study, test_poses=(study.test_poses[1], path))
    squares = [np.trace(p.regressor @ COVARIANCE @ p.regressor.T) for p in both.test_poses]
    found = CRITERIA["test-pose"].loss(both, np.linalg.inv(COVARIANCE))
    assert found**2 == pytest.approx(np.mean(squares), rel=1e-12)


def test_a_weight_of_zero_is_judged_and_not_planned_for() -> None:
    study, information = study_with_two_test_poses(), np.linalg.inv(COVARIANCE)
    first, second = study.test_poses
    first = replace(first, regressor=2.0 * first.regressor)  # the worst by far
    study = replace(study, test_poses=(first, second))
    judged = replace(study, test_poses=(replace(first, weight=0.0), second))
    alone = replace(study, test_poses=(second,))
    for name in ("test-pose", "worst", "coordinate"):
        value = CRITERIA[name].loss(judged, information)
        assert value == CRITERIA[name].loss(alone, information)
        assert value != CRITERIA[name].loss(study, information)  # the control
    assert judged.shares.tolist() == [0.0, 1.0]
    assert judged.planned_for == (second,)
    assert len(ec.assess(judged, second.case, np.array([3])).rho0_each) == 2


@pytest.mark.parametrize(
    ("weights", "said"),
    [
        ((0.0, 0.0), "every test pose has weight 0"),
        ((-1.0, 2.0), "0 or more and finite"),
        ((np.nan, 2.0), "0 or more and finite"),
        ((np.inf, 2.0), "0 or more and finite"),
    ],
)
def test_weights_that_leave_nothing_to_plan_for_are_refused(
    weights: tuple[float, float], said: str
) -> None:
    study = study_with_two_test_poses()
    poses = zip(study.test_poses, weights, strict=True)
    with pytest.raises(InputError, match=said):
        replace(study, test_poses=tuple(replace(p, weight=w) for p, w in poses))


def test_virtual_campaigns_judge_a_path_as_its_points() -> None:
    """Exact equilibria at every point against the derivative at the truth: estimates that are off
    by 1 percent are judged alike to about as much; without the load's own part they are not."""
    study = study_with_two_test_poses()
    truth = ec.ComplianceModel(study.springs, np.array([0.05, 0.08, 0.06]), np.zeros((3, 3)))
    path, poses = with_path(9)
    estimates = truth.compliance * (1.0 + 0.01 * np.random.default_rng(0).normal(size=(5, 3)))
    each = [
        errors_left(judge(study.arm, truth, pose, linear=False), estimates)
        for pose in poses.test_poses
    ]
    expected = np.sqrt(np.mean(np.square(each), axis=0))
    found = errors_left(judge(study.arm, truth, path.test_poses[0], linear=False), estimates)
    assert found == pytest.approx(expected, rel=0.02)
    plain = errors_left(judge(study.arm, truth, path.test_poses[0], linear=True), estimates)
    assert np.abs(plain / expected - 1.0).max() > 0.03
