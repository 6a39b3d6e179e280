"""The paper's two planning problems as studies, and the restricted space of its section 5."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Elevation, HalfSpace, MinRadius
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, InPlane, Load
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import Regressor
from elastocal.elastic.springs import joint_springs
from elastocal.measuring.instrument import Isotropic
from elastocal.robot.posture import Posture
from elastocal.robot.sources import kuka_kr270, three_link
from elastocal.study.study import Experiments, Study, TestPose, springs_of, test_pose
from tests.paper.published import (
    CALIBRATION_FORCE,
    FORCE_IN_TEXT,
    SIGMA,
    TEST_CONFIGURATION,
)


def kr270(
    a0: Array, count: int = 12, configurations: int | None = None, force: Load | None = None
) -> Study:
    """Section 6, for a test pose given as its matrix."""
    robot = kuka_kr270()
    tool = robot.tools["calibration"]
    point = tool.load_point
    constraints = (
        HalfSpace("height of M1 >= 800 mm", point, [0, 0, 1], 0.8),
        MinRadius("radius of M1 >= 600 mm", point, 0.6),
        Elevation("elevation of z <= 30°", [0, 0, 1], np.radians(30.0)),
    )
    return Study(
        robot,
        springs_of(robot, ["A2", "A3", "A4", "A5", "A6"]),
        (TestPose("machining", a0),),
        Experiments(tool, force or FixedVector(CALIBRATION_FORCE), count, configurations),
        Isotropic(SIGMA),
        constraints,
    )


def any_direction() -> FreeDirection:
    """|F| <= 2500 N."""
    return FreeDirection(2500.0, np.array([0.0, 0.0, -1.0]))


def cone(half_angle_deg: float) -> FreeDirection:
    """|F| <= 2500 N, within a cone about the vertical."""
    return replace(any_direction(), half_angle=np.radians(half_angle_deg))


def three_link_study(count: int) -> Study:
    """Section 5 with every joint free and a force of size 1 in any direction."""
    robot = three_link()
    springs = joint_springs(robot)
    tip = robot.tools["tip"]
    case = LoadCases(np.radians([TEST_CONFIGURATION]), np.append(FORCE_IN_TEXT, np.zeros(3))[None])
    return Study(
        robot,
        springs,
        (test_pose(ElasticArm(robot, springs, tip), case, 1.0, "task"),),
        Experiments(tip, FreeDirection(1.0, np.array([0.0, 0.0, 1.0])), count),
        Isotropic(1.0),
    )


def restricted_three_link_study(count: int) -> Study:
    """Section 5 as the paper restricts it: q1 held at 0 and the force in the yz plane."""
    study = three_link_study(count)
    limits = np.array(study.limits)
    limits[:, 0] = 0.0
    force = InPlane(1.0, np.array([1.0, 0.0, 0.0]))
    return replace(study, limits=limits, experiments=replace(study.experiments, force=force))


class PlanarForceSpace:
    """The same by hand: q1 = 0 and F = (0, cos α, sin α), eq. (30).

    A design space of its own, with design variables (q2, q3, α) [rad].
    """

    parameters = 3
    lower = np.full(3, -np.pi)
    upper = np.full(3, np.pi)

    core = None

    def parts(self, count: int) -> int:
        return 1

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        return rng.uniform(self.lower, self.upper, (count, 3))

    def evaluate(self, x: Array, repeats: Array | None = None) -> PlanarForceEvaluation:
        return PlanarForceEvaluation(x)


class PlanarForceEvaluation:
    """Rows and their gradient in (q2, q3, α)."""

    def __init__(self, x: Array) -> None:
        robot = three_link()
        q = np.column_stack([np.zeros(len(x)), x[:, :2]])
        wrench = np.zeros((len(x), 6))
        wrench[:, 1], wrench[:, 2] = np.cos(x[:, 2]), np.sin(x[:, 2])
        tip = robot.tools["tip"]
        self._regressor = Regressor(
            ElasticArm(robot, joint_springs(robot), tip), Posture(robot, q), wrench
        )
        self._turn = np.stack([-wrench[:, 2], wrench[:, 1]])
        self.blocks = self._regressor.rows.transpose(2, 0, 1)
        self.margins = np.zeros((len(x), 0))

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        q_bar, wrench_bar = self._regressor.pull(block_cotangent.transpose(1, 2, 0))
        alpha_bar = (wrench_bar[1:3] * self._turn).sum(axis=0)
        return np.column_stack([q_bar[1], q_bar[2], alpha_bar])
