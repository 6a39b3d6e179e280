"""What no experiment can tell apart is found and named before anything is planned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.design.exact import Effort
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection
from elastocal.errors import Doubt, IdentifiabilityError
from elastocal.measuring.instrument import Isotropic
from elastocal.planning.assessment import assess
from elastocal.planning.plan import plan
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.sources import kuka_kr270
from elastocal.study.identifiability import unidentifiable
from elastocal.study.study import Experiments, Study, TestPose, springs_of
from tests.paper.problems import any_direction, kr270
from tests.paper.published import A0, CALIBRATION_FORCE

LIGHT = Effort(batch=12, generations=2, patience=1)  # any plan will do here
ALL = ["A1", "A2", "A3", "A4", "A5", "A6"]


def kuka(names: list[str], tool: Tool, force: FixedVector | FreeDirection, count: int) -> Study:
    robot = kuka_kr270()
    rows = np.random.default_rng(0).normal(size=(3, len(names)))
    return Study(
        robot,
        springs_of(robot, names),
        (TestPose("task", rows),),
        Experiments(tool, force, count),
        Isotropic(0.03e-3),
    )


def test_a_vertical_force_does_not_turn_the_first_joint() -> None:
    """Its axis is vertical: the paper identifies it in a second step, with other forces."""
    tool = kuka_kr270().tools["calibration"]
    study = kuka(ALL, tool, FixedVector(CALIBRATION_FORCE), 12)
    with pytest.raises(IdentifiabilityError) as error:
        plan(study)
    assert error.value.doubts == (Doubt("not-seen", ("A1",)),)


def test_with_a_force_in_any_direction_the_first_joint_is_identifiable() -> None:
    tool = kuka_kr270().tools["calibration"]
    found = plan(kuka(ALL, tool, any_direction(), 6), effort=LIGHT)
    assert np.isfinite(found.assessment.standard_error).all()


def test_a_marker_on_the_last_axis_does_not_see_the_last_joint() -> None:
    """The milling tool lies on axis 6: nothing moves its tip through A6, whatever the force."""
    tool = kuka_kr270().tools["milling"]
    with pytest.raises(IdentifiabilityError) as error:
        plan(kuka(ALL, tool, any_direction(), 12))
    assert error.value.doubts == (Doubt("not-seen", ("A6",)),)


def parallel_pair() -> Study:
    """Two joints with one axis in common, a metre apart along it: their columns are equal."""
    up = np.array([0.0, 0.0, 1.0])
    side = np.array([0.0, 1.0, 0.0])
    joints = (
        Joint("J1", np.eye(4), side, False, -1.0, 1.0),
        Joint("J2", transform(None, (1.0, 0.0, 0.3)), up, False, -1.0, 1.0),
        Joint("J3", transform(None, (0.0, 0.0, 1.0)), up, False, -1.0, 1.0),
    )
    robot = Robot("pair", joints)
    point = np.array([0.7, 0.0, 0.0])
    tool = Tool("tip", point, point[None], ("M1",))
    rows = np.random.default_rng(1).normal(size=(3, 3))
    return Study(
        robot,
        springs_of(robot, None),
        (TestPose("task", rows),),
        Experiments(tool, FreeDirection(100.0, up), 5),
        Isotropic(1e-5),
    )


def test_a_pair_of_joints_on_one_axis_is_named() -> None:
    with pytest.raises(IdentifiabilityError) as error:
        plan(parallel_pair())
    assert error.value.doubts == (Doubt("confounded", ("J2", "J3"), (), {"seen": 1}),)


def test_prior_knowledge_of_one_of_a_pair_resolves_it() -> None:
    study = parallel_pair()
    # A spring constant known to 10 % or so, as from a data sheet: one entry of information.
    prior = np.diag([0.0, 0.0, 1e10])
    found = plan(replace(study, prior=prior), effort=LIGHT)
    assert np.isfinite(found.assessment.standard_error).all()


def test_too_few_experiments_are_refused() -> None:
    """Three rows cannot fix five unknowns; two experiments have six."""
    with pytest.raises(IdentifiabilityError) as error:
        plan(kr270(A0, 1))
    numbers = {"count": 1, "needed": 2}
    assert error.value.doubts == (Doubt("too-few-experiments", tuple(ALL[1:]), (), numbers),)


def test_too_few_configurations_are_refused_however_often_repeated() -> None:
    with pytest.raises(IdentifiabilityError) as error:
        plan(kr270(A0, 12, 1))
    numbers = {"count": 1, "needed": 2}
    assert error.value.doubts == (Doubt("too-few-configurations", tuple(ALL[1:]), (), numbers),)


def test_a_plan_that_identifies_too_little_is_worth_nothing() -> None:
    """`assess` is given such plans by `evaluate`: infinite errors, no exception."""
    study = kr270(A0)
    cases = study.space.load_cases(study.space.sample(1, np.random.default_rng(0)))
    found = assess(study, cases, np.array([4]))
    assert not found.identifiable
    assert found.rho0 == np.inf
    assert np.isinf(found.standard_error).all()


def test_every_blind_spot_and_combination_is_named() -> None:
    names = ("J1", "J2", "J3", "J4")
    total = np.zeros((4, 4))
    total[1:3, 1:3] = 1.0  # J2 and J3 only as a sum, J1 not at all
    total[3, 3] = 1e6
    assert unidentifiable(names, total) == (
        Doubt("not-seen", ("J1",)),
        Doubt("confounded", ("J2", "J3"), (), {"seen": 1}),
    )
    assert unidentifiable(names, np.diag([1e-6, 1.0, 1e3, 1e6])) == ()
