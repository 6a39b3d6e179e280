"""Geometry is taken as calibrated: what an error in it leaves at the test pose.

The robot that is loaded and the one that mills have the same wrong zeros and lengths; the program
knows of neither. Its deflections are those of the exact equilibrium of the wrong robot.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.identification.identify import identify
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import Robot
from elastocal.robot.rotations import from_rotation_vectors
from tests.kr270 import kr270_study, kr270_truth

STUDY = kr270_study()
TRUTH = kr270_truth(STUDY)
(POSE,) = STUDY.test_poses
ARM = replace(STUDY.arm, springs=joint_springs(STUDY.robot))
assert POSE.case is not None
assert POSE.tool is not None
TASK, CASE = replace(ARM, tool=POSE.tool.at_tcp), POSE.case
# The plan of the README; degrees are enough.
Q = np.radians(
    [
        [0.0, -1.69, -3.80, -58.25, 39.54, 168.82],
        [0.0, -50.79, 63.06, -32.56, 101.66, -93.79],
        [0.0, -55.46, -72.40, -119.39, -56.59, -179.27],
    ]
)
CASES = LoadCases(np.repeat(Q, [2, 7, 3], axis=0), np.tile([0.0, 0, -2500, 0, 0, 0], (12, 1)))


def wrong(robot: Robot, zero: float, length: float, rng: np.random.Generator) -> Robot:
    """The robot with errors of its joint zeros [rad] and of its lengths [m], normal, alike."""
    joints = []
    for joint in robot.joints:
        T = np.array(joint.T_parent_joint)
        T[:3, :3] = T[:3, :3] @ from_rotation_vectors(zero * rng.normal() * joint.axis[None])[0]
        T[:3, 3] += length * rng.normal(size=3)
        joints.append(replace(joint, T_parent_joint=T))
    return replace(robot, joints=tuple(joints))


def left(zero: float, length: float, draws: int = 60) -> tuple[float, float]:
    """RMS over robots: error at the test pose, and largest change of a deflection [µm]."""
    rng = np.random.default_rng(0)
    right = loaded_deflection(ARM, TRUTH.compliance, CASES)
    errors, changes = [], []
    for _ in range(draws):
        robot = wrong(STUDY.robot, zero, length, rng)
        deflection = loaded_deflection(replace(ARM, robot=robot), TRUTH.compliance, CASES)
        changes.append(np.linalg.norm(deflection - right, axis=1).max())
        found = np.array(TRUTH.compliance)
        found[1:] = identify(STUDY.arm, read(deflection), known=TRUTH).compliance
        real = loaded_deflection(replace(TASK, robot=robot), TRUTH.compliance, CASE)
        errors.append(np.linalg.norm(real - loaded_deflection(TASK, found, CASE)))
    return tuple(1e6 * float(np.sqrt(np.mean(np.square(v)))) for v in (errors, changes))  # type: ignore[return-value]


def read(deflection: Array) -> Measurements:
    """Readings without noise."""
    numbers = np.arange(len(CASES))
    covariance = np.broadcast_to(STUDY.sigma**2 * np.eye(3), (len(CASES), 3, 3))
    names = tuple(map(str, numbers))
    return Measurements(ARM.tool, CASES, names, numbers, 0 * numbers, deflection, covariance)


def test_errors_of_geometry_are_as_large_as_noise() -> None:
    """docs/how-to-choose.md: 0.1° of every zero or 1 mm of every length; noise leaves 2.8 µm."""
    size = np.linalg.norm(loaded_deflection(ARM, TRUTH.compliance, CASES), axis=1)
    assert (size.min(), size.max()) == pytest.approx((5.2e-3, 13.4e-3), rel=0.01)
    zeros, moved = left(np.radians(0.1), 0.0)
    assert (zeros, moved) == pytest.approx((2.7, 31), rel=0.15)
    lengths, moved = left(0.0, 1e-3)
    assert (lengths, moved) == pytest.approx((2.9, 25), rel=0.15)
    assert left(np.radians(0.02), 0.2e-3)[0] == pytest.approx(0.76, rel=0.15)


def test_what_it_leaves_is_in_proportion_to_the_error() -> None:
    once, twice = (left(np.radians(angle), angle * 1e-3, 10)[0] for angle in (0.05, 0.1))
    assert twice / once == pytest.approx(2.0, rel=0.02)
    assert left(0.0, 0.0, 1)[0] < 1e-3  # the negative control: without error nothing is left
