"""Errors planted alone in a true arm, by moving its frames: the calibration finds them alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.parameters import parameters_of
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.robot.chain import Tool, transform
from elastocal.robot.compensators import Compensator
from elastocal.robot.geometry import geometric_errors
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.robot.shapes import BodyMass
from elastocal.robot.sources import kuka_kr270
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm, drawn_displacements
from elastocal.simulation.true_compensators import energy

GRAVITY = np.array([0.0, 0.0, -9.80665])
MASSES = (
    BodyMass(2, 250.0, np.array([0.0, 0.0, 0.6])),
    BodyMass(3, 200.0, np.array([0.0, 0.05, 0.2])),
)
ROBOT = replace(kuka_kr270(), masses=MASSES)
POINTS = np.array([[0.4, 0.1, 0.0], [0.3, -0.2, 0.1], [0.35, 0.0, 0.25]])
TOOL = Tool("tool", np.zeros(3), POINTS, ("R1", "R2", "R3"))
LOAD = Payload("weight", 200.0, np.array([0.3, 0.0, 0.1]))
SPRINGS = joint_springs(ROBOT, ("A2", "A3", "A4", "A5"))

# Where frames are moved, in the drawing's axes: all are parallel to the base. The frame of A2
# stands on the common normal of A1 and A2, that of A3 on one of A2 and A3.
X, Y, Z = np.eye(3)
PLANTED = {
    "zero A3": (2, "turn", Y, 1e-3),
    "d A4": (4, "shift", X, 4e-4),
    "a A1": (1, "shift", X, 4e-4),
    "alpha A1": (1, "turn", X, 1e-3),
    "a A2": (2, "shift", X, 4e-4),
    "alpha A2": (2, "turn", X, 1e-3),
    "beta A2": (2, "turn", Z, 1e-3),
    "alpha A4": (4, "turn", Z, 1e-3),
}


def moved(kind: str, along: Array, size: float) -> Array:
    if kind == "shift":
        return transform(None, size * along)
    return transform(from_rotation_vectors(size * along[None])[0])


def calibrated(
    displaced: Array,
    compliance: Array,
    seed: int,
    held: tuple[tuple[Compensator, float], ...] = (),
) -> Calibration:
    rng = np.random.default_rng(seed)
    arm = TrueArm(ROBOT, displaced, SPRINGS, compliance, GRAVITY, (LOAD,), held)
    T = transform(from_rotation_vectors(np.array([[0.1, 0.2, 2.0]]))[0], [3.0, 1.0, -1.0])
    truth = AbsoluteTruth(arm, TOOL.markers[None], (TrueStation(T),))
    low, high = np.maximum(0.8 * ROBOT.lower, -2.5), np.minimum(0.8 * ROBOT.upper, 2.5)
    visits = Visits(rng.uniform(low, high, (60, 6)), payload=np.arange(60) % 2 - 1)
    read = simulated_positions(truth, TOOL, visits, rng, covariance=alike(1e-5))
    springs, own = each_spring(SPRINGS), tuple(one for one, _ in held)
    model = ArmModel(ROBOT, TOOL, geometric_errors(ROBOT), springs, GRAVITY, (LOAD,), own)
    return calibrate(model, read, parameters_of(model, read))


def arm_of(found: Calibration) -> tuple[list[str], Array, Array]:
    """Names, values and standard errors of geometry and compliances."""
    first = found.parameters.arm
    state = found.state
    values = np.concatenate([state.geometry, state.compliance, state.compensator])
    return list(found.parameters.names[first:]), values, found.standard_error[first:]


@pytest.mark.parametrize("name", PLANTED)
def test_a_geometric_error_planted_alone_is_found_alone(name: str) -> None:
    frame, kind, along, size = PLANTED[name]
    displaced = np.tile(np.eye(4), (7, 1, 1))
    displaced[frame] = moved(kind, along, size)
    found = calibrated(displaced, np.zeros(4), 1)
    names, values, error = arm_of(found)
    at = names.index(name)
    assert found.redundancy.seen[found.parameters.arm + at]
    assert abs(values[at]) == pytest.approx(size, abs=4.5 * error[at])
    assert error[at] < 0.05 * size
    others = np.arange(len(names)) != at
    assert (np.abs(values[others]) < 4.5 * error[others]).all()


@pytest.mark.parametrize("joint", range(4))
def test_a_compliance_planted_alone_is_found_alone(joint: int) -> None:
    compliance = np.zeros(4)
    compliance[joint] = (3e-7, 4e-7, 3e-6, 3e-6)[joint]
    found = calibrated(np.tile(np.eye(4), (7, 1, 1)), compliance, 2)
    names, values, error = arm_of(found)
    expected = np.zeros(len(names))
    expected[-4:] = compliance
    assert (np.abs(values - expected) < 4.5 * error).all()
    assert error[len(names) - 4 + joint] < 0.05 * compliance[joint]


def test_a_compensator_is_found_beside_the_compliance_of_its_joint() -> None:
    """The spring stands on the arm as it is, bent and off; half of the weight is on it."""
    gas = Compensator("gas", 1, 0.25, 0.9, np.radians(20.0), 0.5)
    compliance, stiffness = np.array([3e-7, 4e-7, 3e-6, 3e-6]), 2e4
    rng = np.random.default_rng(4)
    moved = drawn_displacements(ROBOT, 3e-4, 3e-4, rng)
    found = calibrated(moved, compliance, 4, ((gas, stiffness),))
    names, values, error = arm_of(found)
    (product,) = found.state.compensator
    at = names.index("compensator gas")
    assert product == pytest.approx(compliance[0] * stiffness, abs=4.5 * error[at])
    assert error[at] < 0.1 * product
    soft = slice(names.index("A2"), names.index("A5") + 1)
    assert (np.abs(values[soft] - compliance) < 4.5 * error[soft]).all()


def test_energy_falls_by_the_moment_of_the_lever() -> None:
    gas = Compensator("gas", 0, 0.3, 0.8, 0.4, 0.35)
    q, step = np.linspace(-2.0, 2.0, 9), 1e-30
    slope = energy(gas, 5e3, q + 1j * step).imag / step
    assert -slope == pytest.approx(5e3 * gas.lever(q), rel=1e-12)
    turned = (gas.lever(q + 1e-6) - gas.lever(q - 1e-6)) / 2e-6
    assert gas.slope(q) == pytest.approx(turned, rel=1e-7)


def test_what_nothing_tells_is_not_said_to_be_seen() -> None:
    """Turns of the base and the zero of A1, the last zero and the tool, parallel axes."""
    found = calibrated(np.tile(np.eye(4), (7, 1, 1)), np.array([3e-7, 4e-7, 3e-6, 3e-6]), 3)
    seen = dict(zip(found.parameters.names, found.redundancy.seen.tolist(), strict=True))
    open_ = {"zero A1", "d A1", "d A2", "d A3", "zero A6"}
    open_ |= {f"base {turn}{axis}" for turn in ("", "turn ") for axis in "xyz"}
    assert not any(seen[name] for name in open_)
    assert all(seen[name] for name in (*PLANTED, "A2", "A3", "A4", "A5"))
    # What is not seen never has a small interval.
    arm = np.arange(found.parameters.arm, len(seen))
    unseen = arm[~found.redundancy.seen[arm]]
    assert (found.standard_error[unseen] > 5e-4).all()
