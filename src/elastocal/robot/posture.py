"""Posture: where every joint axis and body of a robot is, for a batch of configurations.

One pass through the chain serves forward kinematics, Jacobians, regressors and constraints.
Inside this file and `elastic/regressor.py` the batch axis is the last one in memory: every
operation then runs over N contiguous numbers, which is what makes NumPy fast here.
Vectors are stored component first: (3, n, N) are n vectors in each of N configurations, so
that a cross product works on three contiguous blocks. A body frame is stored as X, (4, 3, N):
its x, y, z axes and its origin, in the base frame; a fixed transform T to the next frame is
then the one product TᵀX.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.robot.chain import Robot


class Posture:
    """A robot in N configurations.

    Attributes:
        robot: The robot.
        q: (n, N) configurations [rad or m].
        axes: (3, n, N) joint axes in the base frame.
        origins: (3, n, N) points on the joint axes [m].
        all_axes: (3, n + F, N) axes of all joints that move, as in `robot.moving`.
        all_origins: (3, n + F, N) likewise.
        bodies: n + F + 2 arrays (4, 3, N): base, bodies after each joint and follower, flange.
    """

    def __init__(self, robot: Robot, q: Array) -> None:
        """Place `robot` in the configurations `q`, (N, n) [rad or m]."""
        q = np.asarray(q, dtype=float).T
        self.q = q
        n, count = q.shape
        last, carriers = robot.last, robot.carriers.tolist()
        self.robot = robot
        values = q
        if robot.followers:
            values = robot.mixing @ q + robot.standing[:, None]
        self.all_axes = np.empty((3, len(values), count))
        self.all_origins = np.empty((3, len(values), count))
        cosine, sine = np.cos(values), np.sin(values)
        body = np.zeros((4, 3, count))
        body[0, 0] = body[1, 1] = body[2, 2] = 1.0
        self.bodies = [body]
        for i, joint in enumerate(robot.moving):
            link = robot.links[i] if i < last else robot.branches[i - last]
            frame = _attached(link, self.bodies[carriers[i + 1]])
            self.all_axes[:, i], self.all_origins[:, i] = frame[2], frame[3]
            body = np.empty_like(frame)
            body[2] = frame[2]
            if joint.prismatic:
                body[:2] = frame[:2]
                np.multiply(frame[2], values[i], out=body[3])
                body[3] += frame[3]
            else:
                np.multiply(frame[:2], cosine[i], out=body[:2])
                frame[:2] *= sine[i]
                body[0] += frame[1]
                body[1] -= frame[0]
                body[3] = frame[3]
            self.bodies.append(body)
        own = robot.place if robot.follows else slice(n)
        self.axes, self.origins = self.all_axes[:, own], self.all_origins[:, own]
        self.bodies.append(_attached(robot.links[last], self.bodies[last]))
        self._points: dict[tuple[int, bytes], Array] = {}
        self._jacobians: list[tuple[Array, Array]] = []

    @property
    def count(self) -> int:
        """Number of configurations N."""
        return int(self.axes.shape[2])

    def point(self, local: Array, body: int = -1) -> Array:
        """(3, N) position in the base frame of a point given in a body's frame [m]."""
        key = (body, local.tobytes())  # regressor and constraints ask for the same few points
        if key not in self._points:
            frame = self.bodies[body]
            self._points[key] = _combined(local, frame) + frame[3]
        return self._points[key]

    def direction(self, local: Array, body: int = -1) -> Array:
        """(3, N) direction in the base frame of a direction given in a body's frame."""
        return _combined(local, self.bodies[body])

    def point_jacobian(self, point: Array) -> Array:
        """(3, n, N) velocity of a flange point (3, N) for a unit velocity of each joint."""
        for known, velocity in self._jacobians:
            if known is point:  # constraints and instrument ask for the same marker
                return velocity
        m = self.robot.last
        axes, origins = self.all_axes[:, :m], self.all_origins[:, :m]
        velocity = velocities(axes, point[:, None] - origins, self.robot.sliding[:m])
        if self.robot.follows:
            velocity = np.einsum("mj,cmN->cjN", self.robot.mixing[:m], velocity)
        self._jacobians.append((point, velocity))
        return velocity

    def pull_point(self, point: Array, cotangent: Array) -> Array:
        """(n, N) gradient in q of a scalar with gradient `cotangent` (3, N) in a flange point."""
        return dot(self.point_jacobian(point), cotangent[:, None])

    def pull_carried(self, which: IntArray, *moved: tuple[Array, IntArray, Array]) -> Array:
        """(n, N) gradient in q of a scalar that depends on points of moving bodies.

        Args:
            which: (K,) configurations in which it does.
            moved: Points (3, K) [m], the bodies (K,) to which they are fixed, and the gradient
                (3, K) of the scalar in them.
        """
        robot = self.robot
        axes, origins = self.all_axes[:, :, which], self.all_origins[:, :, which]
        total = np.zeros((axes.shape[1], len(which)))
        for point, body, cotangent in moved:
            velocity = velocities(axes, point[:, None] - origins, robot.sliding)
            total += np.where(robot.carries[body].T, dot(velocity, cotangent[:, None]), 0.0)
        gradient = np.zeros_like(self.q)
        gradient[:, which] = robot.mixing.T @ total if robot.followers else total
        return gradient

    def pull_direction(self, direction: Array, cotangent: Array) -> Array:
        """(n, N) gradient in q of a scalar with gradient `cotangent` in a flange direction."""
        return dot(self.turns, cross(direction, cotangent)[:, None])

    @property
    def turns(self) -> Array:
        """(3, n, N) angular velocity of the flange for a unit velocity of each joint."""
        m = self.robot.last
        turns = self.all_axes[:, :m].copy()
        turns[:, self.robot.sliding[:m]] = 0.0
        if self.robot.follows:
            turns = np.einsum("mj,cmN->cjN", self.robot.mixing[:m], turns)
        return turns


def flange_axes(posture: Posture) -> Array:
    """(N, 3, 3) axes of the flange in the base frame, as columns."""
    return np.ascontiguousarray(posture.bodies[-1][:3].transpose(2, 1, 0))


def forward_kinematics(robot: Robot, q: Array) -> Array:
    """T_base_flange, (N, 4, 4) [m], of N configurations `q`, (N, n) [rad or m]."""
    posture = Posture(robot, q)
    transforms = np.zeros((posture.count, 4, 4))
    transforms[:, :3, :] = posture.bodies[-1].transpose(2, 1, 0)
    transforms[:, 3, 3] = 1.0
    return transforms


def jacobian(robot: Robot, q: Array, point: Array | None = None) -> Array:
    """Geometric Jacobian at a point of the flange body.

    Args:
        robot: Robot with n joints.
        q: (N, n) configurations [rad or m].
        point: (3,) point in the flange frame [m]; the flange origin if None.

    Returns:
        (N, 6, n): velocity of the point over angular velocity, in the base frame.
    """
    posture = Posture(robot, q)
    at = posture.point(np.zeros(3) if point is None else np.asarray(point, dtype=float))
    result = np.zeros((posture.count, 6, len(robot.joints)))
    result[:, :3, :] = posture.point_jacobian(at).transpose(2, 0, 1)
    result[:, 3:, :] = posture.turns.transpose(2, 0, 1)
    return result


def velocities(axes: Array, arms: Array, slides: BoolArray) -> Array:
    """(3, n, N) velocity that a unit speed of each of n joints gives to a point.

    Args:
        axes: (3, n, N) axes of the joints.
        arms: (3, n, N) the point, seen from a point on each axis [m].
        slides: (n,) joints that slide along their axis.
    """
    velocity = cross(axes, arms)
    if slides.any():
        velocity[:, slides] = axes[:, slides]
    return velocity


def cross(a: Array, b: Array) -> Array:
    """Cross product along the first axis, (3, ...)."""
    (a0, a1, a2), (b0, b1, b2) = a, b
    result = np.empty((3, *np.broadcast(a0, b0).shape))
    x, y, z = result
    np.multiply(a1, b2, out=x)
    x -= a2 * b1
    np.multiply(a2, b0, out=y)
    y -= a0 * b2
    np.multiply(a0, b1, out=z)
    z -= a1 * b0
    return result


def dot(a: Array, b: Array) -> Array:
    """Scalar product along the first axis, (3, ...)."""
    result = a[0] * b[0]
    result += a[1] * b[1]
    result += a[2] * b[2]
    return result


def _combined(local: Array, frame: Array) -> Array:
    """(3, N) local[0] x + local[1] y + local[2] z of a frame (4, 3, N)."""
    return (local @ frame[:3].reshape(3, -1)).reshape(3, -1)


def _attached(link: Array, body: Array) -> Array:
    """Frame fixed to `body` by the transform `link`, (4, 3, N)."""
    return (link.T @ body.reshape(4, -1)).reshape(body.shape)
