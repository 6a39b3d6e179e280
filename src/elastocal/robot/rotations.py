"""Rotations in the forms that files and iterations need: vectors, quaternions, KUKA's A, B, C.

Everything runs over a batch: matrices (N, 3, 3), vectors (N, 3), quaternions (N, 4) with the
scalar first. Source: textbook.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array


def quaternions(matrices: Array) -> Array:
    """(N, 4) unit quaternions w, x, y, z with w >= 0 of rotation matrices (N, 3, 3)."""
    m = np.asarray(matrices, dtype=float)
    diagonal = np.diagonal(m, axis1=1, axis2=2)
    trace = diagonal.sum(axis=1)
    # 4 q qᵀ: its row with the largest diagonal entry is a good multiple of the quaternion.
    products = np.empty((len(m), 4, 4))
    products[:, 0, 0] = 1.0 + trace
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        products[:, i + 1, i + 1] = 1.0 + 2.0 * diagonal[:, i] - trace
        products[:, 0, i + 1] = products[:, i + 1, 0] = m[:, k, j] - m[:, j, k]
        products[:, j + 1, k + 1] = products[:, k + 1, j + 1] = m[:, j, k] + m[:, k, j]
    best = np.argmax(np.diagonal(products, axis1=1, axis2=2), axis=1)
    q = products[np.arange(len(m)), best]
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return np.asarray(np.where(q[:, :1] < 0.0, -q, q))


def from_quaternions(values: Array) -> Array:
    """(N, 3, 3) rotation matrices of quaternions w, x, y, z (N, 4), normalised first."""
    q = np.asarray(values, dtype=float)
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    w, v = q[:, 0], q[:, 1:]
    outer = v[:, :, None] * v[:, None, :]
    eye = (w**2 - np.einsum("ni,ni->n", v, v))[:, None, None] * np.eye(3)
    return np.asarray(eye + 2.0 * (outer + w[:, None, None] * cross_matrices(v)))


def rotation_vectors(matrices: Array) -> Array:
    """(N, 3) axis times angle [rad], angle at most π, of rotation matrices (N, 3, 3)."""
    q = quaternions(matrices)
    size = np.linalg.norm(q[:, 1:], axis=1)
    angle = 2.0 * np.arctan2(size, q[:, 0])
    # angle over sine of the half angle tends to 2.
    factor = np.divide(angle, size, out=np.full_like(size, 2.0), where=size > 1e-300)
    return np.asarray(q[:, 1:] * factor[:, None])


def from_rotation_vectors(vectors: Array) -> Array:
    """(N, 3, 3) rotation matrices of vectors axis times angle (N, 3) [rad]."""
    v = np.asarray(vectors, dtype=float)
    half = 0.5 * np.linalg.norm(v, axis=1, keepdims=True)
    return from_quaternions(np.hstack([np.cos(half), 0.5 * v * np.sinc(half / np.pi)]))


def turned_slope(vectors: Array) -> Array:
    """(N, 3, 3) J with log(exp(dw) exp(v)) = v + J dw to first order, for vectors v (N, 3) [rad].

    The transpose is that of a turn on the other side: log(exp(v) exp(dw)) = v + Jᵀ dw.

    Source: textbook, the inverse of the left Jacobian of SO(3); angles below π.
    """
    v = np.asarray(vectors, dtype=float)
    angle = np.linalg.norm(v, axis=1)
    small = angle < 1e-2  # the closed form loses digits where the series has them all
    safe = np.where(small, 1.0, angle)
    closed = (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2
    series = 1.0 / 12.0 + angle**2 / 720.0 + angle**4 / 30240.0
    cross = cross_matrices(v)
    factor = np.where(small, series, closed)[:, None, None]
    return np.asarray(np.eye(3) - 0.5 * cross + factor * (cross @ cross))


def zyx_angles(matrices: Array) -> Array:
    """(N, 3) angles A, B, C [rad] with R = Rot_z(A) Rot_y(B) Rot_x(C), as KUKA counts."""
    m = np.asarray(matrices, dtype=float)
    level = np.hypot(m[:, 0, 0], m[:, 1, 0])
    b = np.arctan2(-m[:, 2, 0], level)
    upright = level < 1e-9  # A and C turn about the same axis: all of it goes to A
    a = np.where(upright, np.arctan2(-m[:, 0, 1], m[:, 1, 1]), np.arctan2(m[:, 1, 0], m[:, 0, 0]))
    c = np.where(upright, 0.0, np.arctan2(m[:, 2, 1], m[:, 2, 2]))
    return np.stack([a, b, c], axis=1)


def from_zyx_angles(angles: Array) -> Array:
    """(N, 3, 3) rotation matrices Rot_z(A) Rot_y(B) Rot_x(C) of angles (N, 3) [rad]."""
    zero = np.zeros(len(angles))
    a, b, c = (np.asarray(angles, dtype=float)[:, i] for i in range(3))
    turns = [
        from_rotation_vectors(np.stack(axis, axis=1))
        for axis in ((zero, zero, a), (zero, b, zero), (c, zero, zero))
    ]
    return np.asarray(turns[0] @ turns[1] @ turns[2])


def frame_about(axis: Array) -> Array:
    """(3, 3) a rotation that takes z to the unit vector `axis`, its last column."""
    helper = np.eye(3)[np.argmin(np.abs(axis))]  # the base axis that is farthest from it
    x = np.cross(helper, axis)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(axis, x), axis])


def cross_matrices(v: Array) -> Array:
    """(N, 3, 3) matrices of the cross products with v (N, 3)."""
    result = np.zeros((len(v), 3, 3))
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        result[:, k, j], result[:, j, k] = v[:, i], -v[:, i]
    return result
