"""Identification: what was put in comes out, and every diagnostic against a refit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.errors import Doubt, IdentifiabilityError, InputError
from elastocal.identification.doubts import doubts
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.result import Identification
from elastocal.identification.validation import leave_one_out, validate
from elastocal.measuring.measurements import Measurements, chosen
from tests.campaigns import MARKERS, NAMES, SIGMA, TRUTH, arm, hung, measured, sideways

LINEAR = Fit(model="linear")


def test_linear_data_give_the_compliances_back() -> None:
    found = identify(arm(), measured(arm(), hung(12), linear=True), LINEAR)
    np.testing.assert_allclose(found.compliance, TRUTH, rtol=1e-10)
    np.testing.assert_array_equal(found.linear, found.compliance)


def test_nonlinear_data_give_the_compliances_back() -> None:
    found = identify(arm(), measured(arm(), hung(12)))
    np.testing.assert_allclose(found.compliance, TRUTH, rtol=1e-10)
    assert np.abs(found.residual).max() < 1e-12


def test_several_markers_all_joints_and_any_force() -> None:
    names = ("A1", *NAMES)
    truth = np.append(0.6e-6, TRUTH)
    bent = arm(names, MARKERS)
    found = identify(bent, measured(bent, sideways(10), truth))
    np.testing.assert_allclose(found.compliance, truth, rtol=1e-10)


def test_the_error_of_the_linear_model_falls_with_the_load() -> None:
    """Half the load, half the relative error: the model is wrong at second order."""
    errors = []
    for force in (2500.0, 1250.0, 625.0):
        data = measured(arm(), hung(12, force=force))
        errors.append(identify(arm(), data, LINEAR).compliance / TRUTH - 1.0)
    np.testing.assert_allclose(errors[0], 2.0 * errors[1], rtol=0.1, atol=2e-4)
    np.testing.assert_allclose(errors[1], 2.0 * errors[2], rtol=0.1, atol=1e-4)
    assert np.abs(errors[0]).max() > 1e-3


def test_weight_of_the_links_and_springs_of_the_base() -> None:
    """Springs that are in no joint, an arm that sags: the same iteration."""
    robot = arm().robot
    from elastocal.robot.shapes import BodyMass

    masses = tuple(BodyMass(b, 150.0, np.array([0.1, 0.05, 0.2])) for b in range(1, 7))
    robot = replace(robot, masses=masses)
    tilt = VirtualJoints(
        ("tilt x", "tilt y"),
        np.array([0, 0]),
        np.eye(3)[:2],
        np.zeros((2, 3)),
        np.array([False, False]),
    )
    springs = merged(joint_springs(robot, NAMES), tilt)
    assert springs.names[:2] == ("tilt x", "tilt y")
    bent = ElasticArm(robot, springs, MARKERS, np.array([0.0, 0.0, -9.81]))
    truth = np.append([0.05e-6, 0.04e-6], TRUTH)
    found = identify(bent, measured(bent, hung(12), truth))
    np.testing.assert_allclose(found.compliance, truth, rtol=1e-9)
    ignored = identify(replace(bent, gravity=np.zeros(3)), found.measurements)
    assert np.abs(ignored.compliance / truth - 1.0).max() > 1e-4  # gravity matters


def test_covariance_is_that_of_equation_13() -> None:
    data = measured(arm(), hung(12), linear=True)
    found = identify(arm(), data, LINEAR)
    from elastocal.elastic.regressor import regressor

    bent = arm()
    rows = regressor(bent, data.cases).reshape(-1, 5)
    np.testing.assert_allclose(
        found.model.covariance, SIGMA**2 * np.linalg.inv(rows.T @ rows), rtol=1e-8
    )


def test_a_common_factor_of_the_noise_changes_nothing_but_the_known_sigma() -> None:
    rng = np.random.default_rng(3)
    data = measured(arm(), hung(12), rng=rng)
    louder = replace(data, covariance=9.0 * data.covariance)
    known, wide = identify(arm(), data), identify(arm(), louder)
    np.testing.assert_allclose(wide.compliance, known.compliance, rtol=1e-9)
    np.testing.assert_allclose(wide.standard_error, 3.0 * known.standard_error, rtol=1e-6)
    assert wide.scale == pytest.approx(known.scale / 3.0)
    one, two = (identify(arm(), d, Fit(sigma="estimated")) for d in (data, louder))
    np.testing.assert_allclose(two.standard_error, one.standard_error, rtol=1e-6)
    np.testing.assert_allclose(two.interval, one.interval, rtol=1e-6)


def test_correlated_noise_is_whitened() -> None:
    """A rotated, unequal covariance against the fit in coordinates where it is the identity."""
    rng = np.random.default_rng(4)
    data = measured(arm(), hung(12), rng=rng, linear=True)
    root = rng.normal(size=(3, 3)) * 1e-5
    found = identify(arm(), replace(data, covariance=np.tile(root @ root.T, (12, 1, 1))), LINEAR)
    from elastocal.elastic.regressor import regressor

    bent = arm()
    undo = np.linalg.inv(root)
    rows = undo @ regressor(bent, data.cases)
    values = data.deflection @ undo.T
    expected = np.linalg.lstsq(rows.reshape(-1, 5) * 1e-6, values.reshape(-1), rcond=None)[0]
    np.testing.assert_allclose(found.compliance, 1e-6 * expected, rtol=1e-8)


def test_a_prior_is_a_campaign_before() -> None:
    """Fitting the second half with the first as prior is fitting both."""
    rng = np.random.default_rng(6)
    data = measured(arm(), hung(16), rng=rng, linear=True)
    half = np.arange(16) < 8
    first = identify(arm(), chosen(data, half), LINEAR)
    both = identify(arm(), chosen(data, ~half), LINEAR, prior=first.model)
    once = identify(arm(), data, LINEAR)
    np.testing.assert_allclose(both.compliance, once.compliance, rtol=1e-9)
    np.testing.assert_allclose(both.model.covariance, once.model.covariance, rtol=1e-7)


def test_leaving_out_is_refitting() -> None:
    """Shift, Cook's distance, left-out residuals and errors, in closed form against refits."""
    rng = np.random.default_rng(7)
    bent = arm(tool=MARKERS)
    data = measured(bent, hung(8), rng=rng, linear=True)
    found = identify(bent, data, LINEAR)
    information = np.linalg.inv(found.model.covariance)
    for i in (0, 3, 7):
        keep = np.arange(8) != i
        without = identify(bent, chosen(data, keep), LINEAR)
        shift = without.compliance - found.compliance
        np.testing.assert_allclose(found.influence.shift[i], shift, rtol=1e-6, atol=1e-16)
        assert found.influence.cook[i] == pytest.approx(shift @ information @ shift / 5, rel=1e-6)
        ratio = without.standard_error / found.standard_error
        np.testing.assert_allclose(found.influence.error_ratio[i], ratio, rtol=1e-7)
        own = data.case == i
        predicted = validate(bent, without.model, chosen(data, ~keep))
        linear = data.deflection[own] - found.left_out[own]
        np.testing.assert_allclose(
            linear, data.deflection[own] - predicted.after, atol=6e-5
        )  # one by the linear model, one by the equilibrium
    assert found.influence.leverage.sum() == pytest.approx(5.0)


def test_leave_one_out_predicts_as_well_as_it_says() -> None:
    rng = np.random.default_rng(8)
    inside = []
    for _ in range(60):
        found = identify(arm(), measured(arm(), hung(14), rng=rng))
        inside.append(leave_one_out(found).inside)
    assert 0.935 < np.mean(inside) < 0.965


def without(found: Identification, i: int) -> Array:
    """Covariance of the readings of experiment i by a refit without it."""
    data = found.measurements
    keep = np.arange(len(data.cases)) != i
    again = identify(found.arm, chosen(data, keep), found.how)
    one = chosen(data, ~keep)
    rows = regressor(found.arm, one.cases)
    rows = rows.reshape(-1, 3, rows.shape[-1])
    return rows @ again.model.covariance @ rows.transpose(0, 2, 1) + one.covariance


def test_left_out_residuals_have_the_covariance_of_a_refit() -> None:
    bent = arm(tool=MARKERS)
    found = identify(bent, measured(bent, hung(4), rng=np.random.default_rng(20)), LINEAR)
    expected = left_out_covariance(found).reshape(4, 3, 3, 3)
    for i in range(4):
        np.testing.assert_allclose(expected[i], without(found, i), rtol=1e-6, atol=1e-16)
    some = np.array([False, True, False, True])
    np.testing.assert_allclose(left_out_covariance(found, some), expected[some].reshape(-1, 3, 3))


def test_left_out_residuals_know_what_is_taken_as_known() -> None:
    """Cross terms of the known joints: against a simulation over them and the noise."""
    rng = np.random.default_rng(21)
    cases = sideways(4)
    error = np.array([2e-8])
    residuals = []
    first = joint_springs(arm().robot, ("A1",))
    for _ in range(600):
        known = ComplianceModel(
            first, np.array([0.62e-6]) + error * rng.normal(size=1), np.diag(error**2)
        )
        data = measured(arm(("A1", *NAMES)), cases, np.append(0.62e-6, TRUTH), rng=rng, linear=True)
        found = identify(arm(), data, LINEAR, known=known)
        residuals.append(found.left_out)
    expected = left_out_covariance(found)
    scatter = np.einsum("kri,krj->rij", residuals, residuals) / len(residuals)
    size = np.trace(expected, axis1=1, axis2=2)
    np.testing.assert_allclose(np.trace(scatter, axis1=1, axis2=2), size, rtol=0.3)


def test_few_sound_readings_are_not_called_outlying() -> None:
    """What stands alone is far out of what the others say, and they know it."""
    rng = np.random.default_rng(22)
    codes = [
        weak(measured(arm(), hung(3, seed=5), rng=rng, linear=True), LINEAR) for _ in range(50)
    ]
    assert sum("outlying" in found for found in codes) <= 1
    p_values = [
        leave_one_out(identify(arm(), measured(arm(), hung(3, seed=5), rng=rng))).p_value
        for _ in range(200)
    ]
    assert abs(np.mean(p_values) - 0.5) < 0.082  # four standard errors


def test_experiments_that_carry_a_compliance_do_not_count_as_predicted() -> None:
    found = identify(arm(), measured(arm(), hung(2), rng=np.random.default_rng(23)))
    judged = leave_one_out(found)
    assert not judged.predicted.any()
    assert judged.coordinates == 0
    assert np.isnan(judged.inside)
    assert (judged.chi_square, judged.dof) == (found.chi_square, 1)


def test_readings_kept_aside_share_the_error_of_the_model() -> None:
    """Two experiments make the model, forty judge it: its error is in all of them."""
    rng = np.random.default_rng(24)
    p_values = []
    for _ in range(200):
        found = identify(arm(), measured(arm(), hung(2), rng=rng))
        p_values.append(
            validate(arm(), found.model, measured(arm(), hung(40, seed=77), rng=rng)).p_value
        )
    assert abs(np.mean(p_values) - 0.5) < 0.082
    assert np.min(p_values) > 1e-4


def test_validation_on_experiments_kept_aside() -> None:
    rng = np.random.default_rng(9)
    inside, p_values = [], []
    for _ in range(60):
        found = identify(arm(), measured(arm(), hung(12), rng=rng))
        judged = validate(arm(), found.model, measured(arm(), hung(10, seed=77), rng=rng))
        inside.append(judged.inside)
        p_values.append(judged.p_value)
    assert 0.935 < np.mean(inside) < 0.965
    wrong = ComplianceModel(arm().springs, 1.05 * TRUTH)
    judged = validate(arm(), wrong, measured(arm(), hung(10, seed=77), rng=rng))
    assert judged.p_value < 1e-6  # the negative control
    assert judged.inside < 0.9


def test_robust_losses_survive_outliers() -> None:
    rng = np.random.default_rng(10)
    data = measured(arm(), hung(60), rng=rng)
    spoilt = np.array(data.deflection)
    spoilt[[3, 20, 41]] += [[4e-3, 0, 0], [0, -6e-3, 1e-3], [2e-3, 2e-3, 2e-3]]
    data = replace(data, deflection=spoilt)
    plain = identify(arm(), data)
    assert np.abs((plain.compliance - TRUTH) / plain.standard_error).max() > 5.0
    assert "E21" in named(plain, "outlying")
    for loss in ("huber", "bisquare"):
        found = identify(arm(), data, Fit(loss=loss))
        assert np.abs((found.compliance - TRUTH) / found.standard_error).max() < 4.0
        assert set(np.flatnonzero(found.weight < 0.2)) == {3, 20, 41}
        assert {"E4", "E21", "E42"} <= set(named(found, "counts-less"))
        (doubt,) = [d for d in doubts(found) if d.code == "counts-less"]
        assert doubt.numbers["readings"] == len(found.measurements)
        assert doubt.numbers["unused"] == np.sum(found.weight < 0.01)


def test_intervals_of_robust_fits_cover() -> None:
    rng = np.random.default_rng(11)
    for loss in ("huber", "bisquare"):
        hits = []
        for _ in range(150):
            data = measured(arm(), hung(40), rng=rng, linear=True)
            found = identify(arm(), data, Fit("linear", "estimated", loss))
            low, high = found.interval.T
            hits.append((low < TRUTH) & (high > TRUTH))
        assert 0.91 < np.mean(hits) < 0.98


def test_robust_intervals_of_few_readings_cover_too() -> None:
    """A lucky fit of one degree of freedom does not make a known noise smaller."""
    rng = np.random.default_rng(25)
    hits = []
    for _ in range(200):
        data = measured(arm(), hung(2), rng=rng, linear=True)
        low, high = identify(arm(), data, Fit("linear", loss="huber")).interval.T
        hits.append((low < TRUTH) & (high > TRUTH))
    assert np.mean(hits) > 0.92


def test_a_fit_that_cannot_tell_outliers_says_so() -> None:
    said = []
    for seed in range(200):
        data = measured(arm(), hung(3), rng=np.random.default_rng(seed))
        try:
            identify(arm(), data, Fit(sigma="estimated", loss="bisquare"))
        except InputError as error:
            said.append(str(error))
    assert said
    assert all("readings may be too few" in text for text in said)


def test_compliances_held_at_zero_are_named() -> None:
    """Data of an impossible spring: without the bound it comes out as it went in."""
    data = measured(arm(), hung(12), TRUTH * [1, 1, 1, 1, -0.1], linear=True)
    free = identify(arm(), data, LINEAR)
    assert free.compliance[4] == pytest.approx(-0.1 * TRUTH[4])
    assert named(free, "negative") == ("A6",)
    found = identify(arm(), data, replace(LINEAR, nonnegative=True))
    assert (found.compliance >= 0.0).all()
    assert found.held == ("A6",)
    # Held or not, it is as uncertain: its limit is that of the estimate without the bound.
    assert found.standard_error[4] == pytest.approx(free.standard_error[4], rel=1e-6)
    assert found.unbounded[4] == pytest.approx(free.compliance[4], rel=1e-6)
    assert found.interval[4, 0] == 0.0
    assert found.interval[4, 1] == pytest.approx(1.644854 * free.standard_error[4], rel=1e-5)
    assert named(found, "held-at-zero") == ("A6",)


def test_unseen_joints_are_named() -> None:
    assert left_open(arm(("A1", *NAMES)), measured(arm(), hung(12))) == Doubt("not-seen", ("A1",))
    one = hung(1)
    same = LoadCases(np.repeat(one.q, 12, axis=0), np.repeat(one.wrench, 12, axis=0))
    names = tuple(NAMES)
    doubt = left_open(arm(), measured(arm(), same))
    assert doubt == Doubt("confounded", names, (), {"seen": 3})
    doubt = left_open(arm(), measured(arm(), one))
    assert doubt == Doubt("too-few-readings", names, (), {"readings": 1})


def left_open(bent: ElasticArm, data: Measurements) -> Doubt:
    """The one doubt of the error that refuses to fit."""
    with pytest.raises(IdentifiabilityError) as error:
        identify(bent, data)
    (doubt,) = error.value.doubts
    return doubt


def test_impossible_requests_are_refused() -> None:
    with pytest.raises(InputError, match=r"loss 'cauchy' is not known"):
        Fit(loss="cauchy")
    data = measured(arm(), hung(12))
    empty = chosen(data, np.zeros(12, dtype=bool))
    with pytest.raises(InputError, match="no readings"):
        identify(arm(), empty)
    exact = ComplianceModel(arm().springs, TRUTH)
    with pytest.raises(InputError, match="knows 'A2' exactly"):
        identify(arm(), data, prior=exact)


def weak(data: Measurements, how: Fit | None = None) -> dict[str, Doubt]:
    """The doubts about what is identified from `data`, by their codes."""
    return {doubt.code: doubt for doubt in doubts(identify(arm(), data, how))}


def named(found: Identification, code: str) -> tuple[str, ...]:
    """What the one doubt of a kind is about."""
    (doubt,) = (doubt for doubt in doubts(found) if doubt.code == code)
    return doubt.about


def test_a_strong_result_has_no_doubts() -> None:
    rng = np.random.default_rng(13)
    assert weak(measured(arm(), hung(24), rng=rng)) == {}


def test_weak_results_say_so() -> None:
    rng = np.random.default_rng(14)
    cases = hung(24)
    noisy = weak(measured(arm(), cases, rng=rng, promised=1e-5))["noisier-than-promised"]
    assert noisy.numbers["scale"] == pytest.approx(SIGMA / 1e-5, rel=0.3)
    assert noisy.numbers["dof"] == 3 * 24 - 5
    quiet = weak(measured(arm(), cases, rng=rng, promised=1e-4))["quieter-than-promised"]
    assert quiet.numbers["scale"] == pytest.approx(SIGMA / 1e-4, rel=0.3)
    good = measured(arm(), cases, rng=rng)
    assert "all-negative" in weak(replace(good, deflection=-good.deflection), LINEAR)
    assert "noisier-than-promised" in weak(measured(arm(), cases, rng=rng, promised=1e-7))
    assert "zero-in-interval" in weak(measured(arm(), hung(24, force=15.0), rng=rng))
    deflection = np.linalg.norm(good.deflection, axis=1).max()
    assert weak(good, LINEAR)["linear-model"].numbers == {"deflection": deflection}
    carried = weak(measured(arm(), hung(3), rng=rng))["carried"]
    assert carried.numbers["error_ratio"] >= 3.0
    assert len(carried.because) == 1


def test_repeats_tell_model_error_from_noise() -> None:
    """A base that gives way, and is not modelled: repeats agree, the model does not."""
    rng = np.random.default_rng(15)
    cases = hung(8, repeats=3)
    sound = identify(arm(), measured(arm(), cases, rng=rng))
    assert sound.lack_of_fit is not None
    assert sound.lack_of_fit.p_value > 1e-3
    robot = arm().robot
    tilt = VirtualJoints(
        ("tilt",), np.array([0]), np.array([[0.0, 1.0, 0.0]]), np.zeros((1, 3)), np.array([False])
    )
    soft = ElasticArm(robot, merged(joint_springs(robot, NAMES), tilt), arm().tool)
    exact = loaded_deflection(soft, np.append(0.3e-6, TRUTH), cases)
    data = measured(arm(), cases)
    data = replace(data, deflection=exact + SIGMA * rng.normal(size=exact.shape))
    found = identify(arm(), data)
    assert found.lack_of_fit is not None
    assert found.lack_of_fit.p_value < 1e-6
    assert found.lack_of_fit.pure_scale == pytest.approx(1.0, abs=0.3)
    (doubt,) = (doubt for doubt in doubts(found) if doubt.code == "model-error")
    assert doubt.numbers["fit_scale"] == found.lack_of_fit.fit_scale
    with_tilt = identify(soft, data)
    assert with_tilt.lack_of_fit is not None
    assert with_tilt.lack_of_fit.p_value > 1e-3


def test_lack_of_fit_has_its_distribution() -> None:
    rng = np.random.default_rng(16)
    cases = hung(6, repeats=2)
    p_values = [
        identify(arm(), measured(arm(), cases, rng=rng, linear=True), LINEAR).lack_of_fit.p_value  # type: ignore[union-attr]
        for _ in range(300)
    ]
    # Uniform: the mean of 300 is within 0.067 of a half with four standard errors.
    assert abs(np.mean(p_values) - 0.5) < 0.067


def test_lack_of_fit_counts_what_a_prior_says() -> None:
    rng = np.random.default_rng(26)
    cases = hung(3, repeats=3)
    p_values = []
    for _ in range(300):
        first = identify(arm(), measured(arm(), cases, rng=rng, linear=True), LINEAR)
        data = measured(arm(), cases, rng=rng, linear=True)
        lack = identify(arm(), data, LINEAR, prior=first.model).lack_of_fit
        assert lack is not None
        p_values.append(lack.p_value)
    assert abs(np.mean(p_values) - 0.5) < 0.067


def test_combinations_are_ordered_by_how_well_they_are_seen() -> None:
    found = identify(arm(), measured(arm(), hung(12)))
    assert (np.diff(found.singular_values) <= 0.0).all()
    np.testing.assert_allclose(found.combinations @ found.combinations.T, np.eye(5), atol=1e-12)


def test_covariances_that_cannot_be_inverted_are_named() -> None:
    data = measured(arm(), hung(12))
    tiny = replace(data, covariance=np.full(data.covariance.shape, 1e-320))
    with pytest.raises(InputError, match="covariance of a reading is not positive definite"):
        identify(arm(), tiny)
