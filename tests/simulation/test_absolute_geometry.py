"""Geometric errors of the model make every arm whose frames are displaced, sliding ones too."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.calibrate import calibrate
from elastocal.calibration.parameters import parameters_of
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.robot.chain import Robot, Tool, transform
from elastocal.robot.geometry import geometric_errors
from elastocal.robot.sources import DHRow, from_dh
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm, drawn_displacements

NO_WEIGHT = np.array([0.0, 0.0, -9.80665])
TOOL = Tool("tool", np.zeros(3), np.array([[0.1, 0.05, 0.0], [0.0, 0.08, 0.1]]), ("R1", "R2"))
HALF = np.pi / 2


def arm(*rows: tuple[float, float, float, float, bool]) -> Robot:
    """From rows theta, d, a, alpha, whether it slides."""
    named = [
        DHRow(f"J{i + 1}", theta, d, a, alpha, slides, 1.0, 0.2 if slides else -2.0, 1.5)
        for i, (theta, d, a, alpha, slides) in enumerate(rows)
    ]
    return from_dh("arm", named, modified=False)


ARMS = {
    "the arm of Stanford": arm(
        (0.0, 0.4, 0.0, -HALF, False),
        (0.0, 0.15, 0.0, HALF, False),
        (-HALF, 0.0, 0.0, 0.0, True),
        (0.0, 0.0, 0.0, -HALF, False),
        (0.0, 0.0, 0.0, HALF, False),
        (0.0, 0.2, 0.0, 0.0, False),
    ),
    "a SCARA": arm(
        (0.0, 0.4, 0.3, 0.0, False),
        (0.0, 0.1, 0.25, 0.0, False),
        (0.0, 0.0, 0.0, 0.0, True),
        (0.0, 0.1, 0.0, 0.0, False),
    ),
    "a turn on a rail": arm(
        (0.0, 0.0, 0.0, HALF, True),
        (0.0, 0.3, 0.1, HALF, False),
        (0.0, 0.0, 0.5, 0.0, False),
        (0.0, 0.1, 0.3, HALF, False),
    ),
    "three rails": arm(
        (0.0, 0.0, 0.0, HALF, True),
        (HALF, 0.0, 0.0, HALF, True),
        (0.0, 0.0, 0.0, 0.0, True),
        (0.0, 0.2, 0.1, HALF, False),
        (0.0, 0.1, 0.0, 0.0, False),
    ),
}


@pytest.mark.parametrize("name", ARMS)
def test_frames_displaced_anyhow_are_fitted_to_a_micrometre(name: str) -> None:
    """Shifts and turns of .3 mm and .3 mrad of every frame, without noise."""
    robot, rng = ARMS[name], np.random.default_rng(0)
    rigid = joint_springs(robot, ())
    true = TrueArm(
        robot, drawn_displacements(robot, 3e-4, 3e-4, rng), rigid, np.zeros(0), NO_WEIGHT
    )
    truth = AbsoluteTruth(true, TOOL.markers[None], (TrueStation(transform(None, [1, 2, 3])),))
    visits = Visits(rng.uniform(robot.lower, robot.upper, (80, len(robot.joints))))
    read = simulated_positions(truth, TOOL, visits, rng, covariance=alike(1e-6), noise=0.0)
    model = ArmModel(robot, TOOL, geometric_errors(robot), each_spring(rigid), NO_WEIGHT)
    found = calibrate(model, read, parameters_of(model, read))
    assert np.linalg.norm(found.error, axis=1).max() < 1e-6
