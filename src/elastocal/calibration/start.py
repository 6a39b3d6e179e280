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

_MOST_POSES = 200
_STEPS = 40
_RATHER = 1e-3  # how much rather the base moves than the reflector where both do the same
_AT_REST = 1e-9  # share of the squares that a last step wins


def placed(flange: Array, seen: Array, near: Array | None = None) -> tuple[Array, Array, float]:
    """Pose of the base in the frame of a station, and the reflector, that fit best.

    Args:
        flange: (N, 4, 4) T_base_flange of the arm as drawn [m].
        seen: (N, 3) where one reflector was read, frame of the station [m].
        near: (3,) where the reflector is thought to be, for what a base does as well, such as its
            height on an arm whose axes are all upright [m]; the flange's origin if None.

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
    turns, open_ = _descended(_cube(), flange[:, :3, 3], seen, q)
    first = int(open_.argmin())
    best, left = turns[first], float(open_[first])
    near = np.zeros(3) if near is None else near
    values = seen @ best.T - flange[:, :3, 3] - flange[:, :3, :3] @ near
    weight = np.repeat([_RATHER, 1.0], 3)
    span = span.reshape(-1, 6) * weight
    solved = weight * np.linalg.lstsq(span, values.reshape(-1), rcond=1e-9)[0]
    T = np.eye(4)
    T[:3, :3] = best.T
    T[:3, 3] = best.T @ solved[3:]
    return T, near + solved[:3], float(np.sqrt(left / len(seen)))


def _descended(turns: Array, flange: Array, seen: Array, q: Array) -> tuple[Array, Array]:
    """Damped Gauss-Newton over rotations R' from B of them: (B, 3, 3), and (B,) squares [m²]."""

    def outside(values: Array) -> Array:
        """Values (B, N, 3) without what base and reflector can make of them, (B, 3N)."""
        flat = values.reshape(len(values), -1)
        return np.asarray(flat - (flat @ q) @ q.T)

    damping = np.full(len(turns), 1e-3)
    moved = seen @ turns.transpose(0, 2, 1)
    left = outside(moved - flange)
    size = (left**2).sum(axis=1)
    for _ in range(_STEPS):
        rows = np.stack([outside(np.cross(axis, moved)) for axis in np.eye(3)], axis=-1)
        normal, gradient = rows.transpose(0, 2, 1) @ rows, np.einsum("bri,br->bi", rows, left)
        more = damping * (np.trace(normal, axis1=1, axis2=2) + 1e-12)
        step = -np.linalg.solve(normal + more[:, None, None] * np.eye(3), gradient[..., None])
        tried = from_rotation_vectors(step[..., 0]) @ turns
        there = seen @ tried.transpose(0, 2, 1)
        open_ = outside(there - flange)
        now = (open_**2).sum(axis=1)
        better = now < size
        done = ~better | (size - now <= _AT_REST * size)
        turns = np.where(better[:, None, None], tried, turns)
        moved = np.where(better[:, None, None], there, moved)
        left, size = np.where(better[:, None], open_, left), np.where(better, now, size)
        damping = np.where(better, damping / 5.0, damping * 4.0)
        if done.all() and (damping[~better] > 1.0).all():
            break
    return turns, size


def _cube() -> Array:
    """(24, 3, 3) the rotations of a cube."""
    found = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            matrix = np.zeros((3, 3))
            matrix[range(3), order] = signs
            if np.linalg.det(matrix) > 0.0:
                found.append(matrix)
    return np.array(found)
