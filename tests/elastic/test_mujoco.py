"""Where an elastic arm comes to rest, against MuJoCo's equations of motion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.deflections import loaded_deflection
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged, subset
from elastocal.robot.chain import Robot
from elastocal.robot.shapes import BodyMass
from elastocal.robot.sources import DHRow, from_dh
from tests.arms import random_chain, random_tool
from tests.kr270 import kr270_study, kr270_truth, published_cases
from tests.settling import Settling

ABSOLUTE, RELATIVE = 1e-11, 1e-9  # m, of the deflection
GRAVITY = np.array([0.0, 0.0, -9.81])
STUDY = kr270_study()
TRUTH = kr270_truth(STUDY)


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo writes its log into the folder it is run in."""
    monkeypatch.chdir(tmp_path)


def seven_joints() -> Robot:
    """A redundant arm of common proportions, 1.3 m long."""
    quarter = np.pi / 2
    turns = [-quarter, quarter, quarter, -quarter, -quarter, quarter, 0.0]
    lengths = [0.36, 0.0, 0.42, 0.0, 0.4, 0.0, 0.126]
    rows = [
        DHRow(f"J{i + 1}", 0.0, d, 0.0, alpha, False, 1.0, -3.0, 3.0)
        for i, (alpha, d) in enumerate(zip(turns, lengths, strict=True))
    ]
    return from_dh("seven joints", rows, modified=False)


def weights(robot: Robot, rng: np.random.Generator, mass: float) -> tuple[BodyMass, ...]:
    """A weight on every body, some with two."""
    bodies = [*range(1, len(robot.joints) + 1), 2]
    return tuple(
        BodyMass(b, mass * rng.uniform(0.2, 1.0), rng.normal(size=3) * 0.3) for b in bodies
    )


def compare(arm: ElasticArm, compliance: Array, cases: LoadCases) -> float:
    """Assert that both come to rest in the same place; the largest deflection [m]."""
    ours = loaded_deflection(arm, compliance, cases)
    for q, wrench, own in zip(cases.q, cases.wrench, ours, strict=True):
        theirs = Settling(arm, compliance, q).deflection(wrench)
        np.testing.assert_allclose(own, theirs, rtol=0.0, atol=ABSOLUTE)
        assert np.linalg.norm(own - theirs) <= RELATIVE * np.linalg.norm(theirs)
    return float(np.abs(ours).max())


@pytest.mark.parametrize("heavy", [False, True], ids=["weightless links", "heavy links"])
def test_the_kr270_under_its_calibration_loads(heavy: bool) -> None:
    robot = STUDY.robot
    if heavy:
        robot = replace(robot, masses=weights(robot, np.random.default_rng(0), 300.0))
    gravity = GRAVITY if heavy else np.zeros(3)
    arm = ElasticArm(robot, TRUTH.springs, STUDY.experiments.tool, gravity)
    largest = compare(arm, TRUTH.compliance, published_cases(4))
    assert largest > 4e-3
    # The linear model would not pass.
    linear = deflection(arm, TRUTH.compliance, published_cases(4))
    theirs = Settling(arm, TRUTH.compliance, published_cases(4).q[0]).deflection(
        published_cases(4).wrench[0]
    )
    assert np.linalg.norm(linear[0, :3] - theirs) > 1e5 * ABSOLUTE


@pytest.mark.parametrize("heavy", [False, True], ids=["weightless links", "heavy links"])
def test_a_soft_arm_of_seven_joints(heavy: bool) -> None:
    """Forces and moments, two markers away from the load point, deflections of centimetres."""
    rng = np.random.default_rng(1)
    robot = seven_joints()
    if heavy:
        robot = replace(robot, masses=weights(robot, rng, 4.0))
    arm = ElasticArm(robot, joint_springs(robot), random_tool(rng, 2), GRAVITY * heavy)
    compliance = rng.uniform(0.5e-4, 3e-4, 7)
    cases = LoadCases(
        rng.uniform(-2.0, 2.0, (3, 7)), rng.normal(size=(3, 6)) * [80, 80, 80, 20, 20, 20]
    )
    assert compare(arm, compliance, cases) > 1e-2


@pytest.mark.parametrize("seed", range(3))
def test_springs_anywhere_and_sliding_joints(seed: int) -> None:
    """Base and link springs, rigid joints, prismatic joints, weights: everything at once."""
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, [False, True, False, False, True])
    robot = replace(robot, masses=weights(robot, rng, 20.0))
    body = np.array([0, 0, 2, 3, 5])
    axis = rng.normal(size=(5, 3))
    extra = VirtualJoints(
        names=("base turn", "base slide", "link", "forearm", "wrist"),
        body=body,
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        origin=rng.normal(size=(5, 3)),
        prismatic=np.array([False, True, False, True, False]),
    )
    springs = merged(extra, subset(joint_springs(robot), ["J1", "J2", "J4"]))
    compliance = np.where(springs.prismatic, 1e-6, 1e-5) * rng.uniform(0.5, 2.0, len(springs))
    arm = ElasticArm(robot, springs, random_tool(rng, 2), rng.normal(size=3) * 5.0)
    cases = LoadCases(rng.uniform(-1.0, 1.0, (2, 5)), rng.normal(size=(2, 6)) * 300.0)
    assert compare(arm, compliance, cases) > 1e-3
