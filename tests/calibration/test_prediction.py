"""Predictions against kinematics put together by hand; their rows against differences."""

from __future__ import annotations

import numpy as np
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel, State, stepped
from elastocal.calibration.parameters import Parameters, parameters_of, step_of
from elastocal.calibration.prediction import predicted
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Joint, Robot, moved, transform
from elastocal.robot.geometry import small_transforms, with_errors
from elastocal.robot.rotations import from_rotation_vectors, rotation_vectors
from tests.calibration.random_campaign import random_model, random_positions, random_state

chains = st.tuples(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=6))
SIZE = 1e-6
ALL_AT_ONCE = (3, [False, True, False, False])


def difference(
    model: ArmModel, positions: Positions, parameters: Parameters, state: State, values: Array
) -> Array:
    """(R, 3) how predictions change along `values`, by differences."""
    ahead, back = (
        predicted(
            model, positions, parameters, stepped(state, step_of(parameters, state, way * values))
        )
        for way in (SIZE, -SIZE)
    )
    return (back.error - ahead.error) / (2.0 * SIZE)


def test_every_row_is_its_difference() -> None:
    rng = np.random.default_rng(ALL_AT_ONCE[0])
    model = random_model(rng, ALL_AT_ONCE[1])
    positions, state = random_positions(rng, model, 6), random_state(rng, model)
    parameters = parameters_of(model, positions)
    rows = predicted(model, positions, parameters, state).rows
    for u, unit in enumerate(np.eye(len(parameters))):
        slope = difference(model, positions, parameters, state, unit)
        assert np.abs(slope - rows[..., u]).max() < 2e-7 * (1.0 + np.abs(rows[..., u]).max())


@settings(max_examples=15, phases=[Phase.explicit, Phase.generate])
@given(chains)
def test_rows_of_any_arm_are_differences(chain: tuple[int, list[bool]]) -> None:
    rng = np.random.default_rng(chain[0])
    model = random_model(rng, chain[1])
    positions, state = random_positions(rng, model, 6), random_state(rng, model)
    parameters = parameters_of(model, positions)
    rows = predicted(model, positions, parameters, state).rows
    for blocks in (
        ("base", "tool", "probe"),
        ("zeros", "lengths", "angles"),
        ("compliance", "compensator"),
    ):
        values = np.zeros(len(parameters))
        mine = parameters.of(*blocks)
        values[mine] = rng.normal(size=len(mine))
        slope = difference(model, positions, parameters, state, values)
        assert np.abs(slope - rows @ values).max() < 1e-6 * (1.0 + np.abs(rows @ values).max())


def product(robot: Robot, q: Array, errors: Array) -> Array:
    """(4, 4) the flange of a chain as a plain product; a small transform behind every joint."""
    T = np.eye(4)
    for joint, value, change in zip(robot.joints, q, errors, strict=True):
        T = T @ joint.T_parent_joint @ moved(joint, value) @ change
    return T @ robot.T_tip_flange


@settings(max_examples=15)
@given(chains)
def test_errors_stand_behind_their_joints(chain: tuple[int, list[bool]]) -> None:
    """The flange of the robot with errors, as a product of all transforms."""
    rng = np.random.default_rng(chain[0])
    model = random_model(rng, chain[1])
    robot, values = model.robot, 0.3 * rng.normal(size=len(model.errors))
    small = small_transforms(model.errors, values, robot.last)[1:]
    q = rng.uniform(-2.0, 2.0, len(chain[1]))
    # The transforms are in frames whose z is the axis: seen from those of the joints.
    seen = [
        _in_joint(joint, S, robot, i)
        for i, (joint, S) in enumerate(zip(robot.joints, small, strict=True))
    ]
    expected = product(robot, q, np.array(seen))
    nothing = np.tile(np.eye(4), (len(q), 1, 1))
    assert product(with_errors(robot, model.errors, values), q, nothing) == _near(expected)


def _in_joint(joint: Joint, small: Array, robot: Robot, i: int) -> Array:
    """A small transform of a body's frame in the frame of its joint."""
    from elastocal.robot.chain import T_body_joint

    T = T_body_joint(robot, i + 1)
    return np.linalg.inv(T) @ small @ T


def _near(expected: Array) -> object:
    import pytest

    return pytest.approx(expected, abs=1e-12)


def test_readings_are_where_the_bent_arm_has_its_reflectors() -> None:
    """Through the chain with a joint for every spring, put together once more by hand."""
    rng = np.random.default_rng(8)
    model = random_model(rng, [False, True, False])
    positions, state = random_positions(rng, model, 6), random_state(rng, model)
    parameters = parameters_of(model, positions)
    found = positions.value - predicted(model, positions, parameters, state).error
    robot = with_errors(model.robot, model.errors, state.geometry)
    from elastocal.calibration.arm_model import loaded_arm

    for r in np.flatnonzero(~positions.rotations):
        pose = positions.case[r]
        arm: ElasticArm = loaded_arm(model, state, robot, int(positions.payload[pose]))
        case = LoadCases(positions.cases.q[[pose]], positions.cases.wrench[[pose]])
        rest = equilibrium(arm, model.compliances.make @ state.compliance, case)
        bent = arm.bent(case.q, rest.displacement)[0]
        flange = product(arm.chain, bent, np.tile(np.eye(4), (len(bent), 1, 1)))
        marker = state.markers[positions.mounting[pose], positions.marker[r]]
        point = state.base[positions.station[r]] @ flange @ np.append(marker, 1.0)
        assert found[r] == _near(point[:3])
    turned = np.flatnonzero(positions.rotations)[0]
    pose = positions.case[turned]
    arm = loaded_arm(model, state, robot, int(positions.payload[pose]))
    case = LoadCases(positions.cases.q[[pose]], positions.cases.wrench[[pose]])
    rest = equilibrium(arm, model.compliances.make @ state.compliance, case)
    bent = arm.bent(case.q, rest.displacement)[0]
    flange = product(arm.chain, bent, np.tile(np.eye(4), (len(bent), 1, 1)))
    axes = state.base[positions.station[turned], :3, :3] @ flange[:3, :3]
    axes = axes @ state.probe[positions.mounting[pose]]
    open_ = rotation_vectors((from_rotation_vectors(positions.value[[turned]])[0] @ axes.T)[None])[
        0
    ]
    error = predicted(model, positions, parameters, state).error[turned]
    assert error == _near(open_)
    assert transform().shape == (4, 4)
