"""What a statement speaks of, by products of exponentials: rows, sensitivity, constraints.

Plain NumPy over a batch of points x, no derivative. The compiled core and the tables of third
derivatives are held against it, and it against the rest of the program.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.proof.cones import largest_in_cone
from elastocal.proof.roots import whole_turns
from elastocal.proof.statement import (
    AnyDirection,
    DirectionOverPlane,
    PointOverPlane,
    ProofConstraint,
    Statement,
    SteadyLoad,
)
from elastocal.robot.rotations import from_rotation_vectors

_CHUNK = 8192  # points whose rows are made at once


class ArmAt:
    """The arm of a statement at N points x, (N, n).

    Attributes:
        turns: n + 1 rotations (N, 3, 3) that the bodies have made since the zero configuration.
        shifts: n + 1 translations (N, 3) likewise [m]: what was at p is at R p + t.
    """

    def __init__(self, statement: Statement, x: Array) -> None:
        q = x @ statement.mix.T
        self.turns = [np.broadcast_to(np.eye(3), (len(q), 3, 3))]
        self.shifts: list[Array] = [np.zeros((len(q), 3))]
        joints = statement.joints
        for i in range(len(joints)):
            axis, R, t = joints.axis[i], self.turns[-1], self.shifts[-1]
            turn, step = np.eye(3), q[:, i, None] * axis
            if not joints.slides[i]:
                turn = from_rotation_vectors(q[:, i, None] * axis)
                step = joints.point[i] - turn @ joints.point[i]
            self.turns.append(R @ turn)
            self.shifts.append(t + (R @ step[:, :, None])[:, :, 0])

    def point(self, at: Array, body: int = -1) -> Array:
        """(N, 3) where a point of a body is, that is at (3,) in the zero configuration [m]."""
        return np.asarray(self.turns[body] @ at + self.shifts[body])

    def direction(self, along: Array, body: int = -1) -> Array:
        """(N, 3) where a direction of a body points, (3,) in the zero configuration."""
        return np.asarray(self.turns[body] @ along)


def rows(statement: Statement, x: Array) -> Array:
    """B(x) = A(x) V over the noise, at N points x, (N, n).

    Returns:
        (N, rows, r) for a steady load; (N, rows, r, k) for a free one, for each of the k columns
        of `Statement.directions`. Three rows a marker, then three of the rotation if it is read.
    """
    parts = [_rows(statement, x[i : i + _CHUNK]) for i in range(0, max(len(x), 1), _CHUNK)]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _rows(s: Statement, x: Array) -> Array:
    moved, pulled = _parts(s, x)
    seen, k = s.seen, pulled.shape[2]
    made = pulled[:, :, None, :] * seen[None, :, :, None]
    found = moved @ made.reshape(*pulled.shape[:2], -1)
    found = found.reshape(*moved.shape[:2], seen.shape[1], k)
    return found[..., 0] if isinstance(s.load, SteadyLoad) else found


def _parts(s: Statement, x: Array) -> tuple[Array, Array]:
    """Of each spring what it moves, (N, rows, c), over the noise, and what it bears, (N, c, k)."""
    arm, load, springs = ArmAt(s, x), s.load, s.springs
    forces = np.reshape(load.force, (3, 1)) if isinstance(load, SteadyLoad) else s.directions
    assert forces is not None
    size = 3 * len(s.markers) + 3 * (s.sigma_turn is not None)
    moved = np.zeros((len(x), size, len(springs)))
    pulled = np.zeros((len(x), len(springs), forces.shape[1]))
    at, ends = arm.point(load.point), [arm.point(marker) for marker in s.markers]
    for j, body in enumerate(springs.body.tolist()):
        axis, origin = arm.direction(springs.axis[j], body), arm.point(springs.point[j], body)
        slides = bool(springs.slides[j])

        def velocity(point: Array, a: Array = axis, o: Array = origin, s: bool = slides) -> Array:
            return a if s else np.cross(a, point - o)

        pulled[:, j] = velocity(at) @ forces
        if isinstance(load, SteadyLoad) and not slides:
            pulled[:, j, 0] += axis @ load.moment
        for m, end in enumerate(ends):
            moved[:, 3 * m : 3 * m + 3, j] = velocity(end) / s.sigma
        if s.sigma_turn is not None and not slides:
            moved[:, -3:, j] = axis / s.sigma_turn
    return moved, pulled


def size_of_rows(statement: Statement) -> float:
    """About how large the terms are whose sum B(x) is: Σ |v| |y| |V| over the springs, over σ.

    Where they cancel, rounding is a share of this and not of B. The largest of a few points.
    """
    s, rng = statement, np.random.default_rng(0)
    x = s.root[0] + (s.root[1] - s.root[0]) * rng.uniform(size=(32, len(s.joints)))
    moved, pulled = _parts(s, x)
    sizes = np.linalg.norm(moved, axis=1) * np.linalg.norm(pulled, axis=2)
    return float((sizes @ np.linalg.norm(s.seen, axis=1)).max())


def sensitivity(statement: Statement, x: Array, force: Array | None = None) -> Array:
    """(N,) d(x) = |B|² at points x, (N, n).

    Args:
        statement: The statement.
        x: Points.
        force: (N, 3) forces [N]; None: a steady load, or of the others the one for which d is
            largest.
    """
    load = statement.load
    if isinstance(load, SteadyLoad):
        return np.asarray((rows(statement, x) ** 2).sum(axis=(1, 2)))
    form = quadratic_form(statement, x)
    if force is not None:
        directions = statement.directions
        assert directions is not None
        u = np.linalg.lstsq(directions, force.T, rcond=None)[0]
        return np.einsum("kn,nkl,ln->n", u, form, u)
    if isinstance(load, AnyDirection):
        return np.asarray(np.linalg.eigvalsh(form)[:, -1])
    return largest_in_cone(form, load.axis, load.half_angle)[0]


def quadratic_form(statement: Statement, x: Array) -> Array:
    """(N, k, k) Q so that d = uᵀ Q u for the force that u combines of `Statement.directions`."""
    columns = rows(statement, x)
    columns = columns.reshape(len(x), -1, columns.shape[-1])
    return np.asarray(columns.transpose(0, 2, 1) @ columns)


def best_force(statement: Statement, x: Array) -> Array:
    """(N, 3) allowed forces for which d is largest at points x, (N, n) [N]."""
    load = statement.load
    if isinstance(load, SteadyLoad):
        return np.tile(load.force, (len(x), 1))
    form = quadratic_form(statement, x)
    if isinstance(load, AnyDirection):
        u = np.linalg.eigh(form)[1][:, :, -1]
    else:
        u = largest_in_cone(form, load.axis, load.half_angle)[1]
    directions = statement.directions
    assert directions is not None
    return np.asarray(u @ directions.T)


def margins(statement: Statement, x: Array) -> Array:
    """(N, C) values of the constraints at points x, (N, n); feasible where all are ≥ 0."""
    arm = ArmAt(statement, x)
    found = [value_of(constraint, arm) for constraint in statement.constraints]
    return np.array(found).reshape(len(found), len(x)).T


def value_of(constraint: ProofConstraint, arm: ArmAt) -> Array:
    """(N,) values of a constraint."""
    if isinstance(constraint, DirectionOverPlane):
        return np.asarray(arm.direction(constraint.axis) @ constraint.normal - constraint.offset)
    point = arm.point(constraint.point)
    if isinstance(constraint, PointOverPlane):
        return np.asarray(point @ constraint.normal - constraint.offset)
    square = (point - constraint.center) ** 2 @ constraint.weights
    return np.asarray(constraint.sign * (square - constraint.bound**2))


def within(statement: Statement, x: Array) -> Array:
    """(N, 2n) room of the joints to their limits [rad or m] at points x; lower ones first.

    Of a joint that turns by 2π or more only the remainder of its value counts: there is room.
    """
    joints = statement.joints
    q = x @ statement.mix.T
    room = np.concatenate([q - joints.lower, joints.upper - q], axis=1)
    return np.where(np.tile(whole_turns(joints), 2), np.inf, room)
