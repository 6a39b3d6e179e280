"""Absolute campaigns: what is read, and what goes wrong in them, where it should."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.springs import joint_springs
from elastocal.errors import InputError
from elastocal.robot.chain import Tool, transform
from elastocal.robot.payloads import Payload
from elastocal.robot.posture import forward_kinematics
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
from elastocal.simulation.virtual_campaign import Outliers
from tests.arms import random_chain, random_rotation

SIGMA = 1e-5
TOOL = Tool("tool", np.zeros(3), np.eye(3)[:2] * 0.1, ("A", "B"), rotation=True)
FOOT = Foot(np.array([[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [-0.4, -0.3, 0.1]]), 4)


def cell(rng: np.random.Generator, **station: object) -> AbsoluteTruth:
    robot = random_chain(rng, [False, True, False])
    load = Payload("weight", 3.0, np.zeros(3))
    arm = TrueArm(
        robot,
        np.tile(np.eye(4), (4, 1, 1)),
        joint_springs(robot),
        np.full(3, 1e-5),
        np.array([0.0, 0.0, -9.8]),
        (load,),
    )
    T = transform(random_rotation(rng), [3.0, 0.0, 1.0])
    return AbsoluteTruth(arm, TOOL.markers[None], (TrueStation(T, **station),), foot=FOOT)  # type: ignore[arg-type]


def visits(rng: np.random.Generator, count: int = 20) -> Visits:
    return Visits(rng.uniform(-1.0, 1.0, (count, 3)))


def test_a_rigid_arm_is_read_where_it_is() -> None:
    rng = np.random.default_rng(0)
    truth = cell(rng)
    poses = visits(rng)
    read = simulated_positions(truth, TOOL, poses, rng, covariance=alike(SIGMA), noise=0.0)
    base = truth.stations[0].T_station_base
    flange = base @ forward_kinematics(truth.arm.robot, poses.q)
    for r in range(len(read)):
        frame = flange[read.case[r]]
        if read.marker[r] == 2:
            turn = from_rotation_vectors(read.value[[r]])[0]
            assert turn == pytest.approx(frame[:3, :3], abs=1e-12)
        else:
            point = frame @ np.append(TOOL.markers[read.marker[r]], 1.0)
            assert read.value[r] == pytest.approx(point[:3], abs=1e-12)
    assert len(read) == 60


def test_a_weight_pulls_the_arm_down() -> None:
    rng = np.random.default_rng(1)
    truth, poses = cell(rng), visits(rng)
    made = {"covariance": alike(SIGMA), "noise": 0.0}
    without = simulated_positions(truth, TOOL, poses, rng, **made)  # type: ignore[arg-type]
    hung = replace(poses, payload=np.zeros(20))
    loaded = simulated_positions(truth, TOOL, hung, rng, **made)  # type: ignore[arg-type]
    down = (loaded.value - without.value) @ truth.stations[0].T_station_base[:3, 2]
    points = ~loaded.rotations
    assert down[points].mean() < -1e-5


def test_noise_is_as_large_as_is_said_times_a_factor() -> None:
    rng = np.random.default_rng(2)
    truth, poses = cell(rng), visits(rng, 400)
    calm = simulated_positions(truth, TOOL, poses, rng, covariance=alike(SIGMA), noise=0.0)
    read = simulated_positions(
        truth, TOOL, poses, rng, covariance=alike(SIGMA), turned=1e-4, noise=3.0
    )
    points = ~read.rotations
    assert (read.value - calm.value)[points].std() == pytest.approx(3.0 * SIGMA, rel=0.05)
    turns = from_rotation_vectors(read.value) @ from_rotation_vectors(calm.value).transpose(0, 2, 1)
    angle = np.arccos(np.clip((np.trace(turns[~points], axis1=1, axis2=2) - 1) / 2, -1, 1))
    assert np.sqrt((angle**2).mean() / 3) == pytest.approx(3e-4, rel=0.05)
    assert read.covariance[points][0] == pytest.approx(SIGMA**2 * np.eye(3))


def test_a_station_drifts_and_is_knocked() -> None:
    rng = np.random.default_rng(3)
    drift = np.array([1e-6, 0.0, 0.0, 0.0, 0.0, 0.0])
    bump = np.array([0.0, 2e-4, 0.0, 0.0, 0.0, 0.0])
    quiet, poses = cell(np.random.default_rng(3)), visits(rng)
    moves = cell(np.random.default_rng(3), drift=drift, bumped_after=30, bump=bump)
    made = {"covariance": alike(SIGMA), "noise": 0.0, "seconds": 2.0}
    still, moving = (
        simulated_positions(truth, TOOL, poses, rng, **made)  # type: ignore[arg-type]
        for truth in (quiet, moves)
    )
    points = ~moving.rotations
    way = moving.value - still.value
    assert way[points, 0] == pytest.approx(1e-6 * moving.time[points], abs=1e-12)
    after = np.arange(len(moving)) >= 30
    assert way[points, 1] == pytest.approx(np.where(after, 2e-4, 0.0)[points], abs=1e-12)
    foot, before = moving.foot, still.foot
    assert foot is not None
    assert before is not None
    assert len(foot) == 12
    assert foot.order.tolist() == np.repeat([0, 18, 39, 60], 3).tolist()
    way = foot.position - before.position
    assert way[:, 0] == pytest.approx(1e-6 * foot.time, abs=1e-12)
    assert way[:, 1] == pytest.approx(np.where(foot.order >= 30, 2e-4, 0.0), abs=1e-12)
    assert np.diff(np.sort(np.concatenate([moving.time, foot.time]))) == pytest.approx(2.0)


def test_rows_are_wrong_and_missing_at_random() -> None:
    rng = np.random.default_rng(4)
    truth, poses = cell(rng), visits(rng, 300)
    made = {"covariance": alike(SIGMA), "noise": 0.0}
    right = simulated_positions(truth, TOOL, poses, rng, **made)  # type: ignore[arg-type]
    wrong = simulated_positions(
        truth,
        TOOL,
        poses,
        rng,
        outliers=Outliers(0.1, 5e-3),
        **made,  # type: ignore[arg-type]
    )
    off = np.linalg.norm(wrong.value - right.value, axis=1)
    assert set(np.round(off, 9)) == {0.0, 5e-3}
    assert (off > 0.0).mean() == pytest.approx(0.1 * 2 / 3, rel=0.4)
    few = simulated_positions(truth, TOOL, poses, rng, skipped=0.3, **made)  # type: ignore[arg-type]
    assert len(few) == pytest.approx(630, abs=60)


def test_the_same_seed_makes_the_same_campaign() -> None:
    truth, poses = cell(np.random.default_rng(5)), visits(np.random.default_rng(5))
    one, other = (
        simulated_positions(truth, TOOL, poses, np.random.default_rng(7), covariance=alike(SIGMA))
        for _ in range(2)
    )
    assert np.array_equal(one.value, other.value)


def test_a_foot_is_read_once_at_least() -> None:
    with pytest.raises(InputError, match="at least once"):
        Foot(np.zeros((3, 3)), 0)
