"""What goes into a controller: bases with their errors, and what it leaves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.calibration.arm_model import stepped
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.calibration.for_controller import for_controller
from elastocal.calibration.parameters import step_of
from elastocal.robot.controller_axes import uncoupled
from elastocal.robot.rotations import rotation_vectors
from tests.calibration.random_calibrated import TOOL, calibrated_as

KR270 = ec.load_robot("kuka-kr270")
SHOWN = uncoupled(KR270)


def robot(seed: int = 1, **others: object) -> CalibratedRobot:
    return calibrated_as(np.random.default_rng(seed), KR270, **others)  # type: ignore[arg-type]


def test_errors_of_a_base_are_those_of_bases_drawn_by_chance() -> None:
    calibrated, rng = robot(), np.random.default_rng(2)
    own = np.arange(6)
    root = 1e-5 * rng.normal(size=(6, 6))
    covariance = np.array(calibrated.covariance)
    covariance[:6] = covariance[:, :6] = 0.0
    covariance[np.ix_(own, own)] = root @ root.T
    calibrated = replace(calibrated, covariance=covariance)
    (base,) = for_controller(calibrated, SHOWN).bases
    assert base.T_base_station == pytest.approx(np.linalg.inv(calibrated.state.base[0]), abs=1e-12)
    found = []
    for values in rng.normal(size=(2000, 6)) @ root.T:
        step = np.zeros(len(calibrated.parameters))
        step[own] = values
        state = stepped(calibrated.state, step_of(calibrated.parameters, calibrated.state, step))
        T = np.linalg.inv(state.base[0])
        turn = rotation_vectors((T[:3, :3] @ base.T_base_station[:3, :3].T)[None])[0]
        found.append([*(T[:3, 3] - base.T_base_station[:3, 3]), *turn])
    assert np.std(found, axis=0) == pytest.approx(base.errors, rel=0.1)


def test_zeros_alone_leave_nothing_where_nothing_else_errs() -> None:
    calibrated = robot()
    zeros = np.array([name.startswith("zero") for name in calibrated.model.errors.names])
    state = replace(
        calibrated.state,
        geometry=np.where(zeros, calibrated.state.geometry, 0.0),
        compliance=np.zeros(len(calibrated.model.compliances)),
    )
    left = for_controller(replace(calibrated, state=state), SHOWN).left
    assert left.zeros < 1e-12
    assert left.drawn > 1e-3
    left = for_controller(calibrated, SHOWN).left
    assert left.zeros > 1e-4


def test_a_tool_of_three_reflectors_has_a_frame() -> None:
    (tool,) = for_controller(robot(), SHOWN).tools
    assert [point.name for point in tool.points] == ["TCP", "R1", "R2", "R3"]
    assert tool.frame is not None
    assert tool.frame[:3, 3] == pytest.approx(tool.points[0].point)
    one = replace(TOOL, markers=TOOL.markers[:1], marker_names=("R1",))
    (tool,) = for_controller(robot(tool=one), SHOWN).tools
    assert tool.frame is None
    assert np.isnan(tool.errors[0]).all()
    assert np.isfinite(tool.errors[1]).all()
