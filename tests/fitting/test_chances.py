"""Chances of the usual statistics, against SciPy."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import special

from elastocal.fitting.chances import chi_square_above, normal_quantile, ratio_above


@pytest.mark.parametrize("p", [1e-300, 1e-12, 0.001, 0.025, 0.3, 0.5, 0.84, 0.975, 1.0 - 1e-12])
def test_normal_quantiles(p: float) -> None:
    assert normal_quantile(p) == pytest.approx(float(special.ndtri(p)), rel=1e-14, abs=1e-15)


def test_the_ends_of_the_normal_distribution() -> None:
    assert (normal_quantile(0.0), normal_quantile(1.0)) == (-math.inf, math.inf)
    assert math.isnan(normal_quantile(-0.1))
    assert math.isnan(normal_quantile(math.nan))


def test_statistics_of_any_size() -> None:
    """Of large ones digits are lost to logarithms of gamma functions that nearly cancel."""
    rng = np.random.default_rng(0)
    for _ in range(500):
        dof, other = np.ceil(10.0 ** rng.uniform(0.0, 5.0, 2)).tolist()
        digits = 1e-14 * max(dof + other, 100.0)
        value = dof * np.exp(3.0 * rng.normal() / np.sqrt(dof))
        ratio = np.exp(3.0 * rng.normal() / np.sqrt(min(dof, other)))
        for found, right in (
            (chi_square_above(value, dof), special.chdtrc(dof, value)),
            (ratio_above(ratio, dof, other), special.fdtrc(dof, other, ratio)),
        ):
            assert found == pytest.approx(float(right), rel=digits, abs=1e-14)


@pytest.mark.parametrize("value", [0.0, math.inf])
def test_nothing_and_everything(value: float) -> None:
    expected = float(value == 0.0)
    assert chi_square_above(value, 3.0) == ratio_above(value, 3.0, 4.0) == expected


def test_what_is_no_number_stays_none() -> None:
    assert math.isnan(chi_square_above(math.nan, 3.0))
    assert math.isnan(ratio_above(math.nan, 3.0, 4.0))


@pytest.mark.parametrize(("ratio", "dof", "other"), [(8.0 / 9.0, 6, 4), (2.0 / 3.0, 2, 1)])
def test_ratios_that_both_sides_are_as_near_to(ratio: float, dof: float, other: float) -> None:
    right = float(special.fdtrc(dof, other, ratio))
    assert ratio_above(ratio, dof, other) == pytest.approx(right, rel=1e-12)


@pytest.mark.parametrize(("ratio", "expected"), [(1e308, 0.0), (5e-324, 1.0)])
def test_ratios_beyond_floating_point(ratio: float, expected: float) -> None:
    assert ratio_above(ratio, 3.0, 7.0) == expected
