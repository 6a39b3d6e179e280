"""The least-squares core: certified values, bounds, directions that are not seen."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastocal.arrays import Array
from elastocal.fitting.bounds import Bounds
from elastocal.fitting.least_squares import column_norms, fit, fits
from tests.fitting.nist import DATASETS

# Correct digits wanted. For Filip double precision sets the limit: the condition of its scaled
# columns is 5e9, and its powers of x are rounded before anything is solved; 7.6 are reached.
DIGITS = {"Filip": 7.0}
AT_LEAST = 8.0


def correct_digits(found: Array, certified: Array) -> float:
    """Least number of correct significant digits."""
    error = np.abs(found - certified) / np.where(certified == 0.0, 1.0, np.abs(certified))
    return float(-np.log10(np.maximum(error.max(), 1e-15)))


@pytest.mark.parametrize("name", DATASETS)
def test_certified_estimates(name: str) -> None:
    data = DATASETS[name]
    digits = correct_digits(fit(data.rows, data.values).estimate, data.estimate)
    assert digits >= DIGITS.get(name, AT_LEAST), digits


@pytest.mark.parametrize("name", [n for n, d in DATASETS.items() if d.standard_error.any()])
def test_certified_standard_errors(name: str) -> None:
    data = DATASETS[name]
    found = fit(data.rows, data.values)
    variance = found.residual_sum / (len(data.values) - len(data.estimate))
    scale = column_norms(found.triangle)
    inverse = np.linalg.inv(found.triangle / scale) / scale[:, None]
    errors = np.sqrt(variance * np.sum(inverse**2, axis=1))
    digits = correct_digits(errors, data.standard_error)
    assert digits >= DIGITS.get(name, AT_LEAST), digits


def test_chunks_change_nothing() -> None:
    """More rows than one chunk holds, against NumPy's own solver."""
    rng = np.random.default_rng(1)
    rows = rng.normal(size=(200_000, 4)) * [1.0, 1e-6, 1e3, 1e6]
    values = rows @ np.array([1.0, 2e6, 3e-3, 4e-6]) + rng.normal(size=len(rows))
    found = fit(rows, values)
    norms = column_norms(rows)
    expected, residual, _, _ = np.linalg.lstsq(rows / norms, values, rcond=None)
    expected = expected / norms
    np.testing.assert_allclose(found.estimate, expected, rtol=1e-12)
    assert found.residual_sum == pytest.approx(float(residual[0]), rel=1e-12)
    np.testing.assert_allclose(found.information, rows.T @ rows, rtol=1e-10, atol=1e-4)


@given(st.integers(0, 10_000))
def test_bounds_hold_and_are_optimal(seed: int) -> None:
    """The conditions of Karush, Kuhn and Tucker, checked from the problem alone."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(12, 4)) * 10.0 ** rng.uniform(-6, 6, 4)
    values = rng.normal(size=12)
    lower = np.zeros(4)
    found = fit(rows, values, bounds=Bounds(lower))
    slope = rows.T @ (rows @ found.estimate - values) / column_norms(rows)
    assert (found.estimate >= -1e-12 * np.abs(found.estimate).max()).all()
    assert np.abs(slope[~found.held]).max(initial=0.0) < 1e-10
    assert (slope[found.held] > -1e-10).all()


def test_bounds_that_do_not_bind_change_nothing() -> None:
    data = DATASETS["Norris"]
    free = fit(data.rows, data.values)
    bound = fit(data.rows, data.values, bounds=Bounds(np.array([-1.0, 0.0])))
    np.testing.assert_allclose(bound.estimate, free.estimate, rtol=1e-12)
    assert not bound.held.any()


def test_without_unknowns_the_values_are_left() -> None:
    found = fit(np.zeros((3, 0)), np.array([1.0, 2.0, 2.0]))
    assert found.residual_sum == pytest.approx(9.0)
    assert found.estimate.shape == found.held.shape == (0,)


def test_under_bounds_the_residual_sum_is_that_of_the_estimate() -> None:
    """What holding an unknown costs is in it, for each of several sets of values."""
    rng = np.random.default_rng(4)
    rows, values = rng.normal(size=(9, 2)), rng.normal(size=(3, 9))
    values[0] = rows @ [-2.0, 1.0]  # exact, but for the bound
    found = fits(rows[None], values, bounds=Bounds(np.zeros(2)))
    left = values - found.estimate @ rows.T
    np.testing.assert_allclose(found.residual_sum, np.sum(left**2, axis=1), rtol=1e-12)
    assert found.held[0].tolist() == [True, False]
    assert found.residual_sum[0] > 1.0
