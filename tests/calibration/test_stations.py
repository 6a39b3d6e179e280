"""Stations by reflectors on the foot: still, drifting or knocked, and what is taken off."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.calibration.stations import (
    DRIFTING,
    KNOCKED,
    STILL,
    knock_sentence,
    station_motions,
    steadied,
)
from elastocal.elastic.springs import joint_springs
from elastocal.errors import InputError
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Tool, transform
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    Foot,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm
from tests.arms import random_chain, random_rotation

SIGMA = 1e-5
TOOL = Tool("tool", np.zeros(3), np.eye(3)[:2] * 0.1, ("A", "B"), rotation=True)
DRIFT = np.array([3e-7, -2e-7, 1e-7, 1e-7, 0.0, -5e-8])  # m/s, rad/s


def campaign(
    seed: int, blocks: int = 5, spots: int = 4, noise: float = 1.0, **station: object
) -> Positions:
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, [False, False, False])
    arm = TrueArm(
        robot,
        np.tile(np.eye(4), (4, 1, 1)),
        joint_springs(robot, ()),
        np.zeros(0),
        np.zeros(3),
    )
    T = transform(random_rotation(rng), [3.0, 0.0, 1.0])
    foot = Foot(0.5 * rng.normal(size=(spots, 3)), blocks)
    stands = (TrueStation(T, **station),)  # type: ignore[arg-type]
    truth = AbsoluteTruth(arm, TOOL.markers[None], stands, foot=foot)
    visits = Visits(rng.uniform(-1.0, 1.0, (30, 3)))
    return simulated_positions(
        truth, TOOL, visits, rng, covariance=alike(SIGMA), turned=1e-4, noise=noise
    )


def bump(seed: int) -> tuple[int, Array]:
    """After which reading, and a shift of ten times the noise, any way."""
    rng = np.random.default_rng(seed + 10_000)
    way = rng.normal(size=3)
    return int(rng.integers(5, 85)), np.append(10.0 * SIGMA * way / np.linalg.norm(way), [0, 0, 0])


def test_of_a_hundred_knocks_of_ten_times_the_noise_all_but_one_are_found() -> None:
    right = 0
    for seed in range(100):
        after, way = bump(seed)
        (found,) = station_motions(campaign(seed, bumped_after=after, bump=way))
        before, behind = found.between
        right += found.verdict == KNOCKED and (found.order[before] <= after <= found.order[behind])
    assert right >= 99


def test_of_a_hundred_stations_that_stand_still_one_at_most_is_said_not_to() -> None:
    verdicts = [station_motions(campaign(seed))[0].verdict for seed in range(100)]
    assert verdicts.count(STILL) >= 99


def test_a_drift_is_a_drift_and_is_taken_off() -> None:
    """Readings come back to where they were in the first block, within what is left open."""
    off, over = [], []
    for seed in range(20):
        still = campaign(seed, noise=0.0)
        read = campaign(seed, drift=DRIFT)
        (found,) = station_motions(read)
        assert found.verdict == DRIFTING
        steady = steadied(read, (found,))
        assert steady.doubts[-1].code == "tracker-drifted"
        points = ~read.rotations
        before = read.value - still.value
        assert np.abs(before[points]).max() > 1e-4
        error = (steady.value - still.value)[points]
        off.append(error)
        over.append(
            np.einsum("rc,rcd,rd->r", error, np.linalg.inv(steady.covariance[points]), error)
        )
        turns = from_rotation_vectors(steady.value[~points])
        turns = turns @ from_rotation_vectors(still.value[~points]).transpose(0, 2, 1)
        assert np.abs(turns - np.eye(3)).max() < 1e-3
    # Where the first block of all is, is as uncertain as that block: so it is for any frame.
    assert np.sqrt(np.mean(np.square(off))) < 3.0 * SIGMA
    assert 0.5 < np.mean(over) / 3.0 < 1.5


def test_a_knock_is_refused_where_it_was() -> None:
    way = np.array([2.1e-4, 0.0, 0.0, 0.0, 0.0, 0.0])
    read = campaign(3, bumped_after=40, bump=way)
    (found,) = station_motions(read)
    with pytest.raises(InputError, match=r"moved by 0.2\d mm between readings 21 and 46") as said:
        steadied(read, (found,))
    assert str(said.value) == knock_sentence(read, found)
    assert "make it two stations" in str(said.value)


def test_a_station_that_stands_still_is_left_alone() -> None:
    read = campaign(1)
    found = station_motions(read)
    assert found[0].verdict == STILL
    assert np.array_equal(steadied(read, found).value, read.value)


def test_two_reflectors_or_one_block_say_nothing() -> None:
    assert station_motions(campaign(1, spots=2)) == ()
    assert station_motions(campaign(1, blocks=1)) == ()
    assert station_motions(replace(campaign(1), foot=None)) == ()


def test_a_reflector_that_a_later_block_lacks_is_no_matter() -> None:
    read = campaign(5, drift=DRIFT)
    foot = read.foot
    assert foot is not None
    keep = ~((foot.reflector == 1) & (foot.order > 0))
    fewer = replace(
        foot,
        **{
            name: getattr(foot, name)[keep]
            for name in ("reflector", "station", "position", "covariance", "order", "time")
        },
    )
    (whole,), (found,) = station_motions(read), station_motions(replace(read, foot=fewer))
    assert found.verdict == DRIFTING
    assert found.motion == pytest.approx(whole.motion, abs=8 * SIGMA)


def test_without_times_the_order_counts() -> None:
    read = campaign(6, drift=DRIFT)
    (found,) = station_motions(replace(read, time=np.full(len(read), np.nan)))
    assert not found.timed
    assert found.verdict == DRIFTING
    assert found.when.tolist() == found.order.tolist()


def test_noise_twice_as_promised_is_no_motion() -> None:
    verdicts = [station_motions(campaign(s, noise=2.0))[0].verdict for s in range(60)]
    assert verdicts.count(STILL) >= 58
