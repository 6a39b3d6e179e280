"""Robots from Denavit-Hartenberg tables, classic or modified."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.chain import Joint, Robot, T_body_joint
from elastocal.robot.shapes import BodyMass


@dataclass(frozen=True)
class DHRow:
    """One joint of a table.

    Attributes:
        name: Joint name.
        theta: Angle about z, without the joint value of a revolute joint [rad].
        d: Offset along z, without the joint value of a prismatic joint [m].
        a: Length along x [m].
        alpha: Twist about x [rad].
        prismatic: Whether the joint slides along z.
        sign: +1, or -1 if a positive joint value turns the other way.
        lower: Lower limit of the joint value [rad or m].
        upper: Upper limit.
        mass: Mass that moves with this joint [kg], 0 if not known.
        center: Its centre in the frame after the row [m].
    """

    name: str
    theta: float
    d: float
    a: float
    alpha: float
    prismatic: bool = False
    sign: float = 1.0
    lower: float = -np.inf
    upper: float = np.inf
    mass: float = 0.0
    center: tuple[float, ...] = (0.0, 0.0, 0.0)


def from_dh(name: str, rows: Sequence[DHRow], *, modified: bool) -> Robot:
    """Robot of a DH table.

    Args:
        name: Name of the robot.
        rows: One row per joint, from the base.
        modified: Craig's convention Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d); else the
            classic one, Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha).

    Source: Craig, Introduction to Robotics, ch. 3; Denavit & Hartenberg (1955).
    """
    joints, T_joint_row = [], []
    before = np.eye(4)
    for row in rows:
        about_x = _screw(0, row.alpha, row.a)
        about_z = _screw(2, row.theta, row.d)
        joint_frame = before @ about_x @ about_z if modified else before @ about_z
        joints.append(
            Joint(
                row.name,
                joint_frame,
                np.array([0.0, 0.0, row.sign]),
                row.prismatic,
                row.lower,
                row.upper,
            )
        )
        before = np.eye(4) if modified else about_x
        T_joint_row.append(before)
    robot = Robot(name, tuple(joints), before)
    masses = [
        BodyMass(i, row.mass, (T_body_joint(robot, i) @ T @ [*row.center, 1.0])[:3], row.name)
        for i, (row, T) in enumerate(zip(rows, T_joint_row, strict=True), start=1)
        if row.mass
    ]
    return replace(robot, masses=tuple(masses))


def _screw(axis: int, angle: float, shift: float) -> Array:
    """Rotation about a coordinate axis with a shift along it."""
    matrix = np.eye(4)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    c, s = np.cos(angle), np.sin(angle)
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    matrix[axis, 3] = shift
    return matrix
