"""Robots, studies and programs to export."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import elastocal as ec
from elastocal.arrays import Array
from elastocal.elastic.allowed_loads import FreeDirection
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.measuring.instrument import Isotropic
from elastocal.programs.campaign_program import campaign_program
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle
from elastocal.programs.writers import WRITERS, export
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.study.study import Experiments, Study, test_pose
from tests.programs.writers.parsers import Event

GOLDEN = Path(__file__).parent / "golden"
EXAMPLES = Path(__file__).parents[3] / "examples"
DIGEST = "0123456789abcdef" * 4


def arm(kinds: str, limit: float = np.pi, name: str = "arm") -> Robot:
    """A chain of turning (R) and sliding (P) joints, half a metre apart, axes in turn."""
    axes = np.eye(3)[[2, 1, 1, 0, 1, 0]]
    joints = tuple(
        Joint(
            f"J{i + 1}" if kind == "R" else f"S{i + 1}",
            transform(None, (0.3, 0.1, 0.4)),
            axes[i % 6],
            kind == "P",
            -limit,
            limit if kind == "R" else 3.0,
        )
        for i, kind in enumerate(kinds)
    )
    return Robot(name, joints)


def study_for(robot: Robot, size: float = 1000.0, name: str = "study") -> Study:
    """A study that allows forces and torques of any direction."""
    tool = Tool("bracket", np.array([0.1, 0, 0.2]), np.array([[0.1, 0, 0.2]]), ("M1",))
    springs = joint_springs(robot, None)
    case = LoadCases(np.zeros((1, len(robot.joints))), np.array([[1.0, 2, 3, 0, 0, 0]]))
    pose = test_pose(ElasticArm(robot, springs, tool), case, 1.0, "task")
    z = np.array([0.0, 0, 1])
    experiments = Experiments(tool, FreeDirection(size, z), 4, None, FreeDirection(size, z))
    return Study(robot, springs, (pose,), experiments, Isotropic(1e-4), name=name)


def kr270_program(**options: object) -> RobotProgram:
    """The campaign of the KR 270 with three configurations."""
    study = ec.read_study(EXAMPLES / "kr270" / "study.yaml")
    q = np.radians(
        [
            [0, -50.7922, 63.0588, -32.5611, 101.6598, -93.7903],
            [0, -55.4571, -72.4034, -119.3938, -56.5916, -179.2668],
            [0, -1.6852, -3.7994, -58.2496, 39.5358, 168.8163],
        ]
    )
    wrench = np.tile([0, 0, -2500.0, 0, 0, 0], (3, 1))
    cases, repeats = LoadCases(q, wrench), np.array([2, 1, 1])
    return campaign_program(study, cases, repeats, digest=DIGEST, **options)  # type: ignore[arg-type]


def rail_program() -> RobotProgram:
    """A six-axis arm on a rail, with forces and torques in several directions, and a home."""
    robot = arm("PRRRRRR", name="arm on a rail")
    study = study_for(robot, name="Schiene – Zelle 3 (Süd)")
    q = np.array(
        [[1.23456789, 0.1, -0.2, 0.3, -0.4, 0.5, -0.6], [0.5, 1.1, 1.2, -1.3, 1.4, -1.5, 3.1]]
    )
    wrench = np.array([[100.0, -200.5, -300.25, 0, 0, 0], [0, 0, -98.0665, 1.5, 0, -2]])
    return campaign_program(
        study, LoadCases(q, wrench), np.array([1, 2]), home=np.zeros(7), digest=DIGEST, speed=0.25
    )


PROGRAMS = {"kr270": kr270_program, "rail": rail_program}
SHOWN = [(w, c) for w in PROGRAMS for c in WRITERS if (w, c) != ("rail", "urscript")]


def renew() -> None:
    """Write the golden files anew, after a deliberate change; read the difference."""
    for which, controller in SHOWN:
        for name, text in export(PROGRAMS[which](), controller).items():
            (GOLDEN / name).write_text(text, encoding="ascii")


def expected(program: RobotProgram, scale: Array, order: list[int]) -> list[Event]:
    """What a controller should do: events in the units of `scale`, axes in `order`."""
    events: list[Event] = []
    for step in program.steps:
        if isinstance(step, Move):
            events.append(("move", (program.targets[step.target] * scale)[order].tolist()))
        elif isinstance(step, Settle):
            events.append(("wait", step.seconds))
        else:
            assert isinstance(step, Ask | Measure)
            events.append(("stop", step.text))
    return events


if __name__ == "__main__":
    renew()
