"""A study that knows what an earlier campaign found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.arrays import unset
from elastocal.elastic.compliance_model import refuse_other_springs
from elastocal.elastic.springs import VirtualJoints, merged, subset
from elastocal.errors import InputError
from elastocal.study.before import CarriedOut
from elastocal.study.criteria import CRITERIA
from elastocal.study.known import Known
from elastocal.study.left_rigid import counted, left_rigid
from elastocal.study.study import TestPose
from elastocal.study.test_path import test_path
from elastocal.study.two_steps import with_known
from elastocal.wording import worded
from tests.kr270 import FOLDER, kr270_study, kr270_truth, published_cases

OTHERS = ("A2", "A3", "A4", "A5", "A6")
SIDE = ec.LoadCases(
    np.radians([[0, -0.9, -2.9, 117.0, 35.6, -175.8], [0, -0.9, -30.8, 39.2, 78.0, -102.1]]),
    np.tile([0.0, 1000.0, 0.0, 0.0, 0.0, 0.0], (2, 1)),
)
TWICE = np.array([2, 2])


def first() -> Known:
    """A2 to A6 by the published plan of three configurations, four times each."""
    study = kr270_study()
    worth = ec.assess(study, published_cases(3), np.full(3, 4))
    return Known(ec.ComplianceModel(study.springs, np.zeros(5), worth.covariance), planned=True)


def second() -> ec.Study:
    return ec.read_study(FOLDER / "study_a1.yaml")


def by_hand(known: Known) -> np.ndarray:
    """(6, 6) covariance in (1e-6 rad/(N·m))², by numpy from rows of all six joints."""
    study = second()
    arm = replace(study.arm, springs=ec.joint_springs(study.robot))
    rows = 1e-6 * ec.regressor(arm, SIDE) / study.sigma
    information = 2.0 * np.einsum("nri,nrj->ij", rows, rows)
    information[1:, 1:] += np.linalg.inv(1e12 * known.model.covariance)
    return np.linalg.inv(information)


def test_the_worth_of_a_plan_is_that_of_both_steps() -> None:
    known = first()
    study = with_known(second(), known)
    worth = ec.assess(study, SIDE, TWICE)
    expected = by_hand(known)
    assert study.fitted.names == ("A1", *OTHERS)
    assert study.wanted == [0]
    np.testing.assert_allclose(1e12 * worth.covariance, expected, rtol=1e-6)
    assert 1e6 * worth.standard_error[0] == pytest.approx(np.sqrt(expected[0, 0]), rel=1e-8)
    (pose,) = study.test_poses
    assert pose.regressor.shape == (3, 6)
    whole = 1e-12 * np.trace(pose.regressor @ expected @ pose.regressor.T)
    assert worth.rho0**2 == pytest.approx(whole, rel=1e-8)
    # Without the first step's error the promise is too good, for A1 and much more so for the task.
    blind = ec.assess(second(), SIDE, TWICE)
    assert worth.standard_error[0] > 1.03 * blind.standard_error[0]
    assert worth.rho0 > 2.0 * blind.rho0


def test_the_classical_optimum_of_the_first_joint() -> None:
    """Alone, pulled across at the horizontal distance r: its standard error is σ/(F r² √m)."""
    study = second()
    at = ec.forward_kinematics(study.robot, SIDE.q) @ [*study.experiments.tool.load_point, 1.0]
    reach = np.linalg.norm(at[:, :2], axis=1)
    across = np.zeros((2, 6))
    across[:, :2] = 1000.0 * np.stack([-at[:, 1], at[:, 0]], axis=1) / reach[:, None]
    for i in range(2):
        case = ec.LoadCases(SIDE.q[i : i + 1], across[i : i + 1])
        error = ec.assess(study, case, np.array([4])).standard_error[0]
        assert error == pytest.approx(study.sigma / (1000.0 * reach[i] ** 2 * 2.0), rel=1e-9)
    assert reach[0] == pytest.approx(3.47, abs=0.01)


def test_criteria_of_compliances_look_at_the_wanted_ones_alone() -> None:
    """One wanted compliance: all are functions of its standard error, but the condition number."""
    study = with_known(second(), first())
    worth = ec.assess(study, SIDE, TWICE)
    error = worth.standard_error[0]
    for name in ("A", "D", "E", "G"):
        assert worth.criteria[name] == pytest.approx(error, rel=1e-8), name
    for name in ("O1", "O3", "O4"):
        assert worth.criteria[name] == pytest.approx(study.sigma / error, rel=1e-8), name
    assert worth.criteria["O2"] == pytest.approx(1.0)
    assert set(worth.criteria) == set(CRITERIA)


def test_what_is_known_exactly_changes_nothing() -> None:
    known = first()
    exact = replace(known, model=replace(known.model, covariance=np.zeros((5, 5))))
    study = with_known(second(), exact)
    assert study.fitted.names == ("A1",)
    worth, blind = ec.assess(study, SIDE, TWICE), ec.assess(second(), SIDE, TWICE)
    assert worth.rho0 == blind.rho0
    assert not list(left_rigid(study))


def test_knowing_more_and_knowing_something_else() -> None:
    """A prior of what is wanted stays; what was known before is replaced."""
    known = first()
    told = replace(second(), prior=np.array([[4e17]]))
    once = with_known(told, known)
    assert once.prior[0, 0] == 4e17
    np.testing.assert_allclose(once.prior[1:, 1:], known.information)
    few = replace(known, model=_part(known.model, ("A2", "A4")))
    again = with_known(once, few)
    assert again.fitted.names == ("A1", "A2", "A4")
    assert again.prior[0, 0] == 4e17
    back = with_known(again, None)
    assert back.known is None
    np.testing.assert_array_equal(back.prior, told.prior)
    np.testing.assert_array_equal(back.test_poses[0].regressor, told.test_poses[0].regressor)


def _part(model: ec.ComplianceModel, names: tuple[str, ...]) -> ec.ComplianceModel:
    index = [model.names.index(name) for name in names]
    covariance = model.covariance[np.ix_(index, index)]
    return ec.ComplianceModel(subset(model.springs, names), model.compliance[index], covariance)


def test_a_path_sees_the_errors_of_what_is_known() -> None:
    study = second()
    pose = study.test_poses[0]
    assert pose.case is not None
    assert pose.tool is not None
    arm = replace(study.arm, tool=pose.tool)
    cases = ec.LoadCases(np.tile(pose.case.q, (3, 1)), np.tile(pose.case.wrench, (3, 1)))
    path = test_path(arm, cases, 1.0, "milling")
    known = first()
    whole = ec.assess(with_known(replace(study, test_poses=(path,)), known), SIDE, TWICE)
    one = ec.assess(with_known(study, known), SIDE, TWICE)
    assert whole.rho0 == pytest.approx(one.rho0, rel=1e-10)


def test_a_matrix_for_a_test_pose_needs_a_column_for_all() -> None:
    study = second()
    narrow = replace(study, test_poses=(TestPose("given", np.ones((3, 1))),))
    with pytest.raises(InputError, match=r"'given' is a matrix of 1 columns; .* needs 6"):
        with_known(narrow, first())


def test_what_is_known_of_the_wanted_ones_is_a_prior() -> None:
    study = kr270_study()
    with pytest.raises(InputError, match=r"which the study identifies; .* is a prior"):
        with_known(study, first())


def test_joints_left_rigid_are_told_apart_by_what_the_task_does() -> None:
    """A1 is bent by 280 N sideways; with the force in its plane it is not."""
    study = kr270_study()
    (doubt,) = left_rigid(study)
    assert (doubt.code, doubt.about, doubt.because) == ("rigid-at-test-pose", ("A1",), ("milling",))
    (pose,) = study.test_poses
    assert pose.case is not None
    assert pose.tool is not None
    bent = ec.ElasticArm(study.robot, ec.joint_springs(study.robot, ["A1"]), pose.tool.at_tcp)
    move = ec.deflection(bent, np.array([1e-7]), pose.case)[:, :3]
    assert 1e-7 * doubt.numbers["A1"] == pytest.approx(np.linalg.norm(move), rel=1e-9)
    assert doubt.unit == "rad/(N·m)"
    assert "every 0.1 µrad/(N·m) of A1 adds up to 94.1 µm there" in worded(doubt)
    assert counted(study) == ("A2", "A3", "A4", "A5", "A6")
    inside = ec.LoadCases(pose.case.q * [0, 1, 1, 0, 0, 0], [[300.0, 0, -180, 0, 0, 0]])
    arm = replace(study.arm, tool=pose.tool)
    plane = replace(study, test_poses=(ec.test_pose(arm, inside, 1.0, "plane"),))
    (doubt,) = left_rigid(plane)
    assert (doubt.code, doubt.about) == ("taken-as-rigid", ("A1",))
    assert not list(left_rigid(with_known(second(), first())))


def test_both_steps_leave_the_error_that_is_promised() -> None:
    """2000 campaigns of the first step, each followed by its own second: (20) and 41 of math.md.

    Nonlinear truth and fits; what the second step knows is what its own first step found.
    """
    from elastocal.identification.batch import Design, fit_all
    from elastocal.simulation.beforehand import rows_known
    from elastocal.simulation.remaining_error import errors_left, judge
    from elastocal.simulation.virtual_campaign import noise, virtual_readings

    one, known = kr270_study(), first()
    two = with_known(second(), known)
    truth = kr270_truth(one)
    rng = np.random.default_rng(20)
    number = 2000

    def fitted(
        study: ec.Study, cases: ec.LoadCases, repeats: np.ndarray, before: np.ndarray | None
    ):  # type: ignore[no-untyped-def]
        ideal = virtual_readings(study.fitted_arm, study.instrument, truth, cases, linear=False)
        case = np.repeat(np.arange(len(cases)), repeats)
        free = np.array([truth.names.index(name) for name in study.fitted.names])
        design = Design(
            ideal.arm,
            free,
            truth.compliance,
            cases,
            case,
            ideal.covariance,
            False,
            rows_known(study),
        )
        many = np.tile(case, number)
        read = ideal.deflection[many] + noise(ideal.covariance, many, rng)
        return fit_all(design, read.reshape(number, len(case), 1, 3), before).compliance

    early = fitted(one, published_cases(3), np.full(3, 4), None)
    late = fitted(two, SIDE, TWICE, np.hstack([np.zeros((number, 1)), early]))
    worth = ec.assess(two, SIDE, TWICE)
    left = errors_left(judge(two.fitted_arm, truth, two.test_poses[0], linear=False), late)
    # The mean of 2000 squares of two or three normals is within 3 % (of the root) nearly always.
    assert np.sqrt(np.mean(left**2)) == pytest.approx(worth.rho0, rel=0.03)
    spread = late.std(axis=0) / np.sqrt(np.diagonal(worth.covariance))
    np.testing.assert_allclose(spread, 1.0, atol=0.06)
    # Control: the second step by itself promises a third of that, or less.
    blind = ec.assess(second(), SIDE, TWICE).rho0
    assert np.sqrt(np.mean(left**2)) > 2.0 * blind


def test_a_plan_carried_out_before_bent_the_known_springs_too() -> None:
    """Twice two experiments: the same worth whether the first two are prior or planned."""
    known, study = first(), second()
    carried_out = CarriedOut(SIDE, np.array([1, 1]), sha256="b")
    prior = carried_out.information(study.space)
    told = with_known(replace(study, prior=prior, carried_out=carried_out), known)
    worth = ec.assess(told, SIDE, np.array([1, 1]))
    np.testing.assert_allclose(1e12 * worth.covariance, by_hand(known), rtol=1e-6)
    # Counted on the wanted spring alone, the errors of the others would be left out.
    blind = with_known(replace(study, prior=prior), known)
    assert ec.assess(blind, SIDE, np.array([1, 1])).standard_error[0] < 0.98 * worth.standard_error
    # What was known is replaced; what was carried out stays.
    again = with_known(with_known(told, None), known)
    np.testing.assert_allclose(again.prior, told.prior, rtol=1e-12)
    one = replace(study, carried_out=replace(carried_out, sha256="a"))
    with pytest.raises(InputError, match=r"p\.json: is the plan of the prior, too"):
        with_known(one, replace(known, source="p.json", sha256="a"))


def test_another_spring_of_the_same_name_is_refused() -> None:
    """A spring at the base: body, type, axis and origin make it, not its name."""
    study = kr270_study()
    place = {"body": [0], "joint": [-1], "prismatic": [False]}
    base = VirtualJoints(("base",), axis=[[0.0, 1.0, 0.0]], origin=[[0.1, 0.0, -0.5]], **place)
    model = ec.ComplianceModel(base, [1e-8], [[1e-18]])
    refuse_other_springs(model, study.springs)
    for same in (
        replace(base, axis=-base.axis),
        replace(base, origin=np.add(base.origin, [0.0, 2.0, 0.0])),  # further along its axis
    ):
        refuse_other_springs(model, merged(study.springs, same))
    for other in (
        replace(base, axis=[[1.0, 0.0, 0.0]]),
        replace(base, origin=np.add(base.origin, [0.0, 0.0, 0.01])),
        replace(base, body=[1]),
        replace(base, prismatic=[True]),
    ):
        springs = merged(study.springs, other)
        with pytest.raises(InputError, match="'base' is another one than that of the study"):
            refuse_other_springs(model, springs)
        with pytest.raises(InputError, match="'base' is another one"):
            with_known(replace(study, springs=springs, prior=unset()), Known(model))
