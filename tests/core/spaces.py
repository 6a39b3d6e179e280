"""Spaces of load cases of every shape, drawn by chance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.constraints import (
    AcceptanceCone,
    BeamRange,
    Constraint,
    Distinct,
    Elevation,
    HalfSpace,
    HeadAzimuth,
    HeadElevation,
    HeldJoint,
    JointLimit,
    MinRadius,
    Tilt,
)
from elastocal.elastic.absorbed import KnownErrors
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, InPlane, Load, ThereOrNot
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.elastic.unknowns import Unknowns
from elastocal.measuring.instrument import Instrument, Isotropic, LaserTracker, PoseProbe
from elastocal.robot.chain import Follower, Robot, Tool
from elastocal.robot.payloads import Payload
from elastocal.robot.shapes import BodyMass
from elastocal.study.experiment_space import LoadCaseSpace
from tests.arms import random_chain, random_tool


def random_space(seed: int, slides: list[bool], markers: int) -> LoadCaseSpace:
    """A robot, springs, tool, loads, instrument and constraints of any kind."""
    rng = np.random.default_rng(seed)
    robot = random_robot(rng, slides)
    tool = random_tool(rng, markers)
    rotation = bool(rng.random() < 0.4)
    springs = random_springs(rng, robot)
    errors = random_errors(rng, springs) if rng.random() < 0.5 else None
    weighs = errors is None and rng.random() < 0.5
    arm = ElasticArm(robot, springs, replace(tool, rotation=rotation))
    if weighs:
        arm = weighing(rng, arm)
    n = len(robot.joints)
    return LoadCaseSpace(
        arm=arm,
        force=random_load(rng, 2500.0),
        moment=random_load(rng, 400.0),
        constraints=random_constraints(rng, robot, arm.tool),
        instrument=random_instrument(rng, rotation=rotation),
        limits=np.array([np.full(n, -3.0), np.full(n, 3.0)]),
        makers=random_makers(rng, arm.springs) if rng.random() < 0.5 else None,
        errors=errors,
    )


def weighing(rng: np.random.Generator, arm: ElasticArm) -> ElasticArm:
    """The arm with masses that count, some springs as errors of geometry, some at one marker."""
    robot, p = arm.robot, len(arm.springs)
    bodies = rng.integers(0, robot.last + 1, 4)
    masses = tuple(BodyMass(int(b), rng.uniform(1.0, 50.0), rng.normal(size=3)) for b in bodies)
    springs = replace(
        arm.springs,
        stiff=rng.random(p) < 0.5,
        only=np.where(rng.random(p) < 0.7, -1, rng.integers(0, len(arm.tool.markers), p)),
    )
    payload = Payload("payload", 20.0, rng.normal(size=3)) if rng.random() < 0.5 else None
    gravity = 9.81 * rng.normal(size=3)
    heavy = replace(robot, masses=masses)
    return ElasticArm(heavy, springs, arm.tool, gravity, payload, weighs=True)


def random_robot(rng: np.random.Generator, slides: list[bool]) -> Robot:
    """A chain; some have a joint on it that follows another, and one beside it."""
    robot = random_chain(rng, slides)
    if len(slides) < 3 or rng.random() < 0.5:
        return robot
    names = robot.joint_names
    at = int(rng.integers(1, len(slides)))
    own = tuple(joint for i, joint in enumerate(robot.joints) if i != at)
    leader = own[int(rng.integers(len(own)))].name
    followers = [Follower(robot.joints[at], at, leader, -0.7, 0.2)]
    if rng.random() < 0.5:
        beside = replace(robot.joints[0], name="beside")
        followers.append(Follower(beside, int(rng.integers(len(slides))), own[0].name, 1.3))
    return Robot("any", own, robot.T_tip_flange, followers=tuple(followers), chain=names)


def random_springs(rng: np.random.Generator, robot: Robot) -> VirtualJoints:
    """Springs in the joints, or anywhere, or both."""
    count = int(rng.integers(1, 5))
    axis = rng.normal(size=(count, 3))
    anywhere = VirtualJoints(
        names=tuple(f"S{j}" for j in range(count)),
        body=np.sort(rng.integers(0, robot.last + 1, count)),
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        origin=rng.uniform(-1, 1, (count, 3)),
        prismatic=rng.random(count) < 0.4,
    )
    in_joints = joint_springs(robot)
    return [anywhere, in_joints, merged(anywhere, in_joints)][int(rng.integers(3))]


def random_makers(rng: np.random.Generator, springs: VirtualJoints) -> Unknowns:
    """Fewer or more unknowns than springs; some springs are made by none, some by several."""
    p = int(rng.integers(1, len(springs) + 3))
    make = rng.normal(size=(len(springs), p)) * (rng.random((len(springs), p)) < 0.5)
    return Unknowns(tuple(f"U{j}" for j in range(p)), springs, make)


def random_errors(rng: np.random.Generator, springs: VirtualJoints) -> KnownErrors:
    """Errors of load cases, some of them zero."""
    largest = {
        **{"friction": 0.1, "discrepancy": 0.1, "discrepancy_length": 3e-5, "gain": 0.05},
        **{"tilt": 0.05, "repeatability": 5e-5, "common_gain": 0.05, "common_tilt": 0.05},
    }
    sizes = {name: size * rng.random() * (rng.random() < 0.6) for name, size in largest.items()}
    compliance = rng.uniform(0.2e-6, 2e-6, len(springs)) * (rng.random(len(springs)) < 0.8)
    together = float(rng.choice([1.0, 2.5, 12.0]))
    return KnownErrors(CaseErrors(**sizes), compliance, springs.joint >= 0, 1e-7, together)


def random_load(rng: np.random.Generator, size: float) -> Load:
    """A load of one of the kinds, cone and none at all among them."""
    vector = rng.normal(size=3)
    return [
        FixedVector(np.zeros(3)),
        FixedVector(size * vector),
        FreeDirection(size, vector),
        FreeDirection(size, vector, 0.8),
        InPlane(size, vector),
        ThereOrNot(size * vector),
    ][int(rng.integers(6))]


def random_instrument(rng: np.random.Generator, *, rotation: bool) -> Instrument:
    """A tracker or the same noise everywhere; with rotations if they are wanted."""
    tracker = LaserTracker(rng.uniform(-6.0, 6.0, 3), 5e-6, 2e-7, 8e-6, 3e-6)
    points = tracker if rng.random() < 0.5 else Isotropic(3e-5)
    return PoseProbe(points, 2e-4) if rotation else points


def random_constraints(rng: np.random.Generator, robot: Robot, tool: Tool) -> list[Constraint]:
    """Some of all kinds that have closed forms."""
    n, head = len(robot.joints), rng.uniform(-6.0, 6.0, 3)
    one, two = (rng.normal(size=3) for _ in range(2))
    point = tool.markers[-1]
    joint = int(rng.integers(n))
    every: list[Constraint] = [
        HalfSpace("wall", tool.load_point, one, -0.5),
        MinRadius("radius", point, 0.6),
        Elevation("elevation", one, 0.7),
        Tilt("tilt", two, one, 1.0),
        JointLimit("limit", joint, 1.2, upper=bool(rng.random() < 0.5), unit="rad"),
        HeldJoint("held", joint, 0.3, unit="rad"),
        Distinct("apart", rng.uniform(-9.0, 9.0, n), rng.random(n) < 0.8, 0.02),
        BeamRange("range", "M", point, head, 4.0, upper=True),
        AcceptanceCone("acceptance", "M", point, head, two, 0.6),
        HeadElevation("elevation", "M", point, head, -0.5, upper=False),
        HeadAzimuth("azimuth", "M", point, head, 2.0, 4.0),
    ]
    return [constraint for constraint in every if rng.random() < 0.5]
