"""The noise of readings, in what reflectors of a pose share and what each has by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.calibrate import calibrate
from elastocal.calibration.parameters import parameters_of
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.robot.chain import Tool, transform
from elastocal.robot.geometry import geometric_errors
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm
from tests.arms import random_chain

TOOL = Tool("tool", np.zeros(3), np.eye(3) * 0.2, ("A", "B", "C"))
SIGMA, SHARED, OWN = 2e-5, 4e-5, 3e-5


def test_both_parts_are_found_though_the_fit_takes_of_the_shared_one() -> None:
    """Twenty unknowns or so of thirty poses: a quarter of what poses have in common."""
    robot = random_chain(np.random.default_rng(0), [False] * 4)
    rigid = joint_springs(robot, ())
    arm = TrueArm(robot, np.tile(np.eye(4), (5, 1, 1)), rigid, np.zeros(0), np.zeros(3))
    truth = AbsoluteTruth(arm, TOOL.markers[None], (TrueStation(transform(None, [3, 0, 1])),))
    model = ArmModel(robot, TOOL, geometric_errors(robot), each_spring(rigid), np.zeros(3))
    found = []
    for seed in range(30):
        rng = np.random.default_rng(seed)
        visits = Visits(rng.uniform(-1.5, 1.5, (30, 4)))
        read = simulated_positions(truth, TOOL, visits, rng, covariance=alike(SIGMA))
        more = SHARED * rng.normal(size=(30, 3))[read.case]
        more = more + OWN * rng.normal(size=read.value.shape)
        read = replace(read, value=read.value + more)
        noise = calibrate(model, read, parameters_of(model, read)).noise
        found.append([noise.shared[0] ** 2, noise.own[0] ** 2])
    shared, own = np.mean(found, axis=0)
    assert shared == pytest.approx(SHARED**2, rel=0.12)
    assert own == pytest.approx(OWN**2, rel=0.06)
