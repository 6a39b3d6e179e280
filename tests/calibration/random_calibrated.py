"""Calibrated robots by chance: what a calibration would leave, without the fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from elastocal.calibration.arm_model import ArmModel, State
from elastocal.calibration.calibrated_robot import CalibratedRobot, Origin, StationNoise
from elastocal.calibration.parameters import parameters_of
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.measuring.positions import Positions
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.geometry import geometric_errors
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_rotation_vectors
from tests.calibration.random_campaign import random_model, random_positions, random_state

TOOL = Tool(
    "probe",
    np.array([0.01, 0.02, 0.1]),
    np.array([[0.1, 0.0, 0.05], [0.0, 0.1, 0.06], [-0.1, 0.02, 0.1]]),
    ("R1", "R2", "R3"),
    np.array([0.0, 0.0, 0.2]),
)


def random_calibrated(
    rng: np.random.Generator, slides: Sequence[bool]
) -> tuple[CalibratedRobot, Positions]:
    """A calibrated arm of any joints, and readings of it."""
    model = random_model(rng, list(slides))
    positions, state = random_positions(rng, model, 8), random_state(rng, model, 0.01)
    return calibrated_of(rng, model, state, positions), positions


def calibrated_of(
    rng: np.random.Generator, model: ArmModel, state: State, positions: Positions
) -> CalibratedRobot:
    """With a covariance by chance, parts of it all but singular."""
    held = ("tool",) if rng.integers(2) else ()
    parameters = replace(parameters_of(model, positions, held=held), rows=np.zeros((0, 0)))
    u = len(parameters)
    root = rng.normal(size=(u, u)) * 10.0 ** rng.uniform(-6.0, -4.0, u)[:, None]
    root[parameters.held] = 0.0
    open_ = np.zeros((2, u))
    open_[:, [3, u - 1]] = [[1.0, -0.5], [0.25, 1.0]]
    return CalibratedRobot(
        model=model,
        state=state,
        parameters=parameters,
        covariance=root @ root.T,
        seen=rng.integers(0, 2, u).astype(bool) & ~parameters.held,
        open=open_,
        told=u - 2,
        dof=123.0,
        stations=positions.stations,
        mountings=positions.mountings,
        noise=tuple(StationNoise(*rng.uniform(1e-6, 1e-4, 4).tolist()) for _ in positions.stations),
        poses=len(positions.cases),
        readings=len(positions),
        fitted=1e-4,
        left_out=1.2e-4,
        origin=Origin("cell 3", 64 * "a", "readings.csv", 64 * "b", (64 * "b",)),
        source="readings.csv",
    )


def calibrated_as(
    rng: np.random.Generator, robot: Robot, size: float = 1e-3, tool: Tool = TOOL
) -> CalibratedRobot:
    """A robot with errors of this size, springs in its joints, one station and one mounting."""
    errors, springs = geometric_errors(robot), joint_springs(robot)
    payloads = (Payload("gripper", 3.0, np.array([0.0, 0.02, 0.1]), 0.1, 0.01),)
    gravity = np.array([0.0, 0.0, -9.80665])
    model = ArmModel(robot, tool, errors, each_spring(springs), gravity, payloads)
    base = np.eye(4)[None].copy()
    base[0, :3, :3] = from_rotation_vectors(rng.normal(size=(1, 3)))[0]
    base[0, :3, 3] = rng.normal(size=3)
    state = State(
        base,
        (tool.markers + size * rng.normal(size=tool.markers.shape))[None],
        np.eye(3)[None],
        size * rng.normal(size=len(errors)),
        rng.uniform(1e-7, 1e-5, len(springs)),
        np.array([[3.05, 0.0, 0.06, 0.31]]),
    )
    return calibrated_of(rng, model, state, plain_positions(rng, model, 8))


def plain_positions(rng: np.random.Generator, model: ArmModel, count: int) -> Positions:
    """Readings of all reflectors by one station, all with the first payload if there is any."""
    markers, poses = len(model.tool.markers), np.arange(count)
    case = np.repeat(poses, markers)
    n = len(model.robot.joints)
    return Positions(
        model.tool,
        LoadCases(rng.uniform(-1.5, 1.5, (count, n)), 10.0 * rng.normal(size=(count, 6))),
        tuple(str(i) for i in poses),
        case,
        np.tile(np.arange(markers), count),
        rng.normal(size=(len(case), 3)),
        np.tile(np.eye(3), (len(case), 1, 1)),
        np.zeros(len(case)),
        payload=np.full(count, 0 if model.payloads else -1),
        payloads=tuple(p.name for p in model.payloads),
    )
