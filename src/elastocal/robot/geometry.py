"""Geometric errors: how far the joint axes of a robot are from where its drawing has them.

Behind every joint of the chain a small transform is put,

    Rot_z(theta) Trans_z(d) · C · Trans_x(a) Rot_x(alpha) Rot_y(beta) · C⁻¹

z along the axis of the joint, C the frame on the next axis whose x is the common normal of both,
in the sense of the x of that joint as drawn: of a table what is added to a row.
These are the four numbers of a row of Denavit and Hartenberg, for a robot from any source, and the
one more that parallel axes need. What turns or shifts a joint's own value is its zero.

Source: Hayati (1983) for beta; Denavit & Hartenberg (1955); the general chain is ours.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.robot.chain import Robot, T_body_joint, transform
from elastocal.robot.joint_kinds import JointKind, kind_of

ZEROS, LENGTHS, ANGLES = "zeros", "lengths", "angles"
GROUPS = (ZEROS, LENGTHS, ANGLES)
"""What geometric errors there are, in the order in which they are looked at."""

_STEPS = ("theta", "d", "a", "alpha", "beta")
_TURNS = {"theta", "alpha", "beta"}
_ACROSS = 1e-6  # cosine up to which an x says nothing of the sense of a common normal
_PARALLEL = 2e-2  # sine of the angle up to which the common normal is hardly known


@dataclass(frozen=True)
class GeometricErrors:
    """G small displacements behind the joints of a robot.

    Attributes:
        names: What they are called: "zero A2", "a A2".
        step: (G,) which factor of the small transform each is: 0 theta, 1 d, 2 a, 3 alpha, 4 beta.
        body: (G,) number of the body that carries it, which its joint moves.
        normals: (m + 1, 4, 4) frame C of every body of the chain, in the frame of that body [m].
        shifts: (m + 1,) how far along their axes these frames stand from those of the joints [m].
    """

    names: tuple[str, ...]
    step: IntArray
    body: IntArray
    normals: Array
    shifts: Array

    def __post_init__(self) -> None:
        freeze(self, "step", "body", dtype=np.int64)
        freeze(self, "normals", "shifts")

    def __len__(self) -> int:
        return len(self.names)

    @property
    def kinds(self) -> tuple[JointKind, ...]:
        """Whether each is an angle or a length."""
        return tuple(kind_of(_STEPS[step] not in _TURNS) for step in self.step.tolist())


def geometric_errors(robot: Robot, groups: Collection[str] = GROUPS) -> GeometricErrors:
    """The errors that a robot may have, in chain order.

    Args:
        robot: The robot as drawn.
        groups: Which of them: zeros of joints, lengths, angles.
    """
    names, steps, bodies = [], [], []
    for body in range(1, robot.last + 1):
        joint = robot.moving[body - 1]
        zero = 1 if joint.prismatic else 0
        parallel = body < robot.last and _sine(robot.links[body]) < _PARALLEL
        for step, word in enumerate(_STEPS):
            if word == "beta" and not parallel:
                continue
            own = ZEROS if step == zero else ANGLES if word in _TURNS else LENGTHS
            if own in groups:
                names.append(f"{'zero' if own == ZEROS else word} {joint.name}")
                steps.append(step)
                bodies.append(body)
    normals = [np.eye(4)]
    for body in range(1, robot.last + 1):
        normals.append(_normal(robot.links[body], T_body_joint(robot, body)))
    shifts = np.append(0.0, robot.shifts[: robot.last])
    return GeometricErrors(
        tuple(names), np.array(steps), np.array(bodies), np.array(normals), shifts
    )


def group_of(errors: GeometricErrors, robot: Robot) -> tuple[str, ...]:
    """The group of each error."""
    found = []
    for step, body in zip(errors.step.tolist(), errors.body.tolist(), strict=True):
        zero = 1 if robot.moving[body - 1].prismatic else 0
        turns = _STEPS[step] in _TURNS
        found.append(ZEROS if step == zero else ANGLES if turns else LENGTHS)
    return tuple(found)


def with_errors(robot: Robot, errors: GeometricErrors, values: Array) -> Robot:
    """The robot with its axes where the errors `values`, (G,) [rad or m], put them."""
    small = small_transforms(errors, values, robot.last)
    joints = {joint.name: joint for joint in robot.moving}
    T_tip_flange = robot.T_tip_flange
    for body in range(1, robot.last + 1):
        T_joint_body = np.linalg.inv(T_body_joint(robot, body))
        change = T_joint_body @ small[body] @ T_body_joint(robot, body)
        if body == robot.last:
            T_tip_flange = change @ T_tip_flange
        else:
            joint = robot.moving[body]
            joints[joint.name] = replace(joint, T_parent_joint=change @ joint.T_parent_joint)
    changed = replace(
        robot,
        joints=tuple(joints[name] for name in robot.joint_names),
        followers=tuple(replace(f, joint=joints[f.joint.name]) for f in robot.followers),
        T_tip_flange=T_tip_flange,
    )
    if np.array_equal(changed.shifts, robot.shifts):
        return changed
    along = np.append(0.0, robot.shifts - changed.shifts)
    masses = [
        replace(m, center=m.center + np.array([0.0, 0.0, along[m.body]])) for m in robot.masses
    ]
    shapes = [
        tuple(replace(s, pose=transform(None, (0, 0, along[s.body])) @ s.pose) for s in some)
        for some in (robot.visuals, robot.collisions)
    ]
    return replace(changed, masses=tuple(masses), visuals=shapes[0], collisions=shapes[1])


def small_transforms(errors: GeometricErrors, values: Array, last: int) -> Array:
    """(m + 1, 4, 4) the small transform behind each body [m]."""
    steps = _values(errors, values, last)
    return np.array(
        [
            _before(s) @ c @ _behind(s) @ np.linalg.inv(c)
            for s, c in zip(steps, errors.normals, strict=True)
        ]
    )


def error_axes(errors: GeometricErrors, values: Array, last: int) -> tuple[Array, Array]:
    """(G, 3) axis of each error, and a point on it [m], in the frame of the body that carries it.

    About or along that axis the robot with the errors `values` moves when one of them grows.
    """
    steps = _values(errors, values, last)
    axes, points = np.zeros((len(errors), 3)), np.zeros((len(errors), 3))
    for g, (step, body) in enumerate(zip(errors.step.tolist(), errors.body.tolist(), strict=True)):
        if step < 2:
            axes[g, 2] = 1.0
            continue
        frame = _before(steps[body]) @ errors.normals[body]
        if step == 4:
            frame = frame @ _behind(steps[body] * [0, 0, 1, 1, 0])
        axes[g], points[g] = frame[:3, 1 if step == 4 else 0], frame[:3, 3]
    return axes, points


def turning(errors: GeometricErrors) -> IntArray:
    """(G,) 1 for an angle, 0 for a length."""
    return np.array([_STEPS[step] in _TURNS for step in errors.step.tolist()], dtype=np.int64)


def _values(errors: GeometricErrors, values: Array, last: int) -> Array:
    """(m + 1, 5) the values by body and step."""
    steps = np.zeros((last + 1, len(_STEPS)))
    steps[errors.body, errors.step] = values
    return steps


def _before(step: Array) -> Array:
    """(4, 4) Rot_z(theta) Trans_z(d)."""
    return transform(_turned(2, step[0]), (0.0, 0.0, step[1]))


def _behind(step: Array) -> Array:
    """(4, 4) Trans_x(a) Rot_x(alpha) Rot_y(beta)."""
    return transform(_turned(0, step[3]) @ _turned(1, step[4]), (step[2], 0.0, 0.0))


def _turned(axis: int, angle: float) -> Array:
    """(3, 3) rotation about a coordinate axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = np.cos(angle)
    matrix[j, i] = np.sin(angle)
    matrix[i, j] = -matrix[j, i]
    return matrix


def _sine(link: Array) -> float:
    """Sine of the angle between an axis and the next one."""
    return float(np.hypot(link[0, 2], link[1, 2]))


def _normal(link: Array, own: Array) -> Array:
    """(4, 4) the frame on the next axis whose x is the common normal, in the frame of a body.

    Args:
        link: (4, 4) the next joint in the frame of that body.
        own: (4, 4) its own joint as drawn in that frame. Of a table its x is that of the row:
            lengths along it may be negative, and where axes are parallel it says at which height
            the normal stands. So what is added to a number is added to that of the row.
    """
    z, point = link[:3, 2], link[:3, 3]
    sine = _sine(link)
    if sine < _PARALLEL:
        x = np.array([point[0], point[1], 0.0])
        size = float(np.linalg.norm(x))
        x = x / size if size > 1e-9 else link[:3, 0]  # else the axes are one: any will do
        x = x - z * (x @ z)
        x /= np.linalg.norm(x)
        point = point + z * (own[2, 3] - point[2]) / z[2]
    else:
        x = np.cross([0.0, 0.0, 1.0], z) / sine
        # Both axes are met by the normal: point + t z has no part along the other direction.
        across = np.cross(x, [0.0, 0.0, 1.0])
        point = point - z * (across @ point) / (across @ z)
    along = float(x @ own[:3, 0])
    if (along if abs(along) > _ACROSS else float(x @ link[:3, 0])) < 0.0:
        x = -x
    return transform(np.column_stack([x, np.cross(z, x), z]), point)
