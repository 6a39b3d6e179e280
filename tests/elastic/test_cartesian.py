"""Cartesian compliance and stiffness: against deflections, the paper's equation, and chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.cartesian import Interval, cartesian_compliance, error_left
from elastocal.elastic.regressor import deflection
from elastocal.elastic.springs import VirtualJoints, merged
from tests.arms import random_chain, random_tool

TRUTH = np.array([0.6, 0.3, 0.4, 3.0, 3.6, 4.0]) * 1e-6
POSE = np.radians([[0.0, -56.9, 89.3, 45.1, 76.0, 57.2], [20.0, -90.0, 60.0, 10.0, -40.0, 5.0]])


def milling(names: tuple[str, ...] | None = None) -> ElasticArm:
    robot = ec.load_robot("kuka-kr270")
    tool = ec.Tool("milling", np.array([0.986, 0, 0]), np.array([[0.986, 0, 0]]), ("TCP",))
    return ElasticArm(robot, ec.joint_springs(robot, names), replace(tool, tcp=tool.load_point))


def known(arm: ElasticArm, compliance: np.ndarray, error: float = 0.01) -> ec.ComplianceModel:
    """A model with correlated errors of about a share of the compliances."""
    p = len(compliance)
    root = np.random.default_rng(1).normal(size=(p, p)) / np.sqrt(p) + np.eye(p)
    scaled = error * np.diag(compliance) @ root
    return ec.ComplianceModel(arm.springs, compliance, scaled @ scaled.T)


def test_stiffness_is_that_of_the_paper() -> None:
    """(1): K_C = J⁻ᵀ K_θ J⁻¹, with the Jacobian of the robot."""
    arm = milling()
    for one, q in zip(cartesian_compliance(arm, known(arm, TRUTH), POSE), POSE, strict=True):
        J = ec.jacobian(arm.robot, q[None], arm.tool.tcp)[0]
        expected = np.linalg.inv(J).T @ np.diag(1.0 / TRUTH) @ np.linalg.inv(J)
        assert one.stiffness is not None
        np.testing.assert_allclose(one.stiffness, expected, rtol=1e-9, atol=1e-9 * expected.max())
        again = ec.cartesian_stiffness(arm.robot, TRUTH, q[None], arm.tool.tcp)[0]
        np.testing.assert_allclose(one.stiffness, again, rtol=1e-9, atol=1e-9 * again.max())
        assert one.missing == 0
        assert one.rigid == ()


@pytest.mark.parametrize("slides", [[False] * 6, [True, False, False, True, False, False]])
def test_compliance_is_the_deflection_of_unit_wrenches(slides: list[bool]) -> None:
    """Springs in joints, link and base; the wrench at the TCP, which is no marker."""
    rng = np.random.default_rng(2)
    robot = random_chain(rng, slides)
    extra = VirtualJoints(
        ("base", "link"), np.array([0, 3]), np.eye(3)[:2], rng.normal(size=(2, 3)),
        np.array([True, False]),
    )  # fmt: skip
    springs = merged(ec.joint_springs(robot), extra)
    tool = replace(random_tool(rng, 2), tcp=rng.normal(size=3))
    compliance, q = rng.uniform(1e-7, 1e-6, 8), rng.normal(size=(1, 6))
    arm = ElasticArm(robot, springs, tool)
    (one,) = cartesian_compliance(arm, ec.ComplianceModel(springs, compliance), q)
    there = ec.Tool("there", tool.tcp, tool.tcp[None], ("TCP",))
    pushed = ec.LoadCases(np.tile(q, (6, 1)), np.eye(6))
    moved = deflection(replace(arm, tool=there), compliance, pushed)
    np.testing.assert_allclose(one.matrix.T, moved, rtol=1e-9, atol=1e-20)


def test_directions_give_way_as_the_matrix_says() -> None:
    arm = milling()
    one, _ = cartesian_compliance(arm, known(arm, TRUTH), POSE)
    block = one.matrix[:3, :3]
    for i, line in enumerate(one.axes):
        assert line.compliance.value == pytest.approx(block[i, i], rel=1e-12)
        assert line.stiffness.value == pytest.approx(1.0 / block[i, i], rel=1e-12)
        assert line.stiffness.low == pytest.approx(1.0 / line.compliance.high, rel=1e-12)
    softest, stiffest = one.principal
    values = np.linalg.eigvalsh(block)
    assert softest.compliance.value == pytest.approx(values[2], rel=1e-9)
    assert stiffest.compliance.value == pytest.approx(values[0], rel=1e-9)
    moved = block @ softest.direction
    np.testing.assert_allclose(moved, values[2] * softest.direction, rtol=1e-8)


def test_a_joint_without_spring_makes_the_stiffness_infinite_and_is_named() -> None:
    names = ("A2", "A3", "A4", "A5", "A6")
    arm = milling(names)
    one, _ = cartesian_compliance(arm, known(arm, TRUTH[1:]), POSE)
    assert one.missing == 1
    assert one.stiffness is None
    assert one.held == ()
    assert one.rigid == ("A1",)
    whole, _ = cartesian_compliance(milling(), known(milling(), TRUTH), POSE)
    assert one.axes[1].compliance.value < 0.6 * whole.axes[1].compliance.value


def test_what_cannot_move_has_no_compliance_and_infinite_stiffness() -> None:
    """One joint about z: its tool moves across the arm and no other way."""
    robot = ec.load_robot("three-link")
    arm = ElasticArm(robot, ec.joint_springs(robot, ["J1"]), robot.tools["tip"])
    (one,) = cartesian_compliance(arm, known(arm, np.array([2e-6])), np.zeros((1, 3)))
    x, y, z = one.axes
    reach = 1.25 + 1.10
    assert y.compliance.value == pytest.approx(2e-6 * reach**2, rel=1e-12)
    for line in (x, z, one.principal[1]):
        assert line.compliance == Interval(0.0, 0.0, 0.0)
        assert line.stiffness == Interval(np.inf, np.inf, np.inf)
    assert one.missing == 5


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """3000 estimates drawn about the truth; errors of 3 %, as after a short campaign."""
    arm, rng = milling(), np.random.default_rng(3)
    truth, _ = cartesian_compliance(arm, known(arm, TRUTH), POSE)
    assert truth.stiffness is not None
    covariance = known(arm, TRUTH, 0.03).covariance
    drawn = rng.multivariate_normal(1e6 * TRUTH, 1e12 * covariance, 3000) / 1e6
    inside = np.zeros(3 + 3 + 2 + 6)
    for estimate in drawn:
        model = ec.ComplianceModel(arm.springs, estimate, covariance)
        one = cartesian_compliance(arm, model, POSE[:1])[0]
        pairs = [
            *(
                (a.compliance, b.compliance.value)
                for a, b in zip(one.axes, truth.axes, strict=True)
            ),
            *((a.stiffness, b.stiffness.value) for a, b in zip(one.axes, truth.axes, strict=True)),
            *(
                (a.compliance, b.compliance.value)
                for a, b in zip(one.principal, truth.principal, strict=True)
            ),
            *zip(one.held, np.diagonal(truth.stiffness), strict=True),
        ]
        inside += [low <= value <= high for (_, low, high), value in pairs]
    share = inside / len(drawn)
    # Exact for compliances and their inverses, to first order for directions and K_C.
    assert np.abs(share[:6] - 0.95).max() < 4.0 * np.sqrt(0.95 * 0.05 / 3000)
    assert np.abs(share[6:] - 0.95).max() < 0.02
    # Control: half as wide, 67 %.
    narrow = cartesian_compliance(arm, known(arm, TRUTH, 0.03), POSE[:1], 1.959964 / 2.0)[0]
    wide = cartesian_compliance(arm, known(arm, TRUTH, 0.03), POSE[:1])[0]
    for a, b in zip(narrow.held, wide.held, strict=True):
        assert 2.0 * (a.high - a.low) == pytest.approx(b.high - b.low, rel=1e-9)


def test_the_error_left_is_that_of_the_plan() -> None:
    """The covariance of a plan, as that of a model, leaves its ρ0 at the test pose."""
    from tests.kr270 import kr270_study, published_cases

    study = kr270_study()
    worth = ec.assess(study, published_cases(3), np.full(3, 4))
    (pose,) = study.test_poses
    assert pose.case is not None
    assert pose.tool is not None
    model = ec.ComplianceModel(study.springs, TRUTH[1:], worth.covariance)
    arm = replace(study.arm, tool=pose.tool)
    assert error_left(arm, model, pose.case)[0] == pytest.approx(worth.rho0, rel=1e-9)
