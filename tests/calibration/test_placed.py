"""Points of the tool on a calibrated robot: where they are, and how all unknowns move them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.arrays import Array
from elastocal.calibration.arm_model import loaded_arm, stepped
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.calibration.parameters import step_of
from elastocal.calibration.placed import TCP, Carried, carried_point, placed
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.robot.chain import Tool, moved
from elastocal.robot.rotations import from_rotation_vectors
from tests.calibration.random_calibrated import TOOL, calibrated_as

KR270 = ec.load_robot("kuka-kr270")
RNG = np.random.default_rng
CASES = LoadCases(RNG(1).uniform(-1.0, 1.0, (5, 6)), RNG(2).normal(size=(5, 6)) * 100.0)


def robot_with(tool: Tool = TOOL, seed: int = 3) -> CalibratedRobot:
    return calibrated_as(RNG(seed), KR270, tool=tool)


def by_hand(calibrated: CalibratedRobot, point: Array, cases: LoadCases) -> Array:
    """(N, 3) the point by plain products through the chain with its springs bent."""
    arm = loaded_arm(calibrated.model, calibrated.state, calibrated.robot, 0)
    rest = equilibrium(arm, calibrated.model.compliances.make @ calibrated.state.compliance, cases)
    found = []
    for joints in arm.bent(cases.q, rest.displacement):
        T = np.eye(4)
        for joint, value in zip(arm.chain.joints, joints, strict=True):
            T = T @ joint.T_parent_joint @ moved(joint, value)
        found.append((T @ arm.chain.T_tip_flange @ np.append(point, 1.0))[:3])
    return np.array(found)


def seen(calibrated: CalibratedRobot, cases: LoadCases, name: str) -> Array:
    """(N, 3) the point in the frame of the station."""
    carried = carried_point(calibrated, name=name)
    base = calibrated.state.base[0]
    return by_hand(calibrated, carried.point, cases) @ base[:3, :3].T + base[:3, 3]


@pytest.mark.parametrize("name", [TCP, "R2"])
def test_a_point_is_where_the_chain_has_it(name: str) -> None:
    calibrated = robot_with()
    carried = carried_point(calibrated, name=name)
    found = placed(calibrated, CASES, carried, payload=0)
    assert np.abs(found.point - by_hand(calibrated, carried.point, CASES)).max() < 1e-11


@pytest.mark.parametrize("name", [TCP, "R2"])
def test_rows_are_differences(name: str) -> None:
    """Of every unknown, as the station sees the point."""
    calibrated, size = robot_with(), 1e-6
    rows = placed(calibrated, CASES, carried_point(calibrated, name=name), payload=0).rows
    turn = calibrated.state.base[0, :3, :3]
    for u in range(len(calibrated.parameters)):
        values = np.zeros(len(calibrated.parameters))
        small = size * (1e-3 if calibrated.parameters.block[u] == "compliance" else 1.0)
        values[u] = small
        ahead, back = (
            replace(
                calibrated,
                state=stepped(
                    calibrated.state, step_of(calibrated.parameters, calibrated.state, way * values)
                ),
            )
            for way in (1.0, -1.0)
        )
        slope = (seen(ahead, CASES, name) - seen(back, CASES, name)) / (2.0 * small)
        off = np.abs(slope - rows[..., u] @ turn.T).max()
        # Carried by reflectors, to the millimetre in a decimetre by which they fit their drawing.
        rough = name == TCP and calibrated.parameters.block[u] == "tool"
        most = (2e-2 if rough else 1e-4) * (1.0 + np.abs(slope).max())
        assert off < most, calibrated.parameters.names[u]


def test_a_tcp_moves_along_with_three_reflectors() -> None:
    """Mounted by a turn and a shift, and read without error: so is the TCP."""
    calibrated = robot_with()
    turn, shift = from_rotation_vectors(np.array([[0.01, -0.02, 0.03]]))[0], [1e-3, 2e-3, -3e-3]
    markers = (TOOL.markers @ turn.T + shift)[None]
    calibrated = replace(calibrated, state=replace(calibrated.state, markers=markers))
    carried = carried_point(calibrated)
    assert carried.measured
    assert carried.point == pytest.approx(turn @ TOOL.tcp + shift, abs=1e-12)
    assert carried.rotation == pytest.approx(turn, abs=1e-12)


def test_a_tcp_that_is_a_reflector_is_where_that_is() -> None:
    calibrated = robot_with(replace(TOOL, tcp=TOOL.markers[1]))
    carried = carried_point(calibrated)
    assert np.array_equal(carried.point, calibrated.state.markers[0, 1])
    assert carried.measured


def test_a_tcp_that_nothing_carries_is_said_to_be() -> None:
    calibrated = robot_with(replace(TOOL, markers=TOOL.markers[:1], marker_names=("R1",)))
    carried = carried_point(calibrated)
    assert not carried.measured
    assert np.array_equal(carried.point, TOOL.tcp)
    assert not carried.slope.any()
    assert isinstance(carried, Carried)


def test_what_was_not_read_is_named() -> None:
    with pytest.raises(InputError, match="no reflector 'R9' was read; there are R1, R2, R3, TCP"):
        carried_point(robot_with(), name="R9")
