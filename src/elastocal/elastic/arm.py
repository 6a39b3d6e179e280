"""Elastic arm: a robot that bends, as one value: springs, tool, gravity.

In: robot, virtual joints. Out: the same arm as a chain in which every spring is a joint, so that
one kinematics serves the rigid arm and the bent one.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray, freeze, frozen
from elastocal.elastic.springs import VirtualJoints, merged
from elastocal.robot.chain import Joint, Robot, T_body_joint, Tool, transform
from elastocal.robot.compensators import Compensator
from elastocal.robot.payloads import Payload
from elastocal.robot.shapes import BodyMass


@dataclass(frozen=True)
class ElasticArm:
    """A robot with p springs and a tool.

    Attributes:
        robot: The robot.
        springs: Its p springs; joints without a spring are rigid.
        tool: Tool with load point and K markers.
        gravity: (3,) acceleration in the base frame [m/s²]; zero: the weight of the links is
            left out. It counts only for a robot whose masses are known, and for a payload.
        payload: What hangs on the flange by its weight, the last of the masses of the chain.
        weighs: Whether nothing is taken off the readings, so that the linear model counts weights
            as loads.
        compensators: Springs that hold a joint besides, each with what it makes of its lever: the
            compliance of the joint times the stiffness of the spring [rad/m²].
    """

    robot: Robot
    springs: VirtualJoints
    tool: Tool
    gravity: Array = field(default_factory=lambda: np.zeros(3))
    payload: Payload | None = None
    weighs: bool = False
    compensators: tuple[tuple[Compensator, float], ...] = ()

    def __post_init__(self) -> None:
        freeze(self, gravity=np.reshape(self.gravity, 3))

    @property
    def chain(self) -> Robot:
        """The robot with a joint for every spring."""
        return self._sprung_chain[0]

    @property
    def actuated(self) -> IntArray:
        """(n,) joints of the chain that are the robot's."""
        return self._sprung_chain[1]

    @property
    def sprung(self) -> IntArray:
        """(p,) joints of the chain that carry the springs."""
        return self._sprung_chain[2]

    @cached_property
    def bent_by(self) -> tuple[IntArray, Array]:
        """(T,) joints of `chain.moving` that springs displace, in order, and (T, p) how far."""
        share = self.chain.mixing[:, self.sprung]
        joints = np.flatnonzero(np.any(share != 0.0, axis=1))
        return frozen(joints, np.int64), frozen(share[joints])

    @cached_property
    def twists(self) -> tuple[VirtualJoints, IntArray, Array | None]:
        """The T unit twists by which springs move the tip of the rigid arm, and how.

        Returns:
            The springs, with the joints of the chain that follow a joint with a spring; (T,) which
            of `robot.moving` has the axis, -1 if none has; (T, p) their way for a unit
            displacement of each spring, None if no joint follows and it is the identity.
        """
        robot, springs = self.robot, self.springs
        at = np.where(springs.joint >= 0, robot.place[springs.joint], -1)
        if not robot.follows:
            return springs, frozen(at, np.int64), None
        way = robot.mixing[: robot.last, springs.joint] * (springs.joint >= 0)
        way[robot.place] = 0.0
        more = np.flatnonzero(np.any(way != 0.0, axis=1))
        follow = VirtualJoints(
            names=tuple(f"with {robot.moving[k].name}" for k in more),
            body=more,
            axis=robot.links[more, :3, 2],
            origin=robot.links[more, :3, 3],
            prismatic=robot.sliding[more],
        )
        twists = merged(springs, follow)
        rows = {name: i for i, name in enumerate((*springs.names, *follow.names))}
        order = [rows[name] for name in twists.names]
        share = np.concatenate([np.eye(len(springs)), way[more]])[order]
        return twists, frozen(np.append(at, more)[order], np.int64), frozen(share)

    @property
    def numbers(self) -> IntArray:
        """(n + F + 1,) numbers that the bodies of the robot have in the chain."""
        return self._sprung_chain[3]

    @cached_property
    def _sprung_chain(self) -> tuple[Robot, IntArray, IntArray, IntArray]:
        # Made when first asked for: the linear model does without.
        chain, *indices = _chain(self.robot, self.springs)
        if self.payload is not None:
            T, center = chain.links[chain.last], self.payload.center
            center = T[:3, :3] @ center + T[:3, 3]
            hung = BodyMass(chain.last, self.payload.mass, center, self.payload.name)
            chain = replace(chain, masses=(*chain.masses, hung))
        actuated, sprung, numbers = (frozen(found, np.int64) for found in indices)
        return chain, actuated, sprung, numbers

    @property
    def sags(self) -> bool:
        """Whether weights bend the arm without any other load."""
        weights = [body.mass for body in self.robot.masses]
        weights += [] if self.payload is None else [self.payload.mass]
        return bool(self.gravity.any() and any(weights))

    @property
    def weights(self) -> tuple[tuple[int, Array, Array], ...]:
        """Body, centre in its frame [m] and weight [N] of all that counts in the linear model.

        What hangs on the flange is on a body of its own behind all others, which is the flange.
        Masses of bodies beside the chain, as of rods, are left out.
        """
        if not (self.weighs and self.sags):
            return ()
        robot = self.robot
        found = [(b.body, b.center, b.mass) for b in robot.masses if b.body <= robot.last]
        if self.payload is not None:
            found.append((robot.bodies, self.payload.center, self.payload.mass))
        return tuple((body, center, mass * self.gravity) for body, center, mass in found if body)

    def bent(self, q: Array, displacement: Array) -> Array:
        """(N, c) joint values of the chain for configurations (N, n) and springs (N, p)."""
        joints = np.zeros((len(q), len(self.chain.joints)))
        joints[:, self.actuated] = q
        for compensator, strength in self.compensators:
            own = q[:, compensator.joint]
            joints[:, self.actuated[compensator.joint]] += strength * compensator.lever(own)
        joints[:, self.sprung] += displacement
        return joints


def _chain(robot: Robot, springs: VirtualJoints) -> tuple[Robot, list[int], list[int], list[int]]:
    """The robot with a further joint for every spring that is not in a joint."""
    extra = np.flatnonzero(springs.joint < 0)
    n = len(robot.joints)
    if not len(extra):
        return robot, list(range(n)), [int(j) for j in springs.joint], list(range(robot.bodies))
    joints: list[Joint] = []
    actuated: list[int] = []
    sprung = np.zeros(len(springs), dtype=np.int64)
    way: list[str] = []
    number = [0]  # of each body among those of the new chain
    own = {follower.joint.name: follower for follower in robot.followers}
    undo: Array = np.eye(4, dtype=float)  # from the frame of the body to the joint inserted last
    for body in range(robot.last + 1):
        # Springs are given in the body's own frame, joints in the frame of the file.
        inverse = np.linalg.inv(T_body_joint(robot, body))
        for s in extra[springs.body[extra] == body]:
            place = inverse @ transform(None, springs.origin[s])
            axis = springs.axis[s]
            name = f"spring {springs.names[s]}"
            joints.append(Joint(name, undo @ place, axis, bool(springs.prismatic[s])))
            sprung[s] = len(joints) - 1
            way.append(name)
            undo = np.asarray(np.linalg.inv(place), dtype=float)
        if body < robot.last:
            joint = robot.moving[body]
            joint = replace(joint, T_parent_joint=undo @ joint.T_parent_joint)
            if joint.name in own:
                own[joint.name] = replace(own[joint.name], joint=joint)
            else:
                actuated.append(len(joints))
                joints.append(joint)
            way.append(joint.name)
            number.append(len(way))
            undo = np.eye(4)
    in_joint = springs.joint >= 0
    sprung[in_joint] = np.array(actuated)[springs.joint[in_joint]]
    number += range(len(way) + 1, len(way) + 1 + robot.bodies - len(number))
    chain = Robot(
        robot.name,
        tuple(joints),
        undo @ robot.T_tip_flange,
        followers=tuple(replace(f, carrier=number[f.carrier]) for f in own.values()),
        chain=tuple(way),
    )
    masses = []
    for mass in robot.masses:
        body, center = number[mass.body], np.array(mass.center)
        if body:  # the frames of both robots stand on the same axis
            center[2] += robot.shifts[mass.body - 1] - chain.shifts[body - 1]
        masses.append(BodyMass(body, mass.mass, center, mass.name))
    return replace(chain, masses=tuple(masses)), actuated, [int(j) for j in sprung], number
