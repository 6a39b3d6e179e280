"""Factors that are one, or nearly, in most campaigns: here they are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.fitting.goodness import lack_of_fit
from elastocal.fitting.mixed import Rows, noise_variance, spread_found
from elastocal.fitting.robust import robust_scale
from elastocal.identification.doubts import doubts
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.left_out_error import left_out_error
from elastocal.identification.uncertainty import _variance
from elastocal.identification.validation import leave_one_out, validate
from tests.identification.test_nuisance import (
    ERRORS,
    LINEAR,
    SIGMA,
    TRUTH,
    WHOLE,
    campaign,
    dense,
    lighter,
    nuisance,
    rows_of,
)

ESTIMATED = Fit("linear", "estimated")


def test_a_validation_knows_the_noise_that_was_found_and_from_how_much() -> None:
    """Three times the promised noise, of four degrees of freedom: t, F, and 9 Σ."""
    arm, data = campaign(np.append(TRUTH, np.zeros(4)))
    noise = 4.0 * SIGMA * np.random.default_rng(0).normal(size=data.deflection.shape)
    light = lighter(replace(data, deflection=data.deflection + noise))
    spread = np.diag([1e-10, 4e-10, 2e-10])
    model = ComplianceModel(arm.springs, TRUTH, spread, dof=4.0, noise=3.0)
    found = validate(arm, model, light, confidence=0.9)
    rows = regressor(arm, light.cases).reshape(-1, 3)
    whole = rows @ spread @ rows.T + 9.0 * np.kron(np.eye(18), light.covariance[0])
    np.testing.assert_allclose(found.deviation.ravel() ** 2, np.diagonal(whole), rtol=1e-4)
    np.testing.assert_allclose(
        found.half_width, stats.t.ppf(0.95, 4.0) * found.deviation, rtol=1e-9
    )
    after = found.after.ravel()
    square = after @ np.linalg.solve(whole, after)
    assert found.chi_square == pytest.approx(square, rel=1e-3)
    assert found.p_value == pytest.approx(stats.f.sf(square / 54.0, 54, 4.0), rel=1e-2)
    assert stats.chi2.sf(square, 54) < 0.5 * found.p_value
    known = replace(model, dof=np.inf, noise=1.0)
    found = validate(arm, known, light)
    assert found.p_value == pytest.approx(stats.chi2.sf(found.chi_square, 54), rel=1e-6)


def test_what_is_left_out_is_judged_by_the_noise_that_was_found() -> None:
    """A fifth of the noise promised: five is found, and what is expected grows by as much."""
    arm, data = campaign(np.append(TRUTH, np.zeros(4)))
    quiet = replace(data, covariance=data.covariance / 25.0)
    found = identify(arm, quiet, ESTIMATED)
    assert found.scale == pytest.approx(5.0, rel=0.3)
    left = leave_one_out(found)
    assert left.chi_square == pytest.approx(found.dof)
    assert np.isnan(left.p_value)
    known = identify(arm, data, LINEAR)
    off = found.scale / 5.0
    np.testing.assert_allclose(left.deviation, off * leave_one_out(known).deviation, rtol=1e-6)
    half = stats.t.ppf(0.975, found.dof) * left.deviation
    np.testing.assert_allclose(left.half_width, half, rtol=1e-9)


def test_a_robust_fit_of_few_readings_has_few_degrees_of_freedom() -> None:
    arm, data = campaign(np.append(TRUTH, np.zeros(4)), markers=1)
    found = identify(arm, data, Fit("linear", "estimated", "huber"))
    assert found.model.dof == found.dof == 24.0
    half = stats.t.ppf(0.975, 24) * found.standard_error
    np.testing.assert_allclose(np.diff(found.interval)[:, 0], 2.0 * half)
    before = ComplianceModel(arm.springs, TRUTH, 1e-9 * np.eye(3))
    prior = identify(arm, data, Fit("linear", "estimated", "huber"), prior=before)
    assert prior.model.dof == 27.0


def test_a_robust_scale_counts_what_was_fitted() -> None:
    """The median of squared sizes over that of χ² of three, and over the share of freedom left."""
    size = np.array([1.0, 2.0, 3.0, 4.0, 50.0])
    middle = 9.0 / stats.chi2.ppf(0.5, 3)
    assert robust_scale(size, 15) == pytest.approx(np.sqrt(middle), rel=1e-3)
    assert robust_scale(size, 5) == pytest.approx(np.sqrt(3.0 * middle), rel=1e-3)


def test_a_limit_is_one_sided_and_an_interval_beside_nuisance_ends_at_zero() -> None:
    truth = np.append(TRUTH, np.zeros(4))
    truth[0] = -2e-4
    arm, data = campaign(truth, markers=4)
    how = replace(LINEAR, nonnegative=True, confidence=0.9)
    found = identify(arm, data, how)
    assert found.held == ("J1",)
    free = identify(arm, data, replace(how, nonnegative=False))
    np.testing.assert_allclose(found.unbounded, free.compliance, rtol=1e-6)
    limit = max(free.compliance[0], 0.0) + stats.norm.ppf(0.9) * found.standard_error[0]
    np.testing.assert_allclose(found.interval[0], [0.0, limit], rtol=1e-9)
    truth[0] = 1e-6  # as small as its error
    arm, data = campaign(truth, markers=1)
    wide = identify(arm, data, LINEAR, nuisance=replace(nuisance(), deviation=np.full(4, 1e-3)))
    assert (wide.interval[:, 0] >= 0.0).all()
    plain = wide.compliance - stats.norm.ppf(0.975) * wide.standard_error
    assert (plain < 0.0).any()


def test_priors_have_means() -> None:
    what = replace(nuisance(ERRORS), mean=np.array([2e-4, 1e-4, 1e-4, -1e-5]))
    arm, data = campaign(WHOLE)
    found = identify(arm, data, LINEAR, nuisance=what)
    rows, values = rows_of(arm, data.cases, what), data.deflection.ravel()
    near = np.append(identify(arm, data, LINEAR).compliance, np.zeros(4))
    prior = np.diag(np.append(np.zeros(3), what.deviation**-2.0))
    for _ in range(2):
        inverse = np.linalg.inv(dense(arm, data, what, near))
        right = rows.T @ inverse @ values + prior @ np.append(np.zeros(3), what.mean)
        near = np.linalg.solve(rows.T @ inverse @ rows + prior, right)
    assert not found.held
    np.testing.assert_allclose(found.unknown, near, rtol=1e-6)


def test_what_is_more_than_stated_is_said_with_its_size() -> None:
    """Noise that is twice what is promised, beside errors of load cases."""
    arm, data = campaign(WHOLE, markers=4)
    what = nuisance(CaseErrors(discrepancy=0.01))
    right = identify(arm, data, LINEAR, nuisance=what)
    assert "more-than-stated" not in {doubt.code for doubt in doubts(right)}
    wrong = identify(arm, replace(data, covariance=data.covariance / 4.0), LINEAR, nuisance=what)
    (doubt,) = (doubt for doubt in doubts(wrong) if doubt.code == "more-than-stated")
    p = stats.chi2.sf(wrong.chi_square, wrong.dof)
    assert doubt.numbers["p_value"] == pytest.approx(p, rel=1e-6)
    assert doubt.numbers["scale"] == pytest.approx(np.sqrt(wrong.chi_square / wrong.dof))
    # What the model promises of it already is no error of the model besides.
    error = left_out_error(wrong)
    assert 0.0 < error.promised < error.seen
    beyond = np.sqrt(error.seen**2 - error.promised**2)
    assert wrong.model.model_error == pytest.approx(beyond)
    assert right.model.model_error == 0.0


def test_repeats_contradict_the_joints_alone_or_not() -> None:
    """The error of left-out load cases goes along only where repeats refute the model."""
    arm, data = campaign(np.append(TRUTH, [9e-4, 9e-4, 3e-4, 0.0]))
    wrong = identify(arm, data, ESTIMATED)
    assert wrong.lack_of_fit is not None
    assert wrong.lack_of_fit.beyond_chance
    assert wrong.model.model_error == pytest.approx(left_out_error(wrong).seen)
    arm, data = campaign(np.append(TRUTH, np.zeros(4)))
    assert identify(arm, data, ESTIMATED).model.model_error == 0.0


def test_the_freedom_of_means_that_err_in_absolute_size() -> None:
    """F of what is expected, with more degrees of freedom the less of it is noise."""
    rng = np.random.default_rng(3)
    group = np.repeat(np.arange(6), 3)
    rows = np.repeat(rng.normal(size=(18, 2)).reshape(6, 3, 2), 3, axis=0).reshape(54, 2)
    values = 2.0 * rng.normal(size=54) + np.repeat(2.0 * rng.normal(size=(6, 3)), 3, axis=0).ravel()
    mean = np.kron(np.kron(np.eye(6), np.full((1, 3), 3.0**-0.5)), np.eye(3))  # orthonormal
    rest = np.linalg.svd(mean)[2][18:]
    turned = np.vstack([mean, rest])
    absolute = np.append(np.full(18, 3.0 * 4.0), np.zeros(36))
    beside = Rows(turned @ rows, turned @ values, np.ones(54), absolute)
    weight = 1.0 / (1.0 + absolute)
    k = np.linalg.lstsq(
        turned @ rows * np.sqrt(weight)[:, None], turned @ values * np.sqrt(weight), rcond=None
    )[0]
    left = (values - rows @ k).reshape(18, 3)
    noise = np.tile(np.eye(3), (18, 1, 1))
    found = lack_of_fit(left, noise, group, 2, beside=beside)
    assert found is not None
    pure = float(np.sum((rest @ values) ** 2)) / 36.0
    weight = 1.0 / (pure + absolute[:18])
    means = mean @ rows
    spread = np.linalg.inv(means.T * weight @ means)
    away = mean @ values - means @ spread @ (means.T * weight) @ (mean @ values)
    square = float(np.sum(weight * away**2)) / 16.0
    shares = pure * (weight.sum() - np.trace(spread @ (means.T * weight**2) @ means)) / 16.0
    expected = stats.f.sf(square, 16, 36.0 / shares**2)
    assert found.p_value == pytest.approx(expected, rel=1e-6)
    assert shares < 0.4
    assert expected != pytest.approx(stats.f.sf(square, 16, 36.0), rel=0.01)


def test_common_errors_of_loads_are_of_the_load_cases_of_the_fit() -> None:
    """A tilt of all loads is one unknown for each axis, of the size that is stated."""
    arm, data = campaign(np.append(TRUTH, np.zeros(4)))
    what = nuisance(CaseErrors(common_tilt=0.02, common_gain=0.03))
    found = identify(arm, data, LINEAR, nuisance=what)
    names = ("load gain", "load tilt x", "load tilt y", "load tilt z")
    assert found.fitted[-4:] == names
    near = identify(arm, data, LINEAR).compliance
    columns = [0.03 * rows_of(arm, data.cases, what)[:, :3] @ near]
    for axis in np.eye(3):
        force, moment = np.split(data.cases.wrench, 2, axis=1)
        turned = np.hstack([np.cross(axis, force), np.cross(axis, moment)])
        load = LoadCases(data.cases.q, turned)
        columns.append(0.02 * rows_of(arm, load, what)[:, :3] @ near)
    rows = np.column_stack([rows_of(arm, data.cases, what), *columns])
    weight = 1.0 / data.covariance[0, 0, 0]
    prior = np.diag(np.concatenate([np.zeros(3), what.deviation**-2.0, np.ones(4)]))
    spread = np.linalg.inv(weight * rows.T @ rows + prior)
    np.testing.assert_allclose(np.diagonal(found.unknown_covariance), np.diagonal(spread), rtol=0.1)


def test_noise_that_is_told_by_next_to_nothing_is_not_told() -> None:
    """Every coordinate errs by ten times the noise besides: less than three degrees of freedom."""
    rng = np.random.default_rng(5)
    told, held_back = 0, 0
    for size in (0.1, 10.0):
        for _ in range(30):
            values = np.sqrt(1.0 + size) * rng.normal(size=36)
            rows = Rows(rng.normal(size=(36, 5)), values, np.ones(36), np.full(36, size))
            found, shown = noise_variance(rows), _variance(rows, 1.0)
            enough = found > 0.0 and spread_found(rows, found).dof >= 3.0
            assert shown == (found if enough else 0.0)
            told += enough
            held_back += found > 0.0 and not enough
    assert told >= 30
    assert held_back >= 3
