"""Elastic arm: a robot that bends, as one value: springs, tool, gravity.

In: robot, virtual joints. Out: the same arm as a chain in which every spring is a joint, so that
one kinematics serves the rigid arm and the bent one.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from elastocal.arrays import Array, IntArray, freeze, frozen
from elastocal.elastic.springs import VirtualJoints
from elastocal.robot.chain import Joint, Robot, T_body_joint, Tool, transform
from elastocal.robot.shapes import BodyMass


@dataclass(frozen=True)
class ElasticArm:
    """A robot with p springs and a tool.

    Attributes:
        robot: The robot.
        springs: Its p springs; joints without a spring are rigid.
        tool: Tool with load point and K markers.
        gravity: (3,) acceleration in the base frame [m/s²]; zero: the weight of the links is
            left out. It counts only for a robot whose masses are known.
    """

    robot: Robot
    springs: VirtualJoints
    tool: Tool
    gravity: Array = field(default_factory=lambda: np.zeros(3))

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
        """(T,) joints of the chain and its followers that springs displace, and (T, p) how far.

        The p joints that carry the springs come first, so the first p rows are the identity.
        """
        share = self.chain.mixing[:, self.sprung]
        follow = np.arange(len(self.chain.joints), len(share))
        follow = follow[np.any(share[follow] != 0.0, axis=1)]
        joints = np.concatenate([self.sprung, follow])
        return frozen(joints, np.int64), frozen(share[joints])

    @cached_property
    def _sprung_chain(self) -> tuple[Robot, IntArray, IntArray]:
        # Made when first asked for: the linear model does without.
        chain, actuated, sprung = _chain(self.robot, self.springs)
        return chain, frozen(actuated, np.int64), frozen(sprung, np.int64)

    @property
    def sags(self) -> bool:
        """Whether the weight of the links bends the arm without any other load."""
        return bool(self.gravity.any() and any(body.mass for body in self.robot.masses))

    def bent(self, q: Array, displacement: Array) -> Array:
        """(N, c) joint values of the chain for configurations (N, n) and springs (N, p)."""
        joints = np.zeros((len(q), len(self.chain.joints)))
        joints[:, self.actuated] = q
        joints[:, self.sprung] += displacement
        return joints


def _chain(robot: Robot, springs: VirtualJoints) -> tuple[Robot, list[int], list[int]]:
    """The robot with a further joint for every spring that is not in a joint."""
    extra = np.flatnonzero(springs.joint < 0)
    n = len(robot.joints)
    if not len(extra):
        return robot, list(range(n)), [int(j) for j in springs.joint]
    joints: list[Joint] = []
    actuated: list[int] = []
    sprung = np.zeros(len(springs), dtype=np.int64)
    undo: Array = np.eye(4, dtype=float)  # from the frame of the body to the joint inserted last
    for body in range(n + 1):
        # Springs are given in the body's own frame, joints in the frame of the file.
        own = np.linalg.inv(T_body_joint(robot, body))
        for s in extra[springs.body[extra] == body]:
            place = own @ transform(None, springs.origin[s])
            axis = springs.axis[s]
            name = f"spring {springs.names[s]}"
            joints.append(Joint(name, undo @ place, axis, bool(springs.prismatic[s])))
            sprung[s] = len(joints) - 1
            undo = np.asarray(np.linalg.inv(place), dtype=float)
        if body < n:
            joint = robot.joints[body]
            actuated.append(len(joints))
            joints.append(replace(joint, T_parent_joint=undo @ joint.T_parent_joint))
            undo = np.eye(4)
    in_joint = springs.joint >= 0
    sprung[in_joint] = np.array(actuated)[springs.joint[in_joint]]
    later = len(joints) - n  # by which followers, which come behind, move on in the row of bodies
    number = [0, *(i + 1 for i in actuated), *range(n + later + 1, robot.bodies + later)]
    chain = Robot(
        robot.name,
        tuple(joints),
        undo @ robot.T_tip_flange,
        followers=tuple(replace(f, carrier=number[f.carrier]) for f in robot.followers),
    )
    masses = []
    for mass in robot.masses:
        body, center = number[mass.body], np.array(mass.center)
        if body:  # the frames of both robots stand on the same axis
            center[2] += robot.shifts[mass.body - 1] - chain.shifts[body - 1]
        masses.append(BodyMass(body, mass.mass, center, mass.name))
    return replace(chain, masses=tuple(masses)), actuated, [int(j) for j in sprung]
