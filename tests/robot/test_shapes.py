"""Masses and shapes: data on bodies, and where they are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from elastocal.errors import InputError
from elastocal.robot.chain import Robot, T_body_joint
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import BodyMass, Shape
from elastocal.robot.sources import kuka_kr270
from tests.arms import Oracle, random_chain


@pytest.mark.parametrize("seed", range(5))
def test_points_in_joint_frames_are_where_pinocchio_has_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, [False, True, False, False])
    oracle = Oracle(robot)
    q, point = rng.normal(size=4), rng.normal(size=3)
    data = oracle.model.createData()
    pin.forwardKinematics(oracle.model, data, q)
    posture = Posture(robot, q[None])
    for body in range(5):
        local = (T_body_joint(robot, body) @ np.append(point, 1.0))[:3]
        assert posture.point(local, body)[:, 0] == pytest.approx(
            data.oMi[body].act(point), abs=1e-13
        )


def test_arrays_of_masses_and_shapes_are_read_only() -> None:
    mass, shape = BodyMass(1, 2.0, np.ones(3)), Shape("sphere", np.array([0.1]), np.eye(4), 1)
    for array in (mass.center, shape.size, shape.pose):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


@pytest.mark.parametrize(
    ("kind", "size", "pose", "message"),
    [
        ("cone", [1, 1], np.eye(4), "'arm': kind 'cone' is not known; expected one of box, cyl"),
        ("box", [1, 1], np.eye(4), "'arm': a box needs 3 finite numbers"),
        ("sphere", [np.nan], np.eye(4), "'arm': a sphere needs 1 finite numbers"),
        ("cylinder", [0.1, -1], np.eye(4), "the numbers of a cylinder must be positive, found 0.1"),
        ("sphere", [0.1], np.eye(3), "'arm': its pose must be a finite 4x4 matrix"),
    ],
)
def test_a_wrong_shape_is_refused(
    kind: str, size: list[float], pose: np.ndarray, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Shape(kind, np.array(size), pose, 1, "arm")


def test_a_wrong_mass_is_refused() -> None:
    with pytest.raises(InputError, match="mass of 'arm': expected kg from 0, found -1"):
        BodyMass(1, -1.0, np.zeros(3), "arm")
    with pytest.raises(InputError, match="centre of mass of 'arm': expected three finite"):
        BodyMass(1, 1.0, np.array([0.0, np.inf, 0.0]), "arm")


def test_a_body_that_is_not_there_is_refused() -> None:
    robot: Robot = kuka_kr270()
    with pytest.raises(InputError, match="'tip' belongs to body 7, but the bodies are 0 to 6"):
        replace(robot, masses=(BodyMass(7, 1.0, np.zeros(3), "tip"),))
