"""What is promised of virtual campaigns, and what chance allows: against SciPy and by counting."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from elastocal.simulation.campaigns import Campaigns, MonteCarlo
from elastocal.simulation.monte_carlo import campaigns
from elastocal.simulation.prediction import (
    Cloud,
    chance,
    cloud,
    doubts_of_campaigns,
    predicted_total,
    worst_pair,
)
from tests.kr270 import kr270_study, kr270_truth, published_plans

COVARIANCE = np.array([[4e-16, -3e-9], [-3e-9, 9e-2]])  # of very different sizes
ROOT = np.linalg.cholesky(COVARIANCE)


@cache
def published() -> MonteCarlo:
    study = kr270_study()
    named = {"published": next(iter(published_plans().values()))}
    return campaigns(study, kr270_truth(study), named, 100, seed=1)


def hundred() -> Campaigns:
    return published().plans[0]


def test_predicted_errors_have_the_predicted_rms() -> None:
    sample = predicted_total(hundred())
    assert np.sqrt(np.mean(sample**2)) == pytest.approx(hundred().rho0, rel=5e-3)


def test_one_compliance_leaves_errors_of_a_half_normal_distribution() -> None:
    one = replace(hundred(), squares=np.array([1e-11]))
    sigma = np.sqrt(1e-11)
    for share in (0.1, 0.5, 0.9):
        expected = stats.halfnorm.ppf(share, scale=sigma)
        assert np.quantile(predicted_total(one), share) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("number", [2, 20, 50, 2000])
def test_ranges_of_chance(number: int) -> None:
    found = chance(number)
    half = stats.norm.ppf(0.975) / np.sqrt(number)
    assert found.bias == pytest.approx((-half, half), rel=1e-4)
    ratio = np.sqrt(stats.chi2.ppf([0.025, 0.975], number - 1) / (number - 1))
    assert found.spread == pytest.approx(tuple(ratio), rel=1e-12)
    counts = stats.binom.ppf([0.025, 0.975], number, 0.95)
    assert found.coverage == pytest.approx(tuple(counts / number), rel=1e-12)
    assert found.coverage[1] <= 1.0
    share = np.sqrt(0.95 * 0.05) * half  # as many as a normal has, up to one campaign
    assert found.coverage == pytest.approx((0.95 - share, 0.95 + share), abs=1.0 / number)


def test_share_inside_the_ellipse() -> None:
    shift = np.random.default_rng(0).standard_normal((20_000, 2)) @ ROOT.T
    assert Cloud(shift, COVARIANCE).inside == pytest.approx(0.95, abs=0.005)
    assert Cloud(2.0 * shift, COVARIANCE).inside == pytest.approx(
        1.0 - np.exp(-0.5 * stats.chi2.ppf(0.95, 2) / 4.0), abs=0.01
    )


def test_the_ellipse_is_a_level_of_the_density() -> None:
    outline = Cloud(np.zeros((1, 2)), COVARIANCE).ellipse
    level = np.sum(np.linalg.solve(ROOT, outline.T) ** 2, axis=0)
    np.testing.assert_allclose(level, stats.chi2.ppf(0.95, 2), rtol=1e-6)
    np.testing.assert_allclose(outline[0], outline[-1], rtol=1e-12)
    assert np.ptp(outline[:, 0]) == pytest.approx(2.0 * np.sqrt(5.991464547 * 4e-16), rel=1e-3)


def test_the_worst_pair_and_its_cloud() -> None:
    plan = hundred()
    covariance = np.diag([1.0, 4.0, 9.0])
    covariance[0, 2] = covariance[2, 0] = -2.7  # correlated by -0.9
    covariance[0, 1] = covariance[1, 0] = 1.0
    three = replace(
        plan,
        covariance=covariance,
        truth=np.array([1.0, 2.0, 3.0]),
        estimate=np.array([[2.0, 2.0, 1.0], [1.0, 5.0, 3.5]]),
    )
    assert worst_pair(three) == (0, 2)
    both = cloud(three, (0, 2))
    np.testing.assert_array_equal(both.shift, [[1.0, -2.0], [0.0, 0.5]])
    np.testing.assert_array_equal(both.covariance, [[1.0, -2.7], [-2.7, 9.0]])


def test_kept_promises_and_broken_ones() -> None:
    found, plan = published(), hundred()
    assert doubts_of_campaigns(found) == ()
    off = np.sqrt(1.0 + 3.0 * np.sqrt(2.0 / 100))
    for ratio, codes in ((0.99 * off, []), (1.01 * off, ["unlike-predicted"])):
        told = replace(plan, rho0_each=plan.rho0_each * plan.rms / plan.rho0 / ratio)
        doubts = doubts_of_campaigns(replace(found, plans=(told,)))
        assert [doubt.code for doubt in doubts] == codes
    assert doubts[0].about == ("published",)
    assert doubts[0].numbers["ratio"] == pytest.approx(1.01 * off)
    narrow = plan.inside.copy()
    narrow[:30, 3] = False
    (doubt,) = doubts_of_campaigns(replace(found, plans=(replace(plan, inside=narrow),)))
    assert (doubt.code, doubt.about, doubt.because) == ("not-covered", ("A5",), ("published",))
