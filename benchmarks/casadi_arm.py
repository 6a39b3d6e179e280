"""The arm as CasADi expressions, built from the robot's data: regressor, constraints, objective.

Written independently of elastocal's kernel: only the robot, the tool and the constraints are read.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Constraint, Elevation, HalfSpace, MinRadius
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.robot.chain import Robot
from elastocal.study.study import Study


def pose_function(study: Study) -> ca.Function:
    """(q2 … qn) -> regressor rows per newton of load (3K, p), constraint margins (c,)."""
    robot, e = study.robot, study.experiments
    assert isinstance(e.force, FixedVector)
    assert e.moment.size == 0.0
    assert study.springs.joint is not None
    x = ca.SX.sym("x", len(robot.joints) - 1)
    rotation, origin, axes, origins = _chain(robot, ca.vertcat(0, x))
    force = ca.DM(e.force.value / e.force.size)
    load_point = origin + rotation @ ca.DM(np.array(e.tool.load_point))
    rows = []
    for marker in np.array(e.tool.markers):
        point = origin + rotation @ ca.DM(marker)
        columns = []
        for i in study.springs.joint:
            slides = robot.joints[i].prismatic
            at_load = axes[i] if slides else ca.cross(axes[i], load_point - origins[i])
            at_marker = axes[i] if slides else ca.cross(axes[i], point - origins[i])
            columns.append(at_marker * ca.dot(at_load, force))
        rows.append(ca.horzcat(*columns))
    margins = [_margin(constraint, rotation, origin) for constraint in study.constraints]
    return ca.Function("pose", [x], [ca.vertcat(*rows), ca.vertcat(*margins)])


def _chain(robot: Robot, q: ca.SX) -> tuple[ca.SX, ca.SX, list[ca.SX], list[ca.SX]]:
    """Flange rotation and origin, joint axes and points on them, in the base frame."""
    rotation, origin = ca.SX(ca.DM.eye(3)), ca.SX(3, 1)
    axes, origins = [], []
    for i, joint in enumerate(robot.joints):
        origin, rotation = _attached(joint.T_parent_joint, origin, rotation)
        axis = np.array(joint.axis)
        axes.append(rotation @ _sparse(axis))
        if joint.prismatic:
            origin = origin + axes[-1] * q[i]
        else:
            along = np.outer(axis, axis)
            turn = np.cross(np.eye(3), axis)  # turn @ v = axis x v
            rotation = rotation @ (
                _sparse(along)
                + ca.cos(q[i]) * _sparse(np.eye(3) - along)
                + ca.sin(q[i]) * _sparse(turn)
            )
        origins.append(origin)
    origin, rotation = _attached(robot.T_tip_flange, origin, rotation)
    return rotation, origin, axes, origins


def _attached(link: Array, origin: ca.SX, rotation: ca.SX) -> tuple[ca.SX, ca.SX]:
    return origin + rotation @ _sparse(link[:3, 3]), rotation @ _sparse(link[:3, :3])


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
