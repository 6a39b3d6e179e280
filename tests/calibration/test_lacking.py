"""What a calibration lacks, of true arms whose errors are made by moving frames."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.doubts import doubts
from elastocal.calibration.lacking import lacking
from elastocal.calibration.parameters import parameters_of
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.robot.chain import transform
from elastocal.robot.geometry import GROUPS, geometric_errors
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm, drawn_displacements
from elastocal.wording import worded
from tests.simulation.test_absolute_planted import GRAVITY, LOAD, PLANTED, ROBOT, TOOL
from tests.simulation.test_absolute_planted import moved as displaced_by

SOFT = {"A2": 3e-7, "A3": 4e-7, "A4": 3e-6, "A5": 3e-6}


def calibrated(
    frames: Array, springs: tuple[str, ...], groups: tuple[str, ...] = GROUPS, seed: int = 0
) -> Calibration:
    """Sixty poses of an arm with all springs, fitted with some springs and groups of errors."""
    rng = np.random.default_rng(seed)
    true = joint_springs(ROBOT, tuple(SOFT))
    arm = TrueArm(ROBOT, frames, true, np.array(list(SOFT.values())), GRAVITY, (LOAD,))
    T = transform(from_rotation_vectors(np.array([[0.1, 0.2, 2.0]]))[0], [3.0, 1.0, -1.0])
    truth = AbsoluteTruth(arm, TOOL.markers[None], (TrueStation(T),))
    low, high = np.maximum(0.8 * ROBOT.lower, -2.5), np.minimum(0.8 * ROBOT.upper, 2.5)
    visits = Visits(rng.uniform(low, high, (60, 6)), payload=np.arange(60) % 2 - 1)
    read = simulated_positions(truth, TOOL, visits, rng, covariance=alike(2e-5))
    own = each_spring(joint_springs(ROBOT, springs))
    model = ArmModel(ROBOT, TOOL, geometric_errors(ROBOT, groups), own, GRAVITY, (LOAD,))
    return calibrate(model, read, parameters_of(model, read))


def off(seed: int) -> Array:
    return drawn_displacements(ROBOT, 3e-4, 3e-4, np.random.default_rng(seed))


@pytest.mark.parametrize("joint", ["A4", "A5"])
def test_a_spring_that_was_not_sought_is_named_with_its_size(joint: str) -> None:
    made = calibrated(off(1), tuple(name for name in SOFT if name != joint))
    lack = lacking(made)
    assert lack is not None
    assert joint in (lack.name, *lack.alike)
    assert lack.value == pytest.approx(SOFT[joint], rel=0.3)
    said = [worded(doubt) for doubt in doubts(made) if doubt.code == "calibration-lacks"]
    assert len(said) == 1
    assert f"a spring in {joint}" in said[0]
    assert f"add '{joint}' to what is identified" in said[0]


@pytest.mark.parametrize("name", ["alpha A2", "beta A2"])
def test_a_geometric_error_that_was_not_sought_is_named(name: str) -> None:
    frame, kind, along, size = PLANTED[name]
    frames = np.tile(np.eye(4), (7, 1, 1))
    frames[frame] = displaced_by(kind, along, size)
    made = calibrated(frames, tuple(SOFT), ("zeros", "lengths"))
    lack = lacking(made)
    assert lack is not None
    assert name in (lack.name, *lack.alike)
    assert abs(lack.value) == pytest.approx(size, rel=0.1)
    (said,) = (worded(doubt) for doubt in doubts(made) if doubt.code == "calibration-lacks")
    assert "add 'angles' to what is identified" in said


def test_nothing_is_lacking_where_all_is_sought() -> None:
    for seed in range(3):
        assert lacking(calibrated(off(seed), tuple(SOFT), seed=seed)) is None
