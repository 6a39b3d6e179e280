"""What absolute readings depend on: an arm with geometric errors that bends under what it carries,
and where its base and its reflectors are."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, freeze, unset
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.springs import VirtualJoints
from elastocal.elastic.unknowns import Unknowns
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.compensators import Compensator
from elastocal.robot.geometry import GeometricErrors, with_errors
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_rotation_vectors


@dataclass(frozen=True)
class ArmModel:
    """An arm as drawn, with what may be unlike its drawing.

    Attributes:
        robot: The robot as drawn, with the masses of its links.
        tool: What is on the flange: load point, and reflectors where they are thought to be.
        errors: G geometric errors.
        compliances: p unknowns that make the compliances of springs.
        gravity: (3,) acceleration that masses feel, base frame [m/s²].
        payloads: L payloads as they are thought to be.
        compensators: C springs that hold part of the weight, of unknown stiffness.
    """

    robot: Robot
    tool: Tool
    errors: GeometricErrors
    compliances: Unknowns
    gravity: Array
    payloads: tuple[Payload, ...] = ()
    compensators: tuple[Compensator, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "gravity")


@dataclass(frozen=True)
class State:
    """One value of everything that readings depend on.

    Attributes:
        base: (S, 4, 4) pose of the robot's base in the frame of each station [m].
        markers: (M, K, 3) reflectors of each mounting, flange frame [m].
        probe: (M, 3, 3) axes of the probe of each mounting in the flange frame, as columns.
        geometry: (G,) geometric errors [rad or m].
        compliance: (p,) unknowns of the compliances [rad/(N·m) or m/N].
        payload: (L, 4) mass [kg] and first moment about the flange's origin [kg·m], flange frame.
        compensator: (C,) compliances of joints times stiffnesses of their compensators [rad/m²].
    """

    base: Array
    markers: Array
    probe: Array
    geometry: Array
    compliance: Array
    payload: Array = field(default_factory=lambda: np.zeros((0, 4)))
    compensator: Array = field(default_factory=unset)

    def __post_init__(self) -> None:
        freeze(self, "base", "markers", "probe", "geometry", "compliance", "payload", "compensator")


def calibrated_robot(model: ArmModel, state: State) -> Robot:
    """The robot with its geometric errors."""
    return with_errors(model.robot, model.errors, state.geometry)


def springs_on(robot: Robot, springs: VirtualJoints) -> VirtualJoints:
    """The same springs on a robot whose axes moved: those in joints stay on them."""
    in_joint = springs.joint >= 0
    if not in_joint.any():
        return springs
    links = robot.links[robot.place[springs.joint[in_joint]]]
    axis, origin = np.array(springs.axis), np.array(springs.origin)
    axis[in_joint], origin[in_joint] = links[:, :3, 2], links[:, :3, 3]
    return replace(springs, axis=axis, origin=origin)


def loaded_arm(model: ArmModel, state: State, robot: Robot, payload: int) -> ElasticArm:
    """The arm `robot` of a model with one of its payloads (-1: none), which hangs on its flange."""
    hung = None
    if payload >= 0:
        mass = max(float(state.payload[payload, 0]), 0.0)
        center = state.payload[payload, 1:] / mass if mass > 0.0 else np.zeros(3)
        hung = replace(model.payloads[payload], mass=mass, center=center)
    springs = springs_on(robot, model.compliances.springs)
    held = tuple(zip(model.compensators, state.compensator.tolist(), strict=True))
    return ElasticArm(robot, springs, model.tool.at_tcp, model.gravity, hung, compensators=held)


def stepped(state: State, step: State) -> State:
    """The state after a small step, given as one: `base` and `probe` of it are unit transforms.

    Bases turn and shift in the frames of their stations, probes in their own.
    """
    base = step.base @ state.base
    return State(
        base,
        state.markers + step.markers,
        state.probe @ step.probe,
        state.geometry + step.geometry,
        state.compliance + step.compliance,
        state.payload + step.payload,
        state.compensator + step.compensator,
    )


def small_bases(vectors: Array, base: Array) -> Array:
    """(S, 4, 4) steps that turn bases about their own origins and shift them.

    Args:
        vectors: (S, 6) shift [m], then turn [rad], in the frames of the stations.
        base: (S, 4, 4) the bases that they act on [m].
    """
    steps = np.tile(np.eye(4), (len(vectors), 1, 1))
    turn = from_rotation_vectors(vectors[:, 3:])
    origin = base[:, :3, 3]
    steps[:, :3, :3] = turn
    steps[:, :3, 3] = origin + vectors[:, :3] - np.einsum("sij,sj->si", turn, origin)
    return steps
