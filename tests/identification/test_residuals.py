"""Residuals against normal noise: the textbook's order statistics, and counting by hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.residuals import (
    left_out_rms,
    residual_quantiles,
    share_inside,
    twice_the_noise,
)
from elastocal.identification.result import Identification
from elastocal.identification.validation import doubts_of_validation, validate
from elastocal.measuring.measurements import rms_of_groups
from elastocal.simulation.virtual_campaign import simulate
from tests.kr270 import kr270_study, kr270_truth, published_cases


@cache
def found(sigma: str = "known") -> Identification:
    study = kr270_study()
    truth = kr270_truth(study)
    rng = np.random.default_rng(5)
    data = simulate(study, truth, published_cases(4), np.array([3, 1, 5, 2]), rng)
    return identify(study.arm, data, Fit(sigma=sigma), known=truth)  # type: ignore[arg-type]


def typical(found: Identification) -> float:
    """Standard deviation of a coordinate of the positions [m]."""
    return found.measurements.noise_of(found.measurements.quantities[0])


def test_noise_as_promised_or_as_estimated() -> None:
    sigma = kr270_study().sigma
    assert typical(found()) == pytest.approx(sigma)
    np.testing.assert_allclose(found().measurements.deviation, sigma)
    assert found().noise_factor == 1.0
    np.testing.assert_allclose(twice_the_noise(found()), 2.0 * sigma)
    estimated = found("estimated")
    assert estimated.noise_factor == estimated.scale != 1.0
    np.testing.assert_allclose(twice_the_noise(estimated), 2.0 * estimated.scale * sigma)


def test_share_inside_counts_coordinates() -> None:
    one = found()
    sigma = typical(one)
    residual = np.zeros_like(one.residual)
    residual[0, 0], residual[3, 2], residual[4, 1] = 2.1 * sigma, -2.1 * sigma, 1.9 * sigma
    assert share_inside(replace(one, residual=residual)) == pytest.approx(1.0 - 2.0 / residual.size)


def test_left_out_residuals_are_averaged_over_the_coordinates_of_an_experiment() -> None:
    one = found()
    sigma = typical(one)
    left_out = np.zeros_like(one.left_out)
    left_out[1] = sigma * np.array([1.0, 2.0, 2.0])
    without = replace(one.without_experiment, residual=left_out)
    size = left_out_rms(replace(one, without_experiment=without))
    assert size[1] == pytest.approx(np.sqrt(9.0 / 3.0))
    assert (np.delete(size, 1) == 0.0).all()


def test_root_mean_squares_of_groups() -> None:
    error = np.array([[3.0, 0.0, 4.0], [0.0, 0.0, 1.0], [0.0, 7.0, 0.0]])
    size = rms_of_groups(error, np.array([2, 2, 0]), 4)
    np.testing.assert_allclose(size, [7.0, 0.0, np.sqrt(13.0), 0.0])


def test_quantiles_have_the_order_statistics_of_the_textbook() -> None:
    one = found()
    count = one.residual.size
    told = residual_quantiles(one)
    assert told is not None
    freedom = typical(one) * np.sqrt(one.dof / count)
    np.testing.assert_allclose(told.found, np.sort(one.residual.ravel()) / freedom)
    for k in (1, 7, count):
        spread = stats.beta(k, count - k + 1)
        low, high = stats.norm.ppf(spread.ppf([0.025, 0.975]))
        assert told.low[k - 1] == pytest.approx(low)
        assert told.high[k - 1] == pytest.approx(high)
        assert told.expected[k - 1] == pytest.approx(stats.norm.ppf((k - 0.5) / count))


def test_few_degrees_of_freedom_have_no_quantiles() -> None:
    assert residual_quantiles(replace(found(), dof=7)) is None
    assert residual_quantiles(replace(found(), dof=8)) is not None


def test_many_residuals_are_thinned_in_the_middle() -> None:
    one = found()
    many = 400
    data = replace(
        one.measurements,
        case=np.zeros(many, dtype=np.int64),
        marker=np.zeros(many, dtype=np.int64),
        deflection=np.zeros((many, 3)),
        covariance=np.tile(np.eye(3), (many, 1, 1)),
    )
    residual = np.random.default_rng(0).permutation(3 * many).reshape(many, 3).astype(float)
    told = residual_quantiles(replace(one, residual=residual, measurements=data, dof=3 * many))
    assert told is not None
    assert len(told.found) <= 500
    np.testing.assert_array_equal(told.found[:125], np.arange(125))
    np.testing.assert_array_equal(told.found[-125:], np.arange(3 * many - 125, 3 * many))
    assert told.expected[0] == pytest.approx(stats.norm.ppf(0.5 / (3 * many)))


def test_the_linear_model_is_off_by_standard_errors() -> None:
    one = found()
    shifted = replace(one, linear=one.compliance - 3.0 * one.standard_error)
    np.testing.assert_allclose(shifted.linear_shift, 3.0)


def test_a_validation_doubts_what_got_worse() -> None:
    one = validate(found().arm, found().model, found().measurements)
    assert doubts_of_validation(one) == ()
    after = one.after.copy()
    after[one.measurements.case == 2] = 2.0 * one.before[one.measurements.case == 2]
    worse = replace(one, after=after, chi_square=3.0 * one.dof)
    first, second = doubts_of_validation(worse)
    assert (first.code, first.about) == ("worse-with-model", (one.measurements.names[2],))
    assert second.code == "errors-unexplained"
    assert second.numbers["p_value"] == pytest.approx(stats.chi2.sf(3.0 * one.dof, one.dof))
    assert second.numbers["confidence"] == 0.95
