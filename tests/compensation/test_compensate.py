"""Compensation: always judged by the nonlinear equilibrium, never by the formula that corrected."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import root

import elastocal as ec
from elastocal.arrays import Array
from elastocal.compensation.compensate import (
    Compensation,
    compensate,
    compensate_linearly,
    residual,
)
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel, merged_models
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.errors import Doubt, InputError
from elastocal.files.models.model_file import read_model
from elastocal.files.paths.path_file import read_path
from elastocal.robot.chain import Robot, Tool, transform
from elastocal.robot.shapes import BodyMass
from tests.arms import Oracle, chain_with_springs, random_chain, random_tool

EXAMPLE = Path(__file__).parents[2] / "examples" / "kr270"
KUKA = ec.load_robot("kuka-kr270")
MILLING = KUKA.tools["milling"]
TEST_POSE = np.radians([0.0, -56.9, 89.3, 45.1, 76.0, 57.2])
TRUTH = read_model(EXAMPLE / "truth.json", KUKA)
ARM = ElasticArm(KUKA, TRUTH.springs, MILLING)
PATH = read_path(EXAMPLE / "path.csv", KUKA, MILLING, TEST_POSE).cases
THREE = ec.load_robot("three-link")
TIP = THREE.tools["tip"]
MM = 1e-3


def sizes(vectors: Array) -> Array:
    return np.linalg.norm(vectors, axis=1)


def base_springs(robot: Robot, body: int = 0) -> VirtualJoints:
    """Three linear and two angular springs of a body that are in no joint."""
    axes = np.vstack([np.eye(3), np.eye(3)[:2]])
    return VirtualJoints(
        names=tuple(f"base {body} {i}" for i in range(5)),
        body=np.full(5, body),
        axis=axes,
        origin=np.zeros((5, 3)),
        prismatic=np.array([True, True, True, False, False]),
    )


def with_base(robot: Robot, compliance: Array, body: int = 0) -> ComplianceModel:
    """Joint springs of all joints, and springs in a body: 1e-8 m/N and 5e-8 rad/(N·m)."""
    own = ComplianceModel(joint_springs(robot), compliance)
    others = ComplianceModel(base_springs(robot, body), np.array([1e-8] * 3 + [5e-8] * 2))
    return merged_models([own, others])


def loaded_tcp(model: ComplianceModel, robot: Robot, tool: Tool, q: Array, wrench: Array) -> Array:
    """(4, 4) pose of the TCP under load by Pinocchio, at the displacements of the equilibrium."""
    arm = ElasticArm(robot, model.springs, tool)
    theta = equilibrium(arm, model.compliance, LoadCases(q[None], wrench[None])).displacement[0]
    chain, virtual, actuated = chain_with_springs(robot, model.springs)
    joints = np.zeros(len(chain.joints))
    joints[actuated], joints[virtual] = q, theta
    return Oracle(chain).forward(joints) @ transform(None, tool.tcp)


# The milling path of the KR 270 -----------------------------------------------------------------


def test_before_compensation_the_path_is_off_by_a_millimetre() -> None:
    done = compensate(ARM, TRUTH, PATH)
    judged = MILLING.at_tcp
    expected = ec.loaded_deflection(replace(ARM, tool=judged), TRUTH.compliance, PATH)
    np.testing.assert_allclose(done.before, expected, atol=1e-15)
    assert len(done) == 200
    assert 0.9 * MM < sizes(done.before).min() < sizes(done.before).max() < 1.6 * MM


@pytest.mark.parametrize("rule", [compensate, compensate_linearly])
def test_with_the_true_compliances_nothing_remains(rule: object) -> None:
    """Also with the linear rule: with springs in joints alone J0⁻¹ A k is k ∘ y(q0), exactly."""
    done: Compensation = rule(ARM, TRUTH, PATH)  # type: ignore[operator]
    assert done.converged.all()
    assert not done.damped.any()
    assert not any(done.doubts)
    assert done.notes == ()
    assert sizes(residual(ARM, TRUTH, done)).max() < 1e-6 * MM
    assert sizes(done.after).max() < 1e-6 * MM


def test_orientation_is_restored_too() -> None:
    done = compensate(ARM, TRUTH, PATH)
    for i in (0, 57, 133):
        pose = loaded_tcp(TRUTH, KUKA, MILLING, done.q[i], PATH.wrench[i])
        np.testing.assert_allclose(pose, done.target[i], atol=1e-12)


def test_the_command_is_the_rigid_arm_at_the_corrected_configuration() -> None:
    done = compensate(ARM, TRUTH, PATH)
    expected = ec.forward_kinematics(KUKA, done.q) @ transform(None, MILLING.tcp)
    np.testing.assert_allclose(done.command, expected, atol=1e-14)
    # To first order it is the target, moved against the deflection.
    moved = done.command[:, :3, 3] - done.target[:, :3, 3]
    assert sizes(moved + done.before).max() < 0.01 * sizes(done.before).min()


def test_with_the_wrong_sign_it_gets_worse() -> None:
    """Negative control: the judge must see a correction the wrong way."""
    wrong = ComplianceModel(TRUTH.springs, -TRUTH.compliance)
    done = compensate(ARM, wrong, PATH)
    ratio = sizes(residual(ARM, TRUTH, done)) / sizes(compensate(ARM, TRUTH, PATH).before)
    assert ratio.min() > 1.9
    assert ratio.max() < 2.1


def test_a_rigid_axis_leaves_its_share_and_is_said() -> None:
    keep = [i for i, name in enumerate(TRUTH.names) if name != "A1"]
    model = ComplianceModel(joint_springs(KUKA, TRUTH.names[1:]), TRUTH.compliance[keep])
    done = compensate(ElasticArm(KUKA, model.springs, MILLING), model, PATH)
    assert [(note.code, note.about, note.unit) for note in done.notes] == [
        ("rigid-but-loaded", ("A1",), "N·m")
    ]
    only_a1 = ComplianceModel(joint_springs(KUKA, ["A1"]), TRUTH.compliance[:1])
    share = compensate(ElasticArm(KUKA, only_a1.springs, MILLING), only_a1, PATH).before
    left = residual(ARM, TRUTH, done)
    assert sizes(left).max() > 0.1 * MM
    assert sizes(left - share).max() < 0.02 * sizes(share).max()


def test_two_campaigns_make_one_model() -> None:
    """A2 to A6 under a vertical load, A1 from another campaign."""
    a1 = ComplianceModel(joint_springs(KUKA, ["A1"]), TRUTH.compliance[:1], [[1e-16]], 4.0, "two")
    rest = ComplianceModel(
        joint_springs(KUKA, TRUTH.names[1:]), TRUTH.compliance[1:], np.eye(5) * 1e-18, 9.0, "one"
    )
    both = merged_models([rest, a1])
    assert both.names == TRUTH.names
    np.testing.assert_array_equal(both.compliance, TRUTH.compliance)
    np.testing.assert_array_equal(np.diagonal(both.covariance), [1e-16, *[1e-18] * 5])
    assert (both.dof, both.source) == (4.0, "one, two")
    with pytest.raises(InputError, match="'A1' is given twice"):
        merged_models([a1, a1])


# Uncertain compliances --------------------------------------------------------------------------


def test_rho0_is_the_formula_of_the_plan() -> None:
    rng = np.random.default_rng(0)
    root_ = rng.normal(size=(6, 6)) * 2e-8
    model = ComplianceModel(TRUTH.springs, TRUTH.compliance, root_ @ root_.T)
    case = LoadCases(TEST_POSE[None], np.array([[0.0, 280.0, -180.0, 0.0, 0.0, 0.0]]))
    done = compensate(ARM, model, case)
    rows = ec.test_pose(ARM, case, 1.0, "milling").regressor
    assert done.rho0[0] == pytest.approx(np.sqrt(np.trace(rows @ model.covariance @ rows.T)))


@pytest.mark.parametrize("linear", [False, True])
def test_what_remains_is_within_the_predicted_rho0(linear: bool) -> None:
    """400 identified models: mean square, covariance and bias at points all along the path."""
    rng = np.random.default_rng(7)
    root_ = np.diag(0.03 * TRUTH.compliance) @ (np.eye(6) + 0.3 * rng.normal(size=(6, 6)))
    covariance = root_ @ root_.T
    cases = LoadCases(PATH.q[::40], PATH.wrench[::40])
    rule = compensate_linearly if linear else compensate
    draws = 400
    estimates = rng.multivariate_normal(TRUTH.compliance, covariance, draws)
    left = np.array(
        [
            residual(ARM, TRUTH, rule(ARM, ComplianceModel(TRUTH.springs, k, covariance), cases))
            for k in estimates
        ]
    )
    done = rule(ARM, ComplianceModel(TRUTH.springs, TRUTH.compliance, covariance), cases)
    found = np.sqrt((left**2).sum(axis=2).mean(axis=0))
    # Relative standard error of a root mean square of 400 draws: at most 1/√(2·400) = 3.5 %.
    np.testing.assert_allclose(found, done.rho0, rtol=0.12)
    for i in range(len(cases)):
        scale = np.trace(done.covariance[i])
        np.testing.assert_allclose(np.cov(left[:, i].T), done.covariance[i], atol=0.2 * scale)
    # Unbiased, eq. (16): the mean is within sampling error of zero.
    assert (sizes(left.mean(axis=0)) < 4.0 * done.rho0 / np.sqrt(draws)).all()
    assert (found < 0.1 * sizes(done.before)).all()


# Closed form, independent solvers, random arms ---------------------------------------------------


@settings(max_examples=40)
@given(st.integers(0, 10**6), st.sampled_from([3, 6, 7]))
def test_joint_springs_have_a_closed_form(seed: int, count: int) -> None:
    """q0 - k ∘ y(q0, w): the effort by Pinocchio's Jacobian at the configuration that is wanted."""
    rng = np.random.default_rng(seed)
    slides = rng.random(count) < 0.2
    robot, tool = random_chain(rng, slides), random_tool(rng, 1)
    tool = replace(tool, tcp=rng.uniform(-1, 1, 3))
    oracle = Oracle(robot)
    k = np.where(slides, 1e-7, 1e-6) * rng.uniform(0.3, 3.0, count)
    model = ComplianceModel(joint_springs(robot), k)
    cases = LoadCases(rng.uniform(-3, 3, (3, count)), rng.uniform(-1, 1, (3, 6)) * 500.0)
    done = compensate(ElasticArm(robot, model.springs, tool), model, cases)
    assert done.converged.all()
    frame = oracle.at(tool.load_point)
    for i in range(3):
        effort = oracle.jacobian(cases.q[i], frame).T @ cases.wrench[i]
        np.testing.assert_allclose(done.q[i], cases.q[i] - k * effort, atol=1e-15, rtol=1e-13)
        pose = loaded_tcp(model, robot, tool, done.q[i], cases.wrench[i])
        np.testing.assert_allclose(pose, done.target[i], atol=1e-11)


@settings(max_examples=25)
@given(st.integers(0, 10**6), st.integers(0, 6))
def test_springs_in_links_are_compensated_too(seed: int, body: int) -> None:
    rng = np.random.default_rng(seed)
    robot, tool = random_chain(rng, [False] * 6), random_tool(rng, 1)
    model = with_base(robot, rng.uniform(0.3, 3.0, 6) * 1e-6, body)
    arm = ElasticArm(robot, model.springs, tool)
    q, wrench = rng.uniform(-3, 3, 6), rng.uniform(-1, 1, 6) * 500.0
    done = compensate(arm, model, LoadCases(q[None], wrench[None]))
    if done.damped[0]:
        return
    assert done.converged[0], done.doubts
    pose = loaded_tcp(model, robot, tool, done.q[0], wrench)
    np.testing.assert_allclose(pose, done.target[0], atol=1e-11)


def test_an_independent_solver_finds_the_same() -> None:
    """SciPy's root finder on the loaded pose, with the equilibrium inside: eq. (14) as it is."""
    model = with_base(KUKA, TRUTH.compliance)
    wrench = np.array([200.0, 900.0, -1800.0, 20.0, -50.0, 10.0])
    done = compensate(
        ElasticArm(KUKA, model.springs, MILLING), model, LoadCases(TEST_POSE[None], wrench[None])
    )

    def missing(q: Array) -> Array:
        pose = loaded_tcp(model, KUKA, MILLING, q, wrench)
        turn = pose[:3, :3] @ done.target[0, :3, :3].T
        return np.append(pose[:3, 3] - done.target[0, :3, 3], [turn[2, 1], turn[0, 2], turn[1, 0]])

    found = root(missing, TEST_POSE, tol=1e-13)
    np.testing.assert_allclose(done.q[0], found.x, atol=1e-10)
    assert done.iterations[0] >= 2


def test_the_linear_rule_is_off_by_second_order_where_springs_are_in_the_base() -> None:
    model = with_base(KUKA, TRUTH.compliance)
    arm = ElasticArm(KUKA, model.springs, MILLING)
    errors = []
    for scale in (1.0, 2.0, 4.0):
        cases = LoadCases(PATH.q[::40], scale * PATH.wrench[::40])
        done = compensate_linearly(arm, model, cases)
        np.testing.assert_allclose(done.after, residual(arm, model, done), atol=1e-15)
        errors.append(sizes(done.after).max())
        assert sizes(compensate(arm, model, cases).after).max() < 1e-6 * MM
    assert 1e-6 * MM < errors[0] < 1e-2 * MM
    np.testing.assert_allclose(np.divide(errors[1:], errors[:-1]), 4.0, rtol=0.05)


def test_seven_joints_take_the_nearest_solution() -> None:
    rng = np.random.default_rng(11)
    robot, tool = random_chain(rng, [False] * 7), random_tool(rng, 1)
    model = with_base(robot, np.full(7, 1e-6))
    arm = ElasticArm(robot, model.springs, tool)
    cases = LoadCases(rng.uniform(-2, 2, (1, 7)), rng.uniform(-1, 1, (1, 6)) * 500.0)
    for rule in (compensate, compensate_linearly):
        done = rule(arm, model, cases)
        assert done.converged.all()
        assert not done.damped.any()
    exact = compensate(arm, model, cases)
    assert sizes(exact.after).max() < 1e-6 * MM
    # The loaded joints, back from the corrected ones, have moved along no self-motion.
    rest = equilibrium(arm, model.compliance, LoadCases(exact.q, cases.wrench))
    own = model.springs.joint >= 0
    moved = exact.q[0] + rest.displacement[0, own] - cases.q[0]
    null = np.linalg.svd(ec.jacobian(robot, cases.q, tool.tcp)[0])[2][-1]
    assert np.abs(moved).max() > 1e-5
    assert abs(null @ moved) < 1e-2 * np.linalg.norm(moved)


def test_the_weight_of_the_links_is_there_with_and_without() -> None:
    heavy = replace(
        KUKA, masses=tuple(BodyMass(i, 150.0, np.array([0.2, 0, 0]), f"L{i}") for i in (2, 3, 5))
    )
    model = with_base(heavy, TRUTH.compliance)
    arm = ElasticArm(heavy, model.springs, MILLING, np.array([0.0, 0.0, -9.81]))
    cases = LoadCases(PATH.q[::50], PATH.wrench[::50])
    done = compensate(arm, model, cases)
    assert done.converged.all()
    assert sizes(done.after).max() < 1e-6 * MM
    rigid = ec.forward_kinematics(KUKA, cases.q) @ transform(None, MILLING.tcp)
    assert sizes((done.target - rigid)[:, :3, 3]).min() > 0.1 * MM  # it sags to begin with
    idle = LoadCases(cases.q, np.zeros((len(cases), 6)))
    np.testing.assert_allclose(compensate(arm, model, idle).q, cases.q, atol=1e-12)


# What cannot be done is said --------------------------------------------------------------------


def test_the_wrist_singularity_is_no_obstacle_in_joint_space() -> None:
    q = TEST_POSE.copy()
    q[4] = 0.0
    case = LoadCases(q[None], PATH.wrench[:1])
    done = compensate(ARM, TRUTH, case)
    assert done.converged[0]
    assert not done.damped[0]
    assert sizes(residual(ARM, TRUTH, done)).max() < 1e-6 * MM
    linear = compensate_linearly(ARM, TRUTH, case)
    assert linear.damped[0]
    assert [doubt.code for doubt in linear.doubts[0]] == ["hardly-turns"]


def test_a_stretched_arm_loses_a_direction_and_says_which() -> None:
    case = LoadCases(np.zeros((1, 3)), np.array([[800.0, 0.0, -500.0, 0.0, 0.0, 0.0]]))
    k = np.full(3, 1e-6)
    own = ComplianceModel(joint_springs(THREE), k)
    # Springs in the joints: the very configuration is restored, whatever the Jacobian.
    done = compensate(ElasticArm(THREE, own.springs, TIP), own, case)
    assert done.converged[0]
    assert not done.damped[0]
    assert sizes(done.after)[0] < 1e-6 * MM
    # A base that gives way pulls the tool in, and a stretched arm cannot reach out.
    case = LoadCases(case.q, np.array([[-8000.0, 0.0, -500.0, 0.0, 0.0, 0.0]]))
    model = with_base(THREE, k)
    for rule in (compensate, compensate_linearly):
        done = rule(ElasticArm(THREE, model.springs, TIP), model, case)
        assert done.converged[0]
        assert done.damped[0]
        (doubt,) = done.doubts[0]
        assert doubt.code == "hardly-moves"
        np.testing.assert_allclose([doubt.numbers[x] for x in "xyz"], [1, 0, 0], atol=1e-3)
        assert doubt.numbers["remaining"] == sizes(done.after)[0]
        assert done.after[0, 0] < -0.05 * MM
        assert np.abs(done.after[0, 1:]).max() < 0.01 * MM


def test_out_of_reach_the_nearest_place_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """One more step of the search is never worse, for any of several arms at once."""
    model = with_base(THREE, np.full(3, 1e-6))
    q = np.radians([[0.0, 0.0, 0.0], [180.0, 0.0, 0.0], [-60.0, 40.0, 0.3]])
    out = ec.forward_kinematics(THREE, q)[:, :3, 3]
    wrench = np.hstack([-8000.0 * out / sizes(out)[:, None], np.zeros((3, 3))])
    before = np.full(3, np.inf)
    for steps in range(1, 13):
        monkeypatch.setattr("elastocal.compensation.loaded_inverse_kinematics._MOST_STEPS", steps)
        done = compensate(ElasticArm(THREE, model.springs, TIP), model, LoadCases(q, wrench))
        left = sizes(done.after)
        assert (left[done.damped] <= before[done.damped] * (1.0 + 1e-9)).all()
        before = np.where(done.damped, left, np.inf)
    assert done.damped[:2].all()
    np.testing.assert_allclose(done.after[1], done.after[0] * [-1, -1, 1], atol=1e-6 * MM)


def test_a_stretched_arm_bends_where_that_helps() -> None:
    """Newton steps are blind there, damped ones find the bent elbow; which is said."""
    model = with_base(THREE, np.full(3, 1e-6))
    case = LoadCases(np.zeros((1, 3)), np.array([[800.0, 0.0, -500.0, 0.0, 0.0, 0.0]]))
    done = compensate(ElasticArm(THREE, model.springs, TIP), model, case)
    assert done.converged[0]
    assert done.damped[0]
    assert sizes(residual(done.arm, model, done))[0] < 1e-6 * MM
    assert done.doubts[0][0].numbers["remaining"] < 1e-6 * MM


def test_three_joints_correct_the_position_alone() -> None:
    model = with_base(THREE, np.full(3, 1e-6))
    case = LoadCases(
        np.radians([[20.0, 40.0, -70.0]]), np.array([[100.0, 200, -900, 0.0, 0.0, 0.0]])
    )
    done = compensate(ElasticArm(THREE, model.springs, TIP), model, case)
    assert sizes(done.before)[0] > 0.5 * MM
    assert sizes(done.after)[0] < 1e-6 * MM
    assert "position-only" in [note.code for note in done.notes]


def test_an_absurdly_soft_arm_does_not_converge() -> None:
    soft = ComplianceModel(TRUTH.springs, 1e4 * TRUTH.compliance)
    cases = LoadCases(PATH.q[:3], np.array([[0, 0, -20.0, 0, 0, 0], *PATH.wrench[1:3] * 30.0]))
    done = compensate(ARM, soft, cases)
    assert not done.converged[1:].any()
    assert np.isnan(done.q[1:]).all()
    assert np.isnan(done.command[1:]).all()
    assert all(done.doubts[1:])
    left = residual(ARM, TRUTH, done)
    assert np.isnan(left[1:]).all()


def test_a_base_that_is_too_soft_does_not_converge() -> None:
    model = with_base(KUKA, TRUTH.compliance)
    soft = ComplianceModel(model.springs, np.where(model.springs.joint < 0, 1e-2, model.compliance))
    case = LoadCases(PATH.q[:1], 5.0 * PATH.wrench[:1])
    done = compensate(ElasticArm(KUKA, soft.springs, MILLING), soft, case)
    assert not done.converged[0]
    assert done.doubts[0]


def test_corrections_beyond_a_joint_limit_name_the_joint() -> None:
    q = np.repeat(TEST_POSE[None], 2, axis=0)
    q[0, 1] = 0.0  # the upper limit of A2
    wrench = np.array([[0.0, 0.0, -1800.0, 0.0, 0.0, 0.0]] * 2)
    done = compensate(ARM, TRUTH, LoadCases(q, -wrench))
    lifted = compensate(ARM, TRUTH, LoadCases(q, wrench))
    beyond = [d for d in (done, lifted) if d.beyond_limits.any()]
    assert len(beyond) == 1
    assert beyond[0].beyond_limits.tolist() == [[False, True, *[False] * 4], [False] * 6]
    (doubt,), none = beyond[0].doubts
    assert (doubt.code, doubt.about, doubt.unit) == ("beyond-limit", ("A2",), "rad")
    assert doubt.numbers == {"value": beyond[0].q[0, 1], "limit": 0.0}
    assert none == ()


def test_arm_and_model_must_have_the_same_springs() -> None:
    other = ComplianceModel(joint_springs(KUKA, ["A2"]), [1e-6])
    with pytest.raises(InputError, match="the model has compliances of A2"):
        compensate(ARM, other, PATH)


def test_no_load_needs_no_correction() -> None:
    cases = LoadCases(PATH.q[:2], np.zeros((2, 6)))
    done = compensate(ARM, TRUTH, cases)
    np.testing.assert_array_equal(done.q, cases.q)
    assert done.notes == (Doubt("nothing-to-compensate"),)


def test_springs_of_two_models_keep_chain_order() -> None:
    model = with_base(KUKA, TRUTH.compliance, body=3)
    assert model.springs.names == merged(joint_springs(KUKA), base_springs(KUKA, 3)).names
    assert (np.diff(model.springs.body) >= 0).all()


def test_negative_compliances_are_said() -> None:
    """Loaded and unloaded swapped: the fit says so, and so does what is made of it."""
    swapped = ComplianceModel(TRUTH.springs, -TRUTH.compliance)
    done = compensate(ARM, swapped, PATH)
    assert Doubt("wrong-side", TRUTH.names) in done.notes
