"""Measured joint torques against slopes of the potential energy of all weights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.elastic.load_cases import LoadCases
from elastocal.measuring.joint_torques import TorqueCheck, torque_check
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.payloads import Payload
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import BodyMass
from elastocal.wording import worded
from tests.arms import random_chain

GRAVITY = np.array([0.4, -0.3, -9.7])
LOAD = Payload("weight", 6.0, np.array([0.1, -0.05, 0.2]))
COUNT = 24


def arm() -> Robot:
    rng = np.random.default_rng(1)
    slides = [False, False, True, False, False]
    masses = tuple(BodyMass(b, rng.uniform(3.0, 20.0), rng.normal(size=3)) for b in range(1, 6))
    return replace(random_chain(rng, slides), masses=masses)


def energy(robot: Robot, q: Array, load: Payload | None) -> Array:
    """(N,) potential energy [J]."""
    posture = Posture(robot, q)
    parts = [(m.mass, posture.point(m.center, m.body)) for m in robot.masses]
    if load is not None:
        parts.append((load.mass, posture.point(load.center)))
    return -sum(mass * (GRAVITY @ point) for mass, point in parts)


def read(robot: Robot, factor: float = 1.0, more: Payload | None = None) -> Positions:
    """Torques, factor times the loads, under a payload in every second pose, and `more` in all."""
    rng, n = np.random.default_rng(2), len(robot.joints)
    q = rng.uniform(-1.5, 1.5, (COUNT, n))
    payload = np.arange(COUNT) % 2 - 1
    torque = np.empty((COUNT, n))
    for j in range(n):
        step = 1e-6 * np.eye(n)[j]
        for hung in (-1, 0):
            mine = payload == hung
            total = np.zeros(mine.sum())
            for way in (1.0, -1.0):
                at = q[mine] + way * step
                total -= way * energy(robot, at, LOAD if hung == 0 else None) / 2e-6
                if more is not None:
                    bare = replace(robot, masses=())
                    total -= way * energy(bare, at, more) / 2e-6
            torque[mine, j] = factor * total
    torque += np.array([2.0, -1.0, 0.5, 3.0, 0.0]) + 0.05 * rng.normal(size=torque.shape)
    return Positions(
        Tool("ball", np.zeros(3), np.zeros((1, 3)), ("R1",)),
        LoadCases(q, np.zeros((COUNT, 6))),
        tuple(map(str, range(COUNT))),
        np.arange(COUNT),
        np.zeros(COUNT),
        np.zeros((COUNT, 3)),
        np.tile(np.eye(3), (COUNT, 1, 1)),
        np.zeros(COUNT),
        payload=payload,
        payloads=(LOAD.name,),
        torque=torque,
    )


def check(found: Positions, robot: Robot) -> TorqueCheck:
    made = torque_check(found, robot, GRAVITY, (LOAD,))
    assert made is not None
    return made


@pytest.mark.parametrize("factor", [1.0, -1.0])
def test_torques_of_the_weights_are_explained_but_for_the_noise(factor: float) -> None:
    robot = arm()
    made = check(read(robot, factor), robot)
    assert made.share == pytest.approx(factor, abs=0.01)
    assert made.left == pytest.approx(0.05, rel=0.3)
    assert made.mass == 0.0
    said = worded(made.doubt)
    assert "1.00 times what weights and forces exert on" in said
    assert ("other sign" in said) == (factor < 0.0)
    assert "look at" not in said


def test_a_mass_that_nobody_told_of_is_found() -> None:
    robot = arm()
    made = check(read(robot, -1.0, Payload("gripper", 3.5, np.array([0.0, 0.1, 0.05]))), robot)
    assert made.mass == pytest.approx(3.5, abs=0.1)
    assert "most of it by 3.5 kg more on the flange" in worded(made.doubt)


def test_another_unit_is_seen() -> None:
    robot = arm()
    said = worded(check(read(robot, 0.1), robot).doubt)
    assert "0.10 times" in said
    assert "look at masses, payload and units" in said


def test_without_masses_there_is_nothing_to_compare_with() -> None:
    robot = arm()
    found = replace(read(robot), payload=np.full(COUNT, -1))
    made = check(found, replace(robot, masses=()))
    assert "nothing is known that loads the joints" in worded(made.doubt)
    assert torque_check(replace(found, torque=np.zeros(0)), robot, GRAVITY, ()) is None
