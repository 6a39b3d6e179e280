"""The arm as CasADi expressions, built from the robot's data: regressor, constraints, objective.

Written independently of elastocal's kernel: only the robot, the springs, the tool, the load and the
constraints are read.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Constraint, Elevation, HalfSpace, MinRadius
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection
from elastocal.robot.chain import Robot
from elastocal.study.study import Study

Frame = tuple[ca.SX, ca.SX]
"""Rotation and origin in the base frame."""


def pose_function(study: Study, held: int = 1) -> ca.Function:
    """Design variables, less the first `held` -> rows (3K, p), margins (c,), equalities (e,).

    A direction has norm 1: without that its length is free, and IPOPT takes longer.
    """
    robot, e, springs = study.robot, study.experiments, study.springs
    n = len(robot.joints)
    assert e.moment.size == 0.0
    x = ca.SX.sym("x", n + e.force.variables - held)
    variables = ca.vertcat(ca.SX(held, 1), x)
    bodies, (rotation, origin) = _chain(robot, variables[:n])
    force, cone, norm = _force(e.force, variables[n:])
    load_point = origin + rotation @ ca.DM(np.array(e.tool.load_point))
    points = [origin + rotation @ ca.DM(marker) for marker in np.array(e.tool.markers)]
    columns = []
    for j in range(len(springs)):
        turn, at = bodies[int(springs.body[j])]
        axis = turn @ _sparse(springs.axis[j])
        root = at + turn @ _sparse(springs.origin[j])
        if springs.prismatic[j]:
            moved = ca.vertcat(*[axis] * len(points)) * ca.dot(axis, force)
        else:
            moved = ca.vertcat(*[ca.cross(axis, point - root) for point in points])
            moved *= ca.dot(ca.cross(axis, load_point - root), force)
        columns.append(moved)
    margins = [*(_margin(c, rotation, origin) for c in study.constraints), *cone]
    parts = [
        ca.horzcat(*columns),
        ca.vertcat(ca.SX(0, 1), *margins),
        ca.vertcat(ca.SX(0, 1), *norm),
    ]
    return ca.Function("pose", [x], parts)


def _force(load: FixedVector | FreeDirection, x: ca.SX) -> tuple[ca.SX, list[ca.SX], list[ca.SX]]:
    """Force [N], what must be >= 0 for its direction, and what must be 0."""
    if isinstance(load, FixedVector):
        return ca.SX(ca.DM(np.array(load.value))), [], []
    assert isinstance(load, FreeDirection)
    cone = [ca.dot(ca.DM(np.array(load.axis)), x) - np.cos(load.half_angle)]
    return load.largest * x, cone if load.is_cone else [], [ca.dot(x, x) - 1.0]


def _chain(robot: Robot, q: ca.SX) -> tuple[list[Frame], Frame]:
    """Frames of the bodies from the base on, whose joints turn about z, and of the flange."""
    frame: Frame = ca.SX(ca.DM.eye(3)), ca.SX(3, 1)
    bodies = [frame]
    for i, joint in enumerate(robot.joints):
        rotation, origin = _attached(robot.links[i], *frame)
        if joint.prismatic:
            frame = rotation, origin + rotation[:, 2] * q[i]
        else:
            cosine, sine = ca.cos(q[i]), ca.sin(q[i])
            turn = ca.SX(3, 3)
            turn[0, 0] = turn[1, 1] = cosine
            turn[0, 1], turn[1, 0], turn[2, 2] = -sine, sine, 1.0
            frame = rotation @ turn, origin
        bodies.append(frame)
    return bodies, _attached(robot.links[len(robot.joints)], *frame)


def _attached(link: Array, rotation: ca.SX, origin: ca.SX) -> Frame:
    return rotation @ _sparse(link[:3, :3]), origin + rotation @ _sparse(link[:3, 3])


def _sparse(values: Array) -> ca.DM:
    """A constant whose zeros are structural, so that they leave the expression graph."""
    return ca.sparsify(ca.DM(np.where(np.abs(values) < 1e-15, 0.0, values)))


def _margin(constraint: Constraint, rotation: ca.SX, origin: ca.SX) -> ca.SX:
    """A smooth function that is >= 0 where the constraint holds."""
    if isinstance(constraint, HalfSpace):
        point = origin + rotation @ ca.DM(np.array(constraint.point))
        return ca.dot(ca.DM(np.array(constraint.normal)), point) - constraint.offset
    if isinstance(constraint, MinRadius):
        point = origin + rotation @ ca.DM(np.array(constraint.point))
        return point[0] ** 2 + point[1] ** 2 - constraint.radius**2
    if isinstance(constraint, Elevation):
        rise = (rotation @ ca.DM(np.array(constraint.axis)))[2]
        return float(np.sin(constraint.limit)) ** 2 - rise**2
    raise NotImplementedError(f"no CasADi form of {type(constraint).__name__}")


def log_trace(matrix: ca.SX, rows: Array) -> ca.SX:
    """log Σ aᵀ M⁻¹ a over the rows a, by an explicit LDLᵀ factorisation of M."""
    p = matrix.shape[0]
    lower: list[list[Any]] = [[0.0] * p for _ in range(p)]
    pivot: list[Any] = []
    for j in range(p):
        pivot.append(matrix[j, j] - sum(lower[j][k] ** 2 * pivot[k] for k in range(j)))
        for i in range(j + 1, p):
            known = sum(lower[i][k] * lower[j][k] * pivot[k] for k in range(j))
            lower[i][j] = (matrix[i, j] - known) / pivot[j]
    total = ca.SX(0)
    for row in rows:
        image: list[Any] = []
        for i in range(p):
            image.append(float(row[i]) - sum(lower[i][k] * image[k] for k in range(i)))
            total += image[i] ** 2 / pivot[i]
    return ca.log(total)


def lower_part(matrix: ca.SX) -> ca.SX:
    """Entries of the lower triangle, row by row."""
    return ca.vertcat(*[matrix[i, j] for i in range(matrix.shape[0]) for j in range(i + 1)])


def symmetric(entries: ca.SX, p: int) -> ca.SX:
    """The (p, p) matrix whose lower triangle has these entries."""
    matrix = ca.SX(p, p)
    for k, (i, j) in enumerate(zip(*np.tril_indices(p), strict=True)):
        matrix[int(i), int(j)] = matrix[int(j), int(i)] = entries[k]
    return matrix
