"""Shapes as triangles: boxes, cylinders, spheres, capsules, meshes.

In: `Shape`. Out: `Mesh` in the frame of its body.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.collision.mesh import triangles
from elastocal.drawing.solids import Mesh, tube
from elastocal.robot.shapes import Shape

_CORNERS = np.indices((2, 2, 2)).reshape(3, 8).T - 0.5
_FACES = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)


def solid_of(shape: Shape) -> Mesh:
    """The triangles of a shape [m], in the frame of its body.

    Raises:
        InputError: the file of a mesh cannot be used.
    """
    own = Mesh(*triangles(shape)) if shape.kind == "mesh" else _simple(shape.kind, shape.size)
    return Mesh(own.vertices @ shape.pose[:3, :3].T + shape.pose[:3, 3], own.triangles)


def _simple(kind: str, size: Array) -> Mesh:
    if kind == "box":
        return box(size)
    if kind == "sphere":
        return capsule(float(size[0]), 0.0)
    if kind == "capsule":
        return capsule(float(size[0]), float(size[1]))
    half = np.array([0.0, 0.0, size[1] / 2.0])
    return tube(-half, half, float(size[0]), sides=36)


def box(size: Array) -> Mesh:
    """A box about the origin with sides (3,) [m]; corners are not shared, so faces are flat."""
    vertices = (_CORNERS * size)[_FACES].reshape(24, 3)
    first = 4 * np.arange(6)[:, None]
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    return Mesh(vertices, np.vstack([first + half for half in halves]))


def round_ball(centre: Array, radius: float) -> Mesh:
    """A ball without inner walls: with them shadows leave stripes [m]."""
    own = capsule(radius, 0.0, 20)
    return Mesh(own.vertices + centre, own.triangles)


def capsule(radius: float, length: float, sides: int = 28) -> Mesh:
    """A round rod along z: `length` between the centres of its ends [m]; a ball if that is 0."""
    rings = np.linspace(0.0, np.pi / 2.0, 8)
    polar = np.concatenate([rings, np.pi - rings[::-1]])
    lift = np.where(polar <= np.pi / 2.0, 0.5, -0.5) * length
    lift[len(rings) :] = -0.5 * length
    turn = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    around = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    flat = radius * np.sin(polar)[:, None, None] * around
    height = np.broadcast_to((radius * np.cos(polar) + lift)[:, None, None], (*flat.shape[:2], 1))
    vertices = np.concatenate([flat, height], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(len(polar) - 1), np.arange(sides), indexing="ij")
    a = (i * (sides + 1) + j).ravel()
    b, below = a + 1, a + sides + 1
    corners = [np.column_stack([a, below, b]), np.column_stack([b, below, below + 1])]
    return Mesh(vertices, np.vstack(corners))
