"""Where a fit to absolute readings starts: from nothing that anybody guessed.

With the arm as drawn, p = R (F_i x + f_i) + t, where F_i, f_i is the flange of pose i: for a given
rotation R of the base everything else is linear least squares. Three numbers are left, and a few
dozen starts over all rotations find the best of them. Source: ours; variable projection.
"""

from __future__ import annotations

import itertools

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.rotations import from_rotation_vectors

_MOST_POSES = 400
_STEPS = 30


def placed(flange: Array, seen: Array) -> tuple[Array, Array, float]:
    """Pose of the base in the frame of a station, and the reflector, that fit best.

    Args:
        flange: (N, 4, 4) T_base_flange of the arm as drawn [m].
        seen: (N, 3) where one reflector was read, frame of the station [m].

    Returns:
        (4, 4) T_station_base [m], (3,) reflector in the flange frame [m], and the root mean square
        of what is left of a reading [m].
    """
    if len(flange) > _MOST_POSES:
        some = np.linspace(0, len(flange) - 1, _MOST_POSES).astype(int)
        flange, seen = flange[some], seen[some]
    # R' p - f = F x + s, with s = R' t: the part of R' p - f outside the span of [F, 1] is left.
    span = np.concatenate([flange[:, :3, :3], np.tile(np.eye(3), (len(flange), 1, 1))], axis=2)
    q, triangle = np.linalg.qr(span.reshape(-1, 6))
    size = np.abs(np.diagonal(triangle))
    q = q[:, size > 1e-9 * size.max()]
    best, left = np.eye(3), np.inf
    for start in _cube():
        turn, open_ = _descended(start, flange[:, :3, 3], seen, q)
        if open_ < left:
            best, left = turn, open_
    values = seen @ best.T - flange[:, :3, 3]
    solved = np.linalg.lstsq(span.reshape(-1, 6), values.reshape(-1), rcond=1e-9)[0]
    T = np.eye(4)
    T[:3, :3] = best.T
    T[:3, 3] = best.T @ solved[3:]
    return T, solved[:3], float(np.sqrt(left / len(seen)))


def _descended(turn: Array, flange: Array, seen: Array, q: Array) -> tuple[Array, float]:
    """Gauss-Newton over rotations R' from `turn`: rotation and sum of squares."""

    def outside(values: Array) -> Array:
        flat = values.reshape(len(q), -1)
        return np.asarray(flat - q @ (q.T @ flat))

    damping, moved = 1e-3, seen @ turn.T
    open_ = outside(moved - flange)
    size = float((open_**2).sum())
    for _ in range(_STEPS):
        arms = np.stack([np.cross(axis, moved) for axis in np.eye(3)], axis=-1)
        rows = outside(arms)
        normal, gradient = rows.T @ rows, rows.T @ open_[:, 0]
        step = -np.linalg.solve(normal + damping * (np.trace(normal) + 1e-12) * np.eye(3), gradient)
        tried = from_rotation_vectors(step[None])[0] @ turn
        there = seen @ tried.T
        left = outside(there - flange)
        now = float((left**2).sum())
        if now < size:
            done = size - now < 1e-12 * size
            turn, moved, open_, size, damping = tried, there, left, now, damping / 5.0
            if done:
                break
        else:
            damping *= 4.0
            if damping > 1e6:
                break
    return turn, size


def _cube() -> list[Array]:
    """The 24 rotations of a cube."""
    found = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            matrix = np.zeros((3, 3))
            matrix[range(3), order] = signs
            if np.linalg.det(matrix) > 0.0:
                found.append(matrix)
    return found
