"""Fits with one degree of freedom or none, unseen joints, and noise that is not as promised."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import joint_springs
from elastocal.errors import Doubt, IdentifiabilityError, InputError
from elastocal.fitting.robust import EFFICIENCY, LOSSES, inflation, robust_scale
from elastocal.identification.doubts import doubts
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.identification.validation import leave_one_out, validate
from elastocal.measuring.measurements import chosen
from elastocal.robot.chain import Tool
from elastocal.robot.sources import three_link
from tests.campaigns import SIGMA, TRUTH, arm, hung, measured

LINEAR = Fit(model="linear")
ROBOT = three_link()
THREE = ElasticArm(ROBOT, joint_springs(ROBOT), ROBOT.tools["tip"])
SOFT = np.array([1e-6, 2e-6, 3e-6])


def far(found: Identification) -> set[str]:
    """Readings that are said to be far out."""
    return {name for doubt in doubts(found) if doubt.code == "outlying" for name in doubt.about}


def test_one_degree_of_freedom() -> None:
    """Two readings, five unknowns: one left, so the scale is the root of χ² itself."""
    data = measured(arm(), hung(2), rng=np.random.default_rng(2), noise=3 * SIGMA, linear=True)
    found = identify(arm(), data, LINEAR)
    bent = arm()
    rows = regressor(bent, data.cases).reshape(-1, 5)
    rest = np.linalg.lstsq(rows * 1e-6, data.deflection.reshape(-1), rcond=None)[1][0]
    assert found.dof == 1
    assert found.chi_square == pytest.approx(rest / SIGMA**2, rel=1e-6)
    assert found.scale == pytest.approx(np.sqrt(rest) / SIGMA, rel=1e-6)
    estimated = identify(arm(), data, Fit("linear", "estimated"))
    np.testing.assert_allclose(estimated.standard_error, found.scale * found.standard_error)
    # Student's t of one degree of freedom is Cauchy's: its quantile is a tangent.
    half = np.tan(np.pi * 0.475) * estimated.standard_error
    np.testing.assert_allclose(np.diff(estimated.interval)[:, 0], 2.0 * half)


@pytest.mark.parametrize("sigma", ["known", "estimated"])
def test_a_robust_fit_with_one_degree_of_freedom(sigma: str) -> None:
    """Its variance is the formula with one freedom, and never below that of a sound fit."""
    data = measured(arm(), hung(2), rng=np.random.default_rng(2), noise=3 * SIGMA, linear=True)
    found = identify(arm(), data, Fit("linear", sigma, "huber"))  # type: ignore[arg-type]
    size = np.linalg.norm(found.residual, axis=1) / SIGMA
    scale = np.sqrt(np.median(size**2) / 2.365974 / (1.0 / 6.0))
    assert robust_scale(size, 1) == pytest.approx(scale)
    assert found.scale == pytest.approx(scale)
    used = 1.0 if sigma == "known" else scale
    variance = inflation(LOSSES["huber"], size, used, 1)
    expected = max(variance, 1.0 / EFFICIENCY) if sigma == "known" else variance
    assert found.variance == pytest.approx(expected)
    assert found.dof == 1


def test_inflation_by_hand() -> None:
    """Sizes 1 and 4 over a noise of 2, Huber at 1.62799: one weight 1, one 0.814."""
    weight = 1.62799 / 2.0
    spread = 2.0**2 * (0.5**2 + 1.62799**2) / 3.0
    bend = 0.5 * (1.0 + weight - weight / 3.0)
    found = inflation(LOSSES["huber"], np.array([1.0, 4.0]), 2.0, 3)
    assert found == pytest.approx(spread / bend**2)


def test_without_freedom_sigma_cannot_be_estimated() -> None:
    names = ("A2", "A3", "A5")
    data = measured(arm(names), hung(1), SOFT, linear=True)
    known = identify(arm(names), data, LINEAR)
    assert known.dof == 0
    assert np.isnan(known.scale)
    np.testing.assert_allclose(known.compliance, SOFT, rtol=1e-9)
    with pytest.raises(IdentifiabilityError) as error:
        identify(arm(names), data, Fit("linear", "estimated"))
    assert error.value.doubts == (Doubt("no-freedom", (), (), {"readings": 1}),)


@pytest.mark.parametrize("nonnegative", [False, True])
@pytest.mark.parametrize("first", [1e-6, -1e-6])
def test_confounded_joints_are_named_with_bounds_too(first: float, nonnegative: bool) -> None:
    """A straight arm, always the same: J2 and J3 turn the tip alike. J1 may be held."""
    wrench = np.zeros((4, 6))
    wrench[:, :3] = [[30, 20, -100], [30, -30, -100], [30, 40, -100], [30, 10, -100]]
    cases = LoadCases(np.tile([0.3, 0.4, 0.0], (4, 1)), wrench)
    data = measured(THREE, cases, np.array([first, 1e-6, 2e-6]), linear=True)
    with pytest.raises(IdentifiabilityError, match="J2 and J3: the readings see only a comb"):
        identify(THREE, data, replace(LINEAR, nonnegative=nonnegative))
    hanging = LoadCases(np.random.default_rng(0).uniform(-1, 1, (6, 3)), np.tile(wrench[0], (6, 1)))
    hanging = LoadCases(hanging.q, hanging.wrench * [0, 0, 1, 0, 0, 0])
    data = measured(THREE, hanging, SOFT, linear=True)
    with pytest.raises(IdentifiabilityError, match="J1: no reading is moved by this joint"):
        identify(THREE, data, replace(LINEAR, nonnegative=nonnegative))


def test_three_joints_seen_in_a_plane_are_two_combinations() -> None:
    """A4 at zero: A2, A3 and A5 move the tool in one plane, so two numbers for three."""
    names = ("A2", "A3", "A5")
    q = np.tile(np.radians([20.0, -60.0, 80.0, 0.0, 40.0, 0.0]), (4, 1))
    cases = LoadCases(q, np.tile([0.0, 0.0, -2500.0, 0, 0, 0], (4, 1)))
    with pytest.raises(IdentifiabilityError, match=r"A2 and A3 and A5: .* only 2 combinations"):
        identify(arm(names), measured(arm(names), cases, SOFT, linear=True), LINEAR)


def test_a_reading_is_far_out_by_the_noise_that_holds() -> None:
    """Noise of 3 promised ones; a reading off by 12 is 4 found ones: far by σ, not by the fit."""
    data = measured(arm(), hung(24), rng=np.random.default_rng(4), noise=3 * SIGMA, linear=True)
    exact = measured(arm(), hung(24), linear=True).deflection
    spoilt = np.array(data.deflection)
    spoilt[10] = exact[10] + [0.0, 12 * SIGMA, 0.0]
    data = replace(data, deflection=spoilt)
    known, estimated = (identify(arm(), data, Fit("linear", s)) for s in ("known", "estimated"))  # type: ignore[arg-type]
    assert estimated.scale == pytest.approx(3.0, rel=0.2)
    assert "E11" in far(known)
    assert "E11" not in far(estimated)
    spoilt[10, 1] += 12 * SIGMA
    worse = identify(arm(), replace(data, deflection=spoilt), Fit("linear", "estimated"))
    assert "E11" in far(worse)


def test_robust_weights_go_by_the_noise_that_holds() -> None:
    """Noise of 3 promised ones: far beyond the threshold if σ is known, sound if it is found."""
    data = measured(arm(), hung(60), rng=np.random.default_rng(5), noise=3 * SIGMA, linear=True)
    known = identify(arm(), data, Fit("linear", "known", "huber"))
    estimated = identify(arm(), data, Fit("linear", "estimated", "huber"))
    assert np.mean(known.weight < 1.0) > 0.85
    assert 0.15 < np.mean(estimated.weight < 1.0) < 0.7
    size = np.linalg.norm(known.residual, axis=1) / SIGMA
    np.testing.assert_allclose(known.weight, np.minimum(1.0, 1.62799 / size), rtol=1e-4)
    found = np.linalg.norm(estimated.residual, axis=1) / SIGMA / estimated.scale
    np.testing.assert_allclose(estimated.weight, np.minimum(1.0, 1.62799 / found), rtol=1e-4)


def test_what_one_experiment_carries_is_not_predicted_for_it_alone() -> None:
    """J1 is pushed in the first experiment only: all its readings are left out, no others."""
    rng = np.random.default_rng(6)
    wrench = np.tile([0.0, 0, -100, 0, 0, 0], (5, 1))
    wrench[0, :2] = 60.0, 80.0
    cases = LoadCases(rng.uniform(-1, 1, (5, 3)), wrench)
    tool = Tool("two", np.zeros(3), np.array([[0.0, 0, 0], [0, 0.1, 0.2]]), ("a", "b"))
    pushed = replace(THREE, tool=tool)
    found = identify(pushed, measured(pushed, cases, SOFT, rng=rng, promised=1e-7, noise=1e-7))
    judged = leave_one_out(found)
    assert judged.predicted.tolist() == [False, False] + [True] * 8
    assert judged.coordinates == 24


def test_readings_are_judged_with_the_tool_they_were_made_with() -> None:
    """The arm's own tool may be another one, as may the springs of the model."""
    truth = ComplianceModel(THREE.springs, SOFT)
    wrench = np.tile([30.0, 40, -100, 0, 0, 0], (4, 1))
    cases = LoadCases(np.random.default_rng(7).uniform(-1, 1, (4, 3)), wrench)
    tool = Tool(
        "other", np.array([0.1, 0.2, 0.3]), np.array([[0.3, 0, 0], [0, 0.1, 0.2]]), ("a", "b")
    )
    data = measured(replace(THREE, tool=tool), cases, SOFT)
    found = validate(arm_of_one(), truth, data)
    assert np.abs(found.after).max() < 1e-15
    assert np.abs(found.before).max() > 1e-5


def arm_of_one() -> ElasticArm:
    return ElasticArm(ROBOT, joint_springs(ROBOT, ["J2"]), ROBOT.tools["tip"])


def test_a_common_prior_counts_as_readings() -> None:
    """A prior of all five springs leaves five more degrees of freedom."""
    prior = ComplianceModel(arm().springs, TRUTH, np.diag((0.1 * TRUTH) ** 2))
    data = measured(arm(), hung(2), linear=True)
    assert identify(arm(), data, LINEAR, prior=prior).dof == 6


@pytest.mark.parametrize("times", [1e3, 1e6, 1e9, 1e15, -1e6, -1e9])
@pytest.mark.parametrize("loss", ["squares", "huber"])
def test_readings_in_another_unit_do_not_come_to_rest(times: float, loss: str) -> None:
    """Millimetres or micrometres taken for metres: a sentence, for the linear model an answer."""
    data = measured(arm(), hung(12), linear=True)
    far_off = replace(data, deflection=times * data.deflection)
    with pytest.raises(InputError, match="the fit to test does not come to rest"):
        identify(arm(), far_off, Fit(loss=loss))
    np.testing.assert_allclose(identify(arm(), far_off, LINEAR).compliance, times * TRUTH)


def test_a_fit_needs_a_confidence_that_says_something() -> None:
    for confidence in (0.4, 1.0, 1.5):
        with pytest.raises(InputError, match=f"from 0.5 to below 1, found {confidence:g}"):
            Fit(confidence=confidence)
    assert Fit(confidence=0.5).confidence == 0.5


@pytest.mark.parametrize("repeats", [1, 3])
def test_leaving_a_configuration_out_is_refitting(repeats: int) -> None:
    """All its repeats go together; with none it is the experiment, in the order of `distinct`."""
    cases = hung(5, repeats=repeats)
    data = measured(arm(), cases, rng=np.random.default_rng(6), noise=SIGMA, linear=True)
    found = identify(arm(), data, LINEAR)
    left = found.configuration_influence
    assert left.leverage.shape == (5,)
    assert left.leverage.sum() == pytest.approx(5.0)
    for g in range(5):
        rest = identify(arm(), chosen(data, cases.distinct != g), LINEAR)
        np.testing.assert_allclose(left.shift[g], rest.compliance - found.compliance, rtol=1e-6)
