"""What sums of squares stay below: against SciPy where that has a name, else by drawing."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from elastocal.squares import largest_likely


@pytest.mark.parametrize("share", [0.8, 0.95, 0.999])
@pytest.mark.parametrize("count", [1, 2, 3, 12])
def test_equal_weights_are_chi_square(count: int, share: float) -> None:
    found = largest_likely(np.full(count, 4e-12), share)
    assert found**2 == pytest.approx(4e-12 * stats.chi2.ppf(share, count), rel=1e-9)


@pytest.mark.parametrize("dof", [2.0, 5.0, 31.0])
def test_an_estimated_variance_makes_them_those_of_f(dof: float) -> None:
    for count in (1, 3):
        found = largest_likely(np.ones(count), 0.95, dof)
        assert found**2 == pytest.approx(count * stats.f.ppf(0.95, count, dof), rel=1e-3)


def test_weights_of_any_size() -> None:
    weight = np.array([1.0, 0.3, 0.01, 1e-5, 1e-14, 0.0])
    drawn = np.random.default_rng(0).standard_normal((400_000, len(weight)))
    expected = np.quantile(drawn**2 @ weight, 0.95)
    assert largest_likely(weight) ** 2 == pytest.approx(expected, rel=0.01)


def test_nothing_and_everything() -> None:
    assert largest_likely(np.zeros(3)) == 0.0
    assert largest_likely(np.zeros(0)) == 0.0
    assert largest_likely(np.array([np.inf, 0.0])) == np.inf
