"""Random arms, Pinocchio as an independent model of them, and central differences."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from elastocal.arrays import Array
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.shapes import BodyMass


def random_rotation(rng: np.random.Generator) -> Array:
    """Uniform over all rotations."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diagonal(r))
    return q * np.linalg.det(q)


def random_transform(rng: np.random.Generator) -> Array:
    """A random rotation and a shift within a metre."""
    return transform(random_rotation(rng), rng.uniform(-1.0, 1.0, 3))


def random_chain(rng: np.random.Generator, slides: Sequence[bool]) -> Robot:
    """A chain of revolute and prismatic joints with arbitrary axes and transforms."""
    joints = tuple(
        Joint(f"J{i + 1}", random_transform(rng), rng.normal(size=3), prismatic)
        for i, prismatic in enumerate(slides)
    )
    return Robot("random", joints, random_transform(rng))


def random_tool(rng: np.random.Generator, markers: int) -> Tool:
    """A load point and markers within a metre of the flange."""
    names = tuple(f"M{i + 1}" for i in range(markers))
    return Tool("random", rng.uniform(-1, 1, 3), rng.uniform(-1, 1, (markers, 3)), names)


def with_masses(rng: np.random.Generator, robot: Robot) -> Robot:
    """The same arm with a mass on every link."""
    n = len(robot.joints)
    masses = (BodyMass(b, rng.uniform(0.1, 1.0), rng.normal(size=3)) for b in range(1, n + 1))
    return replace(robot, masses=tuple(masses))


def random_springs(rng: np.random.Generator, robot: Robot) -> VirtualJoints:
    """Springs in all joints, and two elsewhere."""
    axis = rng.normal(size=(2, 3))
    extra = VirtualJoints(
        names=("a", "b"),
        body=np.sort(rng.integers(0, len(robot.joints) + 1, 2)),
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        origin=rng.normal(size=(2, 3)),
        prismatic=rng.integers(0, 2, 2).astype(bool),
    )
    return merged(extra, joint_springs(robot))


class Oracle:
    """The same arm in Pinocchio, built joint by joint from the user's description of it."""

    def __init__(self, robot: Robot) -> None:
        self.model = pin.Model()
        parent = 0
        for joint in robot.joints:
            kind = (
                pin.JointModelPrismaticUnaligned
                if joint.prismatic
                else (pin.JointModelRevoluteUnaligned)
            )
            placement = pin.SE3(np.array(joint.T_parent_joint))
            parent = self.model.addJoint(parent, kind(np.array(joint.axis)), placement, joint.name)
        self.flange = self._frame("flange", parent, np.array(robot.T_tip_flange))
        self._last, self._T_tip_flange = parent, np.array(robot.T_tip_flange)

    def _frame(self, name: str, parent: int, T: Array) -> int:
        frame = pin.Frame(name, parent, 0, pin.SE3(T), pin.FrameType.OP_FRAME)
        return self.model.addFrame(frame)

    def at(self, point: Array) -> int:
        """Frame at a point of the flange body, given in the flange frame."""
        T = self._T_tip_flange @ transform(None, point)
        return self._frame(f"point {self.model.nframes}", self._last, T)

    def forward(self, q: Array) -> Array:
        """(4, 4) pose of the flange."""
        data = self.model.createData()
        pin.framesForwardKinematics(self.model, data, q)
        return data.oMf[self.flange].homogeneous

    def jacobian(self, q: Array, frame: int) -> Array:
        """(6, n) velocity of the frame's origin over angular velocity, in the base frame."""
        data = self.model.createData()
        jacobian = pin.computeFrameJacobian(
            self.model, data, q, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return jacobian.reshape(6, -1)  # a single column comes without its axis

    def regressor(self, q: Array, wrench: Array, tool: Tool) -> Array:
        """(3K + 3, n) position rows of every marker and the rotation rows, paper eq. (4)."""
        generalised = self.jacobian(q, self.at(tool.load_point)).T @ wrench
        jacobians = [self.jacobian(q, self.at(marker)) for marker in tool.markers]
        rows = [jacobian[:3] for jacobian in jacobians] + [jacobians[0][3:]]
        return np.vstack(rows) * generalised


def chain_with_springs(robot: Robot, springs: VirtualJoints) -> tuple[Robot, list[int], list[int]]:
    """The arm with every virtual joint made an actuated one, held at zero.

    Returns:
        The longer chain, and where its virtual and its actuated joints are.
    """
    joints: list[Joint] = []
    virtual: list[int] = []
    actuated: list[int] = []
    z = np.array([0.0, 0.0, 1.0])
    for body in range(len(robot.joints) + 1):
        back = np.eye(4)
        for j in np.flatnonzero(springs.body == body):
            virtual.append(len(joints))
            place = transform(None, springs.origin[j])
            joints.append(
                Joint(f"spring {j}", back @ place, springs.axis[j], bool(springs.prismatic[j]))
            )
            back = np.linalg.inv(place)
        link = back @ robot.links[body]
        if body < len(robot.joints):
            actuated.append(len(joints))
            joint = robot.joints[body]
            joints.append(Joint(joint.name, link, z, joint.prismatic))
    return Robot("with springs", tuple(joints), link), virtual, actuated


def central_difference(
    function: Callable[[Array], Array], x: Array, *, step: float = 1e-3
) -> Array:
    """Gradient of a scalar function of N points (N, d) -> (N,), by a five-point stencil.

    Its error is step⁴/30 times the fifth derivative, about 1e-13 here, and the rounding of the
    values over the step, about 1e-12: well below the 1e-8 that is asked for.
    """
    gradient = np.zeros_like(x)
    for i in range(x.shape[1]):
        shift = np.zeros(x.shape[1])
        shift[i] = step
        near = function(x + shift) - function(x - shift)
        far = function(x + 2 * shift) - function(x - 2 * shift)
        gradient[:, i] = (8.0 * near - far) / (12.0 * step)
    return gradient
