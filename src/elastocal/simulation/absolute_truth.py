"""True arms: as none is drawn, with every frame a little off, that sag under all they carry.

Nothing here goes the way of what identifies such arms: the chain is a plain product of the
transforms that a robot file gives, each frame displaced by a rigid motion of its own, and the
forces on the springs are slopes of the work of all loads, by complex steps. There are no
Denavit-Hartenberg numbers, Jacobians or normal forms.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from elastocal.arrays import Array, IntArray, freeze, unset
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import EquilibriumError, InputError
from elastocal.robot.chain import Robot, T_body_joint, transform
from elastocal.robot.compensators import Compensator
from elastocal.robot.payloads import Payload
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.simulation.true_compensators import energy

ComplexArray = NDArray[np.complex128]

_TINY = 1e-30  # of a complex step: its square is nothing beside 1
_MOST_ROUNDS = 100
_AT_REST = 1e-13  # rad or m by which springs still move


@dataclass(frozen=True)
class TrueArm:
    """An arm as it is.

    Attributes:
        robot: The robot as drawn, with the masses of its links.
        displaced: (n + F + 1, 4, 4) where the frame of each joint that moves, and last the flange,
            is in the frame where it is drawn [m].
        springs: Its c springs, in the frames of the bodies as drawn; those in joints are there.
        compliance: (c,) what they give way [rad/(N·m) or m/N].
        gravity: (3,) acceleration that masses feel, base frame [m/s²].
        payloads: What hangs on the flange, as it is.
        compensators: Springs that hold part of the weight at joints, each with its stiffness [N/m].
        wave: (n,) size of an error of each joint that repeats with its turns [rad or m].
        waves: (n,) how often in a turn, or in a metre.
        phase: (n,) where it is zero [rad].
        loose: (n,) standard deviation by which each joint stands elsewhere in every pose [rad, m].
    """

    robot: Robot
    displaced: Array
    springs: VirtualJoints
    compliance: Array
    gravity: Array
    payloads: tuple[Payload, ...] = ()
    compensators: tuple[tuple[Compensator, float], ...] = ()
    wave: Array = field(default_factory=unset)
    waves: Array = field(default_factory=unset)
    phase: Array = field(default_factory=unset)
    loose: Array = field(default_factory=unset)

    def __post_init__(self) -> None:
        freeze(self, "displaced", "compliance", gravity=np.reshape(self.gravity, 3))
        if self.displaced.shape != (self.robot.bodies, 4, 4):
            raise InputError(
                f"{self.robot.bodies - 1} joints and a flange are displaced by as many "
                f"transforms; found {self.displaced.shape}"
            )
        nothing = np.zeros(len(self.robot.joints))
        for name in ("wave", "waves", "phase", "loose"):
            given = getattr(self, name)
            freeze(self, **{name: given if np.size(given) else nothing})


def drawn_displacements(robot: Robot, shift: float, turn: float, rng: np.random.Generator) -> Array:
    """(n + F + 1, 4, 4) rigid motions by chance of every frame [m].

    Args:
        robot: The robot.
        shift: Standard deviation of each coordinate of a shift [m].
        turn: Standard deviation of a turn about each axis [rad].
        rng: Source of chance.
    """
    moved = np.tile(np.eye(4), (robot.bodies, 1, 1))
    moved[:, :3, :3] = from_rotation_vectors(turn * rng.normal(size=(robot.bodies, 3)))
    moved[:, :3, 3] = shift * rng.normal(size=(robot.bodies, 3))
    return moved


def commanded(arm: TrueArm, q: Array, rng: np.random.Generator) -> Array:
    """(N, n) where the joints stand in truth if the controller shows `q`, (N, n) [rad or m]."""
    full = np.where(arm.robot.prismatic, 1.0, 2.0 * np.pi)
    off = arm.wave * np.sin(2.0 * np.pi * arm.waves * q / full + arm.phase)
    return np.asarray(q + off + arm.loose * rng.normal(size=q.shape))


def flanges(arm: TrueArm, q: Array, wrench: Array, load_point: Array, payload: IntArray) -> Array:
    """(N, 4, 4) where the flange has come to rest, base frame [m].

    Args:
        arm: The arm.
        q: (N, n) where its joints stand [rad or m].
        wrench: (N, 6) what acts besides weights, base frame [N, N·m].
        load_point: (3,) where it acts, flange frame [m].
        payload: (N,) number of what hangs on the flange, -1 for nothing.

    Raises:
        EquilibriumError: an arm does not come to rest.
    """
    chain = _Chain(arm, q, wrench, load_point, payload)
    where = np.zeros((len(q), len(arm.springs)))
    for _ in range(_MOST_ROUNDS):
        before, where = where, arm.compliance * chain.forces(where)
        if not np.abs(where - before).max(initial=0.0) > _AT_REST:
            return np.asarray(chain.bodies(where.astype(complex))[-1].real)
    raise EquilibriumError("the true arm does not come to rest")


class _Chain:
    """The arm in N poses, as products of transforms."""

    def __init__(
        self, arm: TrueArm, q: Array, wrench: Array, load_point: Array, payload: IntArray
    ) -> None:
        self.arm, self.q, self.wrench = arm, q, wrench
        self.load_point = load_point
        robot = arm.robot
        self.own = [np.linalg.inv(T_body_joint(robot, b)) for b in range(robot.bodies)]
        self.weights = [
            (self.own[m.body] @ np.append(m.center, 1.0), m.body, m.mass) for m in robot.masses
        ]
        self.hung = np.zeros((len(q), 4))  # mass, and mass times centre
        for i, load in enumerate(arm.payloads):
            self.hung[payload == i] = [load.mass, *(load.mass * load.center)]

    def bodies(self, where: ComplexArray) -> list[ComplexArray]:
        """(N, 4, 4) frames of base, bodies and last the flange, the springs being at `where`."""
        arm, robot = self.arm, self.arm.robot
        q: ComplexArray = self.q.astype(complex)
        for i, joint in enumerate(arm.springs.joint.tolist()):
            if joint >= 0:
                q[:, joint] += where[:, i]
        values: ComplexArray = q @ robot.mixing.T + robot.standing
        found = [np.tile(np.eye(4, dtype=complex), (len(q), 1, 1))]
        ahead = self._bent(0, found[0], where)
        for i, joint in enumerate(robot.moving):
            # What stands beside the chain is carried by a body, what is on it by its springs too.
            carrier = ahead if i < robot.last else found[int(robot.carriers[i + 1])]
            frame = carrier @ (joint.T_parent_joint @ arm.displaced[i])
            found.append(frame @ _motion(joint.axis, values[:, i], joint.prismatic))
            if i < robot.last:
                ahead = self._bent(i + 1, found[-1], where)
                flange = ahead @ (robot.T_tip_flange @ arm.displaced[-1])
        return [*found, flange]

    def _bent(self, body: int, frame: ComplexArray, where: ComplexArray) -> ComplexArray:
        """The end of a body, behind the springs that sit on it."""
        springs = self.arm.springs
        for i in np.flatnonzero((springs.body == body) & (springs.joint < 0)).tolist():
            place = self.own[body] @ transform(None, springs.origin[i])
            move = _motion(springs.axis[i], where[:, i], bool(springs.prismatic[i]))
            frame = frame @ (place @ move @ np.linalg.inv(place))
        return frame

    def _stands(self, compensator: Compensator, where: ComplexArray) -> ComplexArray:
        """(N,) where the joint of a compensator stands, the springs being at `where`."""
        joint = compensator.joint
        own = self.arm.springs.joint == joint
        return np.asarray(self.q[:, joint] + where[:, own].sum(axis=1))

    def forces(self, where: Array) -> Array:
        """(N, c) what all loads exert on the springs: slopes of their work [N·m or N]."""
        found = np.empty_like(where)
        for i in range(where.shape[1]):
            moved = where.astype(complex)
            moved[:, i] += 1j * _TINY
            bodies = self.bodies(moved)
            work = bodies[-1][:, :3, :] @ np.append(self.load_point, 1.0)
            force = np.einsum("nc,nc->n", work, self.wrench[:, :3])
            for center, body, mass in self.weights:
                force = force + mass * (bodies[body][:, :3, :] @ center) @ self.arm.gravity
            for compensator, stiffness in self.arm.compensators:
                force = force - energy(compensator, stiffness, self._stands(compensator, moved))
            falls = np.einsum(
                "c,ncd,nd->n", self.arm.gravity, bodies[-1][:, :3, :3], self.hung[:, 1:]
            )
            force = force + falls + self.hung[:, 0] * (bodies[-1][:, :3, 3] @ self.arm.gravity)
            turn = bodies[-1][:, :3, :3]
            spin = turn.imag @ turn.real.transpose(0, 2, 1)
            about = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
            moment = np.einsum("nc,nc->n", about, self.wrench[:, 3:])
            found[:, i] = (force.imag + moment) / _TINY
        return found


def _motion(axis: Array, value: ComplexArray, slides: bool) -> ComplexArray:
    """(N, 4, 4) turn about an axis through the origin, or shift along it. Source: Rodrigues."""
    found = np.tile(np.eye(4, dtype=complex), (len(value), 1, 1))
    if slides:
        found[:, :3, 3] = value[:, None] * axis
        return found
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sine, rest = np.sin(value)[:, None, None], (1.0 - np.cos(value))[:, None, None]
    found[:, :3, :3] += sine * skew + rest * (skew @ skew)
    return found
