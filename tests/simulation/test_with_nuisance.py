"""Campaigns on robots with nuisance: what plans promise is found, and without the fit it is not."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import IdentifiabilityError
from elastocal.files.study.study_file import parse_study
from elastocal.planning.promise import promise
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.simulation.true_robot import TrueRobot
from elastocal.simulation.with_nuisance import error_left
from elastocal.study.study import Study
from tests.kr270 import FOLDER, kr270_truth

ASLANT = """
elastocal: 1
robot: kuka-kr270
tools:
  milling: {tcp_mm: [986, 0, 0]}
  calibration:
    load_point_mm: [611.5, 0, -460]
    markers_mm: {M1: [611.5, 0, -460], M2: [611.5, 0, 460], M3: [611.5, 460, 0]}
test_poses:
  - name: milling
    tool: milling
    q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2]
    force_N: [0, 280, -180]
experiments:
  tool: calibration
  max_force_N: 2500
  direction: {axis: [0, 0, -1], half_angle_deg: 45}
  count: 12
instrument: {sigma_mm: .03}
constraints: {workspace: {min_z_mm: 800, min_radius_mm: 600}}
nuisance: typical
"""


@cache
def aslant() -> Study:
    return parse_study(ASLANT, FOLDER / "study.yaml")


@cache
def random_plan() -> tuple[ec.LoadCases, np.ndarray]:
    space = aslant().space
    cases = space.load_cases(space.sample(12, np.random.default_rng(2)))
    return cases, np.ones(12, dtype=np.int64)


@cache
def found(fitted: str = "mixed", number: int = 40) -> MonteCarlo:
    study, how = aslant(), ec.Fit(fitted=fitted)  # type: ignore[arg-type]
    return ec.campaigns(
        study, kr270_truth(study), {"random": random_plan()}, number, seed=1, how=how
    )


def test_the_promise_is_found() -> None:
    """40 campaigns tell a root mean square to about a tenth."""
    (one,) = found().plans
    assert found().nuisance
    assert one.rms == pytest.approx(one.rho0, rel=0.25)
    assert one.within >= 0.85
    assert (one.coverage >= 0.8).all()
    told = promise(aslant(), *random_plan())
    assert told is not None
    assert one.rho0 == pytest.approx(told.rho0, rel=1e-9)
    assert one.limit == pytest.approx(told.limit, rel=1e-9)


def test_a_fit_of_the_joints_alone_does_not_keep_it() -> None:
    """The negative control: the same robots."""
    (mixed,), (joints,) = found().plans, found("joints", 20).plans
    assert joints.rms > 1.5 * mixed.rms
    assert joints.coverage.min() < 0.5


def test_the_number_of_workers_changes_nothing() -> None:
    study = aslant()
    one, two = (
        ec.campaigns(study, kr270_truth(study), {"p": random_plan()}, 4, seed=3, workers=w).plans[0]
        for w in (1, 2)
    )
    np.testing.assert_array_equal(one.estimate, two.estimate)
    np.testing.assert_array_equal(one.error, two.error)


def test_the_error_left_is_that_of_compensation() -> None:
    """By `compensate` and `residual`, on the true arm, under the force that acts."""
    study, pose = aslant(), aslant().test_poses[0]
    assert isinstance(pose, ec.TestPose)
    assert pose.case is not None
    assert pose.tool is not None
    truth = kr270_truth(study)
    true = TrueRobot(truth)
    model = replace(truth, compliance=truth.compliance * [1.1, 0.9, 1.05, 0.95, 1.02, 0.97])
    arm = ec.ElasticArm(study.robot, truth.springs, pose.tool)
    done = ec.compensate(arm, model, pose.case)
    left = ec.residual(arm, truth, done)
    assert error_left(study, pose, model, true) == pytest.approx(np.linalg.norm(left), rel=0.02)
    linear = error_left(study, pose, model, true, linear=True)
    assert linear == pytest.approx(np.linalg.norm(left), rel=0.05)


def test_a_plan_that_tells_too_little_is_refused() -> None:
    study = aslant()
    cases, repeats = random_plan()
    flat = ec.LoadCases(cases.q[:1], [[0.0, 0.0, -2500.0, 0.0, 0.0, 0.0]])
    with pytest.raises(IdentifiabilityError, match="does not tell all compliances apart"):
        ec.campaigns(study, kr270_truth(study), {"one": (flat, repeats[:1])}, 3)
