"""How a probe was turned: three angles or a quaternion as one rotation, by the convention said."""

from __future__ import annotations

from itertools import product

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.rotations import from_quaternions, from_rotation_vectors, rotation_vectors

_EULER = tuple(f"euler-{a}{b}{c}" for a, b, c in product("xyz", repeat=3) if a != b and b != c)
VECTOR, RPY = "rotation-vector", "rpy"
CONVENTIONS = (VECTOR, RPY, *_EULER)
"""rpy is Rot_z(rz) Rot_y(ry) Rot_x(rx), about fixed axes; euler-abc is Rot_a Rot_b Rot_c."""
LENGTH = 1e-3
"""By how much a quaternion may be longer or shorter than 1."""


def from_angles(angles: Array, convention: str) -> Array:
    """(R, 3) axis times angle [rad] of three angles (R, 3) [rad].

    Args:
        angles: rx, ry, rz. About three different axes each is about its own; of euler-zxz and the
            like they are the first, the second and the third.
        convention: One of `CONVENTIONS`.
    """
    if convention == VECTOR:
        return rotation_vectors(from_rotation_vectors(angles))  # the shortest of its turn
    axes = "zyx" if convention == RPY else convention.removeprefix("euler-")
    order = range(3) if len(set(axes)) < 3 else ["xyz".index(axis) for axis in axes]
    turned = np.eye(3)
    for axis, column in zip(axes, order, strict=True):
        about = np.zeros((len(angles), 3))
        about[:, "xyz".index(axis)] = angles[:, column]
        turned = turned @ from_rotation_vectors(about)
    return rotation_vectors(turned)


def from_four(values: Array) -> Array:
    """(R, 3) axis times angle [rad] of quaternions w, x, y, z (R, 4)."""
    return rotation_vectors(from_quaternions(values))
