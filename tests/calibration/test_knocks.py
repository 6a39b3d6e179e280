"""Knocks of a tracker seen by the readings of the arm alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.doubts import doubts
from elastocal.calibration.knocks import Knock, likeliest_knocks, split_at
from elastocal.calibration.parameters import parameters_of
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Tool, transform
from elastocal.robot.geometry import geometric_errors
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    Foot,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm, drawn_displacements
from elastocal.simulation.virtual_campaign import Outliers
from elastocal.wording import worded
from tests.arms import random_chain, random_rotation

SIGMA = 2e-5
TOOL = Tool("tool", np.zeros(3), np.eye(3)[:2] * 0.2, ("A", "B"))
ROBOT = random_chain(np.random.default_rng(0), [False, False, False])
RIGID = joint_springs(ROBOT, ())
MODEL = ArmModel(ROBOT, TOOL, geometric_errors(ROBOT), each_spring(RIGID), np.zeros(3))


def campaign(seed: int, after: int = -1, outliers: Outliers | None = None) -> Positions:
    """Thirty poses; the station is knocked by ten times the noise after a reading."""
    rng = np.random.default_rng(seed)
    moved = drawn_displacements(ROBOT, 3e-4, 3e-4, rng)
    arm = TrueArm(ROBOT, moved, RIGID, np.zeros(0), np.zeros(3))
    way = rng.normal(size=3)
    bump = np.append(10.0 * SIGMA * way / np.linalg.norm(way), np.zeros(3))
    T = transform(random_rotation(rng), [3.0, 0.0, 1.0])
    station = TrueStation(T, bumped_after=after, bump=bump)
    foot = Foot(rng.normal(size=(3, 3)), 2)
    truth = AbsoluteTruth(arm, TOOL.markers[None], (station,), foot=foot)
    visits = Visits(rng.uniform(-1.5, 1.5, (30, 3)))
    return simulated_positions(truth, TOOL, visits, rng, covariance=alike(SIGMA), outliers=outliers)


def found(positions: Positions) -> tuple[Calibration, Knock]:
    fit = calibrate(MODEL, positions, parameters_of(MODEL, positions))
    (knock,) = likeliest_knocks(fit)
    return fit, knock


@pytest.mark.parametrize("seed", range(8))
def test_a_knock_of_ten_times_the_noise_is_found_where_it_was(seed: int) -> None:
    after = int(np.random.default_rng(seed).integers(10, 50))
    fit, knock = found(campaign(seed, after))
    assert knock.p_value < 1e-4
    assert knock.first < after <= knock.last
    assert knock.size == pytest.approx(10.0 * SIGMA, rel=0.4)
    (said,) = (d for d in doubts(fit) if d.code == "tracker-knocked")
    assert "seems to have moved by" in worded(said)


@pytest.mark.parametrize("seed", range(8))
def test_a_tracker_that_stands_still_is_not_blamed(seed: int) -> None:
    fit, knock = found(campaign(seed))
    assert knock.p_value > 0.01
    assert not any(d.code == "tracker-knocked" for d in doubts(fit))


@pytest.mark.parametrize("seed", range(4))
def test_bad_rows_are_no_knock(seed: int) -> None:
    assert found(campaign(seed, outliers=Outliers(0.05, 2e-3)))[1].p_value > 0.01


def test_two_stations_of_the_one_that_was_knocked_fit() -> None:
    positions = campaign(3, 31)
    knock = found(positions)[1]
    apart = split_at(positions, knock)
    assert len(apart.stations) == 2
    assert apart.station.tolist() == [0] * knock.after + [1] * (60 - knock.after)
    assert apart.foot is not None
    assert apart.foot.station.tolist() == [0, 0, 0, 1, 1, 1]
    fit = calibrate(MODEL, apart, parameters_of(MODEL, apart))
    assert np.sqrt((fit.error**2).mean()) < 1.2 * SIGMA
    assert all(k.p_value > 0.01 for k in likeliest_knocks(fit))


def test_few_poses_say_nothing() -> None:
    positions = campaign(2)
    few = replace(positions, station=np.arange(60) // 12, stations=tuple("abcde"))
    fit = calibrate(MODEL, few, parameters_of(MODEL, few))
    assert likeliest_knocks(fit) == ()
