"""Deflections near known ones, against the equilibria themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import deflection_and_gradient, loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.neighbourhood import deflection_series
from elastocal.elastic.springs import joint_springs
from elastocal.robot.chain import Tool
from elastocal.robot.shapes import BodyMass
from elastocal.robot.sources.kuka_kr270 import kuka_kr270

FREE = np.array([1, 2, 4])
TRUTH = np.array([0.3, 0.3, 0.4, 3.0, 3.0, 2.0]) * 1e-6
CASES = LoadCases(
    np.random.default_rng(0).uniform(-1.5, 1.5, (3, 6)),
    np.random.default_rng(1).normal(size=(3, 6)) * [2e3, 2e3, 2e3, 1e2, 1e2, 1e2],
)


def arm(*, sags: bool, rotation: bool) -> ElasticArm:
    robot = kuka_kr270()
    if sags:
        masses = (BodyMass(2, 300.0, np.array([0.5, 0.0, 0.1])), BodyMass(4, 150.0, np.zeros(3)))
        robot = replace(robot, masses=masses)
    tool = Tool("t", np.array([0.6, 0, -0.4]), np.array([[0.6, 0.1, 0]]), ("M",), rotation=rotation)
    gravity = np.array([0.0, 0.0, -9.81]) if sags else np.zeros(3)
    return ElasticArm(robot, joint_springs(robot), tool, gravity)


@pytest.mark.parametrize("sags", [False, True])
@pytest.mark.parametrize("rotation", [False, True])
def test_what_is_left_out_is_of_fourth_order(sags: bool, rotation: bool) -> None:
    """Twice as far away it is 16 times as much, and its gradient's 8 times."""
    bent = arm(sags=sags, rotation=rotation)
    series = deflection_series(bent, TRUTH, CASES, FREE)
    assert series is not None
    off = []
    for share in (2.0, 4.0):
        change = share * TRUTH[FREE] * [1.0, 0.7, 1.4]
        compliance = TRUTH.copy()
        compliance[FREE] += change
        value, exact = series.at(change[None])
        right, slope = deflection_and_gradient(bent, compliance, CASES)
        found = series.gradient(change[None])[0]
        slope = slope[..., FREE].reshape(found.shape)
        off.append((np.abs(value[0] - right.ravel()).max(), np.abs(found - slope).max()))
        assert not exact[0]
    low, high = np.array(off)
    assert 12.0 < high[0] / low[0] < 20.0
    assert 6.0 < high[1] / low[1] < 10.0


def test_a_few_percent_beside_it_is_exact_and_says_so() -> None:
    bent = arm(sags=True, rotation=True)
    series = deflection_series(bent, TRUTH, CASES, FREE)
    assert series is not None
    shares = np.random.default_rng(2).normal(0.0, 0.03, (50, 3))
    values, exact = series.at(shares * TRUTH[FREE])
    assert exact.all()
    for share, value in zip(shares, values, strict=True):
        compliance = TRUTH.copy()
        compliance[FREE] *= 1.0 + share
        right = loaded_deflection(bent, compliance, CASES).ravel()
        np.testing.assert_allclose(value, right, atol=2e-12 * np.abs(right).max())


def test_a_compliance_of_zero_has_no_scale() -> None:
    start = TRUTH * [1.0, 0.0, 1.0, 1.0, 1.0, 1.0]
    assert deflection_series(arm(sags=False, rotation=False), start, CASES, FREE) is None
