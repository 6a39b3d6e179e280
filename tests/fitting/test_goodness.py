"""Lack of fit by hand: a one-way table of repeats, with scales that are not 1."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from elastocal.fitting.goodness import lack_of_fit, p_value_chi_square, p_value_ratio

SIGMA = 2.0


def noise(count: int) -> np.ndarray:
    return np.tile(SIGMA * np.eye(3), (count, 1, 1))


def test_two_repeats_apart_by_four_of_their_noise() -> None:
    """±2 on one axis: squares 8 over 3 degrees of freedom; as many unknowns as means: no more."""
    residual = np.zeros((2, 3))
    residual[:, 0] = 2.0, -2.0
    found = lack_of_fit(residual, noise(2), np.array([5, 5]), parameters=3)
    assert found is not None
    assert found.pure_scale == pytest.approx(np.sqrt(8.0 / 3.0))
    assert found.pure_dof == 3
    assert (found.fit_scale, found.fit_dof) == (0.0, 0)
    assert np.isnan(found.p_value)


def test_an_unequal_table_by_hand() -> None:
    """Groups of 1, 2 and 4; squares about means and of means, each by plain arithmetic."""
    rng = np.random.default_rng(0)
    group = np.array([7, 2, 2, 9, 9, 9, 9])
    residual = 3.0 * rng.normal(size=(7, 3)) + 2.0 * group[:, None]
    pure = about = 0.0
    for g in np.unique(group):
        mine = residual[group == g]
        mean = mine.mean(axis=0)
        pure += float(np.sum((mine - mean) ** 2))
        about += float(len(mine) * np.sum(mean**2))
    found = lack_of_fit(residual, noise(7), group, parameters=4, misfit=10.0)
    assert found is not None
    assert (found.pure_dof, found.fit_dof) == (12, 5)
    assert found.pure_scale == pytest.approx(np.sqrt(pure / 12.0))
    assert found.fit_scale == pytest.approx(np.sqrt((about + 10.0) / 5.0))
    from scipy.stats import f

    ratio = (found.fit_scale / found.pure_scale) ** 2
    assert found.p_value == pytest.approx(f.sf(ratio, 5, 12), rel=1e-9)


def test_twice_the_promised_noise_is_twice() -> None:
    residual = 2.0 * np.random.default_rng(1).normal(size=(400, 3))
    found = lack_of_fit(residual, noise(400), np.arange(400) // 4, parameters=5)
    assert found is not None
    assert found.pure_scale == pytest.approx(2.0, abs=0.1)
    assert found.fit_scale == pytest.approx(2.0, abs=0.2)


def test_a_reading_counts_by_its_own_noise() -> None:
    """The common value of readings 0 and 3 with noise 1 and 2 is 3/5: 0.6² + 1.2² are left."""
    residual = np.array([[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]])
    unequal = np.array([np.eye(3), 2.0 * np.eye(3)])
    found = lack_of_fit(residual, unequal, np.zeros(2, dtype=int), parameters=1)
    assert found is not None
    assert found.pure_scale == pytest.approx(np.sqrt((0.6**2 + 1.2**2) / 3.0))
    assert found.fit_scale == pytest.approx(np.sqrt((1.5**2 - 0.6**2 - 1.2**2) / 2.0))


def test_one_degree_of_freedom_of_the_means_is_one() -> None:
    """Two means, five unknowns: all of the squares of the means are over one freedom."""
    residual = np.repeat([[1.0, 2.0, 2.0], [0.0, 0.0, 4.0]], 2, axis=0)
    residual[0, 0] += 0.5
    residual[1, 0] -= 0.5
    found = lack_of_fit(residual, noise(4), np.array([0, 0, 1, 1]), parameters=5)
    assert found is not None
    assert found.fit_dof == 1
    assert found.fit_scale == pytest.approx(np.sqrt(2 * 9.0 + 2 * 16.0))
    assert found.pure_scale == pytest.approx(np.sqrt(0.5 / 6.0))


def test_no_repeats_no_answer() -> None:
    assert lack_of_fit(np.ones((3, 3)), noise(3), np.arange(3), parameters=2) is None


def test_chi_square_by_hand() -> None:
    """With two degrees of freedom the tail is exp(-χ²/2); with none there is none."""
    assert p_value_chi_square(3.0, 2) == pytest.approx(np.exp(-1.5))
    assert p_value_chi_square(3.0, 1) > 0.0
    assert np.isnan(p_value_chi_square(3.0, 0))


def test_two_estimates_of_one_noise() -> None:
    """The F test of equal variances, in either direction."""
    for scale, dof, other, other_dof in ((1.3, 20.0, 0.9, 31.5), (0.5, 12.0, 1.1, 40.0)):
        ratio = scale**2 / other**2
        f = stats.f(dof, other_dof)
        expected = 2.0 * min(f.sf(ratio), f.cdf(ratio))
        assert p_value_ratio(scale, dof, other, other_dof) == pytest.approx(expected, rel=1e-9)
        swapped = p_value_ratio(other, other_dof, scale, dof)
        assert swapped == pytest.approx(expected, rel=1e-9)
    assert np.isnan(p_value_ratio(1.0, 0.0, 1.0, 3.0))
    assert np.isnan(p_value_ratio(float("nan"), 3.0, 1.0, 3.0))
