"""The start from nothing: right for any base and reflector, or refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.calibration.beginning import begin
from elastocal.calibration.parameters import parameters_of
from elastocal.calibration.prediction import predicted
from elastocal.calibration.start import placed
from elastocal.errors import InputError
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.rotations import from_rotation_vectors
from tests.arms import random_chain
from tests.calibration.random_campaign import random_model, random_positions, random_state


@pytest.mark.parametrize("seed", range(20))
def test_base_and_reflector_are_found_from_nothing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, [False] * 6)
    flange = forward_kinematics(robot, rng.uniform(-1.5, 1.5, (30, 6)))
    turn, shift, point = (
        from_rotation_vectors(3 * rng.normal(size=(1, 3)))[0],
        rng.normal(size=3),
        rng.normal(size=3),
    )
    seen = (flange[:, :3, :3] @ point + flange[:, :3, 3]) @ turn.T + shift
    T, found, left = placed(flange, seen + 1e-4 * rng.normal(size=seen.shape))
    assert left < 3e-4
    assert T[:3, :3] == pytest.approx(turn, abs=2e-3)
    assert found == pytest.approx(point, abs=2e-3)


def test_several_stations_and_mountings_begin_where_they_are() -> None:
    rng = np.random.default_rng(5)
    model = random_model(rng, [False] * 6)
    model = replace(model, gravity=np.zeros(3))
    positions, truth = random_positions(rng, model, 60), random_state(rng, model, 0.0)
    positions = replace(positions, cases=replace(positions.cases, wrench=np.zeros((60, 6))))
    parameters = parameters_of(model, positions)
    error = predicted(model, positions, parameters, truth).error
    value = positions.value - error
    turned = positions.rotations
    value[turned] = positions.value[turned]
    there = replace(positions, value=value)
    # What was read of rotations is what the truth says.
    seen = from_rotation_vectors(positions.value[turned])
    back = from_rotation_vectors(-error[turned]) @ seen
    from elastocal.robot.rotations import rotation_vectors

    value[turned] = rotation_vectors(back)
    there = replace(positions, value=value)
    found = predicted(model, there, parameters, begin(model, there)).error
    assert np.abs(found).max() < 1e-8


def test_joints_that_do_not_belong_to_the_positions_are_refused() -> None:
    rng = np.random.default_rng(6)
    model = random_model(rng, [False] * 6)
    positions = random_positions(rng, model, 60)
    with pytest.raises(InputError, match="do not belong together"):
        begin(model, positions)


def test_too_few_poses_are_refused() -> None:
    rng = np.random.default_rng(6)
    model = random_model(rng, [False] * 6)
    with pytest.raises(InputError, match="too few"):
        begin(model, random_positions(rng, model, 4))
