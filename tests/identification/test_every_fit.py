"""Every combination of ways to fit, on a tiny arm: what must hold whatever they are.

Scale and units are powers of two, so that an arm twice as long under loads four times as large is
the same computation to the last digit, with compliances an eighth as large.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pytest

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs, subset
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.identification.validation import leave_one_out
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import Joint, Robot, Tool, transform
from tests.arms import random_chain, random_tool
from tests.campaigns import measured

SIGMA = 2.0**-12
TRUTH = np.array([3.0, -0.1, 2.0]) * 2.0**-9
LENGTH, FORCE = 2.0, 4.0
FITS = [
    Fit(model, sigma, loss, nonnegative)  # type: ignore[arg-type]
    for loss, sigma, nonnegative, model in product(
        ("squares", "huber", "bisquare"), ("known", "estimated"), (False, True),
        ("linear", "equilibrium"),
    )
]  # fmt: skip


def label(how: Fit) -> str:
    return f"{how.loss}, {how.sigma}, {how.model}" + ", nonnegative" * how.nonnegative


@dataclass(frozen=True)
class Tiny:
    """A campaign with what is known before."""

    arm: ElasticArm
    data: Measurements
    known: ComplianceModel | None
    prior: ComplianceModel | None

    def fit(self, how: Fit) -> Identification:
        return identify(self.arm, self.data, how, known=self.known, prior=self.prior)


def longer(robot: Robot, tool: Tool) -> tuple[Robot, Tool]:
    """Arm and tool with all lengths times `LENGTH`."""

    def stretched(T: np.ndarray) -> np.ndarray:
        return transform(T[:3, :3], LENGTH * T[:3, 3])

    joints = tuple(Joint(j.name, stretched(j.T_parent_joint), j.axis) for j in robot.joints)
    made = Robot(robot.name, joints, stretched(robot.T_tip_flange))
    return made, replace(
        tool, load_point=LENGTH * tool.load_point, markers=LENGTH * tool.markers,
        tcp=LENGTH * tool.tcp,
    )  # fmt: skip


def campaign(known: bool, prior: bool, *, large: bool = False) -> Tiny:
    """Ten experiments with two markers; the second spring cannot be, one reading is wrong."""
    rng = np.random.default_rng(5)
    robot, tool = random_chain(rng, [False] * 3), random_tool(rng, 2)
    whole = ElasticArm(robot, joint_springs(robot), tool)
    cases = LoadCases(rng.uniform(-2, 2, (10, 3)), rng.normal(size=(10, 6)))
    data = measured(whole, cases, TRUTH, rng=rng, promised=SIGMA, noise=2.0 * SIGMA)
    spoilt = np.array(data.deflection)
    spoilt[7] += 40.0 * SIGMA
    data = replace(data, deflection=spoilt)
    scale = 1.0
    if large:
        robot, tool = longer(robot, tool)
        scale = 1.0 / (LENGTH * FORCE)
        wrench = cases.wrench * FORCE * np.append(np.ones(3), np.full(3, LENGTH))
        data = replace(
            data, tool=tool, cases=LoadCases(cases.q, wrench),
            deflection=LENGTH * data.deflection, covariance=LENGTH**2 * data.covariance,
        )  # fmt: skip
    springs = joint_springs(robot)
    before = np.array([[4.0, 0.5, 1.0], [0.5, 9.0, 0.0], [1.0, 0.0, 4.0]]) * 2.0**-32 * scale**2
    model = ComplianceModel(springs, 1.03125 * scale * TRUTH, before)
    names = ("J2", "J3") if known else robot.joint_names
    first = ComplianceModel(
        subset(springs, ("J1",)), scale * TRUTH[:1], np.full((1, 1), 2.0**-24 * scale**2)
    )
    return Tiny(
        ElasticArm(robot, subset(springs, names), tool), data,
        first if known else None, model if prior else None,
    )  # fmt: skip


@pytest.mark.parametrize("prior", [False, True], ids=["no prior", "prior"])
@pytest.mark.parametrize("known", [False, True], ids=["all", "known"])
@pytest.mark.parametrize("how", FITS, ids=label)
def test_what_holds_for_every_fit(how: Fit, known: bool, prior: bool) -> None:
    """Covariance symmetric and positive; what is held has a limit; degrees of freedom; interval."""
    tiny = campaign(known, prior)
    found = tiny.fit(how)
    p, held = len(found.identified), np.isin(found.identified, found.held)
    covariance = found.model.covariance
    np.testing.assert_allclose(covariance, covariance.T, rtol=1e-12)
    error = found.standard_error
    assert (error > 0.0).all()  # what is held is as uncertain as ever
    np.testing.assert_array_equal(found.compliance[held], 0.0)
    kept = np.flatnonzero(np.sqrt(np.diagonal(covariance)) > 0.0)
    unit = covariance[np.ix_(kept, kept)] / np.outer(*[np.sqrt(np.diagonal(covariance))[kept]] * 2)
    assert np.linalg.eigvalsh(unit)[0] > 1e-6
    assert found.dof == 60 + p * prior - p
    assert not held.any() or how.nonnegative
    assert (found.compliance >= 0.0).all() or not how.nonnegative
    if how.sigma == "known":
        assert found.model.dof == np.inf
    elif prior or known:
        assert 50.0 < found.model.dof <= 60.0
    else:
        assert found.model.dof == found.dof
    middle, half = found.interval.mean(axis=1)[~held], 0.5 * np.diff(found.interval)[:, 0][~held]
    np.testing.assert_allclose(middle, found.compliance[~held], atol=1e-15)
    factor = half / error[~held]
    assert (np.abs(factor - 1.98) < 0.03).all()
    if how.sigma == "known":
        np.testing.assert_allclose(factor, 1.959964, rtol=1e-6)
    assert (found.interval[held, 0] == 0.0).all()
    assert (found.interval[held, 1] >= 1.64 * error[held]).all()
    if how.loss == "squares":
        np.testing.assert_array_equal(found.weight, 1.0)
    else:
        assert found.weight[7] < 0.4
    if known:
        assert found.fitted == ("J1", "J2", "J3")
        assert abs(found.model.of(("J1",))[0] - TRUTH[0]) < 3.0 * 2.0**-12
        # Known before, and measured once more; worse only where readings weigh more than they
        # should, because the noise is not the promised one.
        most = 1.0 if how == Fit(how.model, nonnegative=how.nonnegative) else 4.0
        assert 0.0 < covariance[0, 0] < most * 2.0**-24
    share = found.relative_error * np.abs(found.compliance)
    np.testing.assert_allclose(share[~held], error[~held], rtol=1e-9)
    if not (known or prior or held.any()):
        assert found.influence.leverage.sum() == pytest.approx(p, rel=1e-9)  # weights and all
    assert leave_one_out(found).predicted.all()


@pytest.mark.parametrize("prior", [False, True], ids=["no prior", "prior"])
@pytest.mark.parametrize("known", [False, True], ids=["all", "known"])
@pytest.mark.parametrize("how", FITS, ids=label)
def test_units_and_order_do_not_matter(how: Fit, known: bool, prior: bool) -> None:
    """Twice the length and four times the force; experiments and readings in another order."""
    tiny, large = campaign(known, prior), campaign(known, prior, large=True)
    found, other = tiny.fit(how), large.fit(how)
    scale = LENGTH * FORCE
    np.testing.assert_allclose(scale * other.compliance, found.compliance, rtol=1e-9)
    np.testing.assert_allclose(scale * other.standard_error, found.standard_error, rtol=1e-9)
    np.testing.assert_allclose(other.scale, found.scale, rtol=1e-9)
    np.testing.assert_allclose(other.chi_square, found.chi_square, rtol=1e-9)
    np.testing.assert_allclose(other.weight, found.weight, atol=1e-9)
    np.testing.assert_allclose(other.left_out, LENGTH * found.left_out, rtol=1e-6, atol=1e-12)
    assert other.held == found.held
    order = np.random.default_rng(6).permutation(10)
    readings = np.argsort(order)[tiny.data.case]
    mixed = np.random.default_rng(7).permutation(len(readings))
    shuffled = replace(
        tiny.data,
        cases=LoadCases(tiny.data.cases.q[order], tiny.data.cases.wrench[order]),
        names=tuple(tiny.data.names[i] for i in order),
        case=readings[mixed], marker=tiny.data.marker[mixed],
        deflection=tiny.data.deflection[mixed], covariance=tiny.data.covariance[mixed],
    )  # fmt: skip
    again = replace(tiny, data=shuffled).fit(how)
    np.testing.assert_allclose(again.compliance, found.compliance, rtol=1e-8)
    np.testing.assert_allclose(again.model.covariance, found.model.covariance, rtol=1e-6)
    np.testing.assert_allclose(again.residual, found.residual[mixed], atol=1e-12)
    np.testing.assert_allclose(again.influence.cook, found.influence.cook[order], rtol=1e-5)
