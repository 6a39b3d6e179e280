"""Random campaigns of absolute readings: several stations, mountings and payloads, all at once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel, State
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.unknowns import Unknowns
from elastocal.measuring.positions import Positions
from elastocal.robot.compensators import Compensator
from elastocal.robot.geometry import geometric_errors
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_rotation_vectors
from tests.arms import random_chain, random_springs, random_tool, with_masses


def random_model(rng: np.random.Generator, slides: list[bool]) -> ArmModel:
    """A heavy arm with springs in all joints and two elsewhere, of which two are one unknown."""
    n = len(slides)
    robot = with_masses(rng, random_chain(rng, slides))
    springs = random_springs(rng, robot)
    make = np.eye(n + 2)
    a, b = (springs.names.index(name) for name in "ab")
    make[b, a] = 1.0
    make = np.delete(make, b, axis=1)
    names = tuple(name for name in springs.names if name != "b")
    tool = replace(random_tool(rng, 2), rotation=True)
    payloads = (
        Payload("known", 0.4, rng.normal(size=3)),
        Payload("open", 0.3, np.ones(3), 1.0, 1.0),
    )
    errors = geometric_errors(robot)
    turning = [i for i, slide in enumerate(slides) if not slide][:2]
    held = tuple(Compensator(f"C{i}", i, 0.4, 1.1, rng.normal(), 0.3) for i in turning)
    unknowns = Unknowns(names, springs, make)
    return ArmModel(robot, tool, errors, unknowns, rng.normal(size=3), payloads, held)


def random_state(rng: np.random.Generator, model: ArmModel, size: float = 0.02) -> State:
    """A state with errors of this size, and springs that give way as much."""
    base = np.tile(np.eye(4), (2, 1, 1))
    base[:, :3, :3] = from_rotation_vectors(rng.normal(size=(2, 3)))
    base[:, :3, 3] = rng.normal(size=(2, 3))
    payload = np.array([[p.mass, *(p.mass * p.center)] for p in model.payloads])
    return State(
        base,
        rng.normal(size=(2, 2, 3)),
        from_rotation_vectors(rng.normal(size=(2, 3))),
        size * rng.normal(size=len(model.errors)),
        size * rng.uniform(0.1, 1.0, len(model.compliances)),
        payload,
        size * rng.normal(size=len(model.compensators)),
    )


def random_positions(rng: np.random.Generator, model: ArmModel, count: int = 12) -> Positions:
    """Readings of all targets in every pose, at random values."""
    targets, poses = len(model.tool.targets), np.arange(count)
    case, marker = np.repeat(poses, targets), np.tile(np.arange(targets), count)
    return Positions(
        model.tool,
        LoadCases(
            rng.uniform(-2.0, 2.0, (count, len(model.robot.joints))), rng.normal(size=(count, 6))
        ),
        tuple(str(i) for i in poses),
        case,
        marker,
        rng.normal(size=(len(case), 3)),
        np.tile(np.eye(3), (len(case), 1, 1)),
        rng.integers(0, 2, len(case)),
        ("near", "far"),
        poses % 2,
        ("first", "second"),
        poses % 3 - 1,
        tuple(p.name for p in model.payloads),
    )


def at_unknowns(values: Array, index: int, size: float) -> Array:
    """(U,) zero but for one."""
    step = np.zeros(len(values))
    step[index] = size
    return step
