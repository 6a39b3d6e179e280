"""Solids: triangles of the few bodies a robot is drawn with.

In: points [m]. Out: `Mesh`. A robot is a union of tubes; no mesh file is needed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.robot.rotations import frame_about


@dataclass(frozen=True)
class Mesh:
    """Triangles.

    Attributes:
        vertices: (V, 3) points [m].
        triangles: (T, 3) indices of their corners.
    """

    vertices: Array
    triangles: IntArray


def union(solids: Iterable[Mesh]) -> Mesh:
    """All triangles of several solids as one."""
    vertices: list[Array] = [np.zeros((0, 3))]
    triangles: list[IntArray] = [np.zeros((0, 3), dtype=np.int64)]
    count = 0
    for solid in solids:
        vertices.append(solid.vertices)
        triangles.append(solid.triangles + count)
        count += len(solid.vertices)
    return Mesh(np.vstack(vertices), np.vstack(triangles))


def tube(
    start: Array, end: Array, radius: float, tip: float | None = None, sides: int = 14
) -> Mesh:
    """Closed tube between two points, of radius `tip` at its end (0: a cone) [m]."""
    around = circle(end - start, sides)
    rings = [start + radius * around, end + (radius if tip is None else tip) * around]
    # Caps have corners of their own: shared ones would make flat ends look round.
    vertices = np.vstack([*rings, *rings])
    i = np.arange(sides)
    j = (i + 1) % sides
    side = [np.column_stack([i, j, j + sides]), np.column_stack([i, j + sides, i + sides])]
    fan = np.column_stack([np.zeros(sides - 2, dtype=np.int64), i[1:-1], i[2:]])
    caps = [fan[:, ::-1] + 2 * sides, fan + 3 * sides]
    return Mesh(vertices, np.vstack([*side, *caps]))


def ball(centre: Array, radius: float) -> Mesh:
    """A small round body [m]."""
    levels = np.linspace(-np.pi / 2, np.pi / 2, 9)
    up = np.array([0.0, 0.0, radius])
    return union(
        tube(
            centre + np.sin(a) * up,
            centre + np.sin(b) * up,
            radius * float(np.cos(a)),
            radius * float(np.cos(b)),
            12,
        )
        for a, b in pairwise(levels)
    )


def sphere(centre: Array, radius: float) -> Mesh:
    """A round body without inner walls, to be looked through [m]."""
    rings, sides = 10, 18
    polar, turn = np.meshgrid(
        np.linspace(0.0, np.pi, rings + 1), np.linspace(0.0, 2.0 * np.pi, sides + 1), indexing="ij"
    )
    unit = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], -1)
    i, j = np.meshgrid(np.arange(rings), np.arange(sides), indexing="ij")
    a = (i * (sides + 1) + j).ravel()
    b, below = a + 1, a + sides + 1
    corners = np.vstack([np.column_stack([a, b, below]), np.column_stack([b, below + 1, below])])
    return Mesh(centre + radius * unit.reshape(-1, 3), corners)


def arrow(start: Array, along: Array, radius: float) -> Mesh:
    """Arrow from `start` to `start + along` [m]; nothing if it has no length."""
    length = float(np.linalg.norm(along))
    if length < 4.0 * radius:
        return union([])
    neck = start + along * (1.0 - 7.0 * radius / max(length, 14.0 * radius))
    return union([tube(start, neck, radius), tube(neck, start + along, 2.6 * radius, 0.0)])


def circle(normal: Array, sides: int) -> Array:
    """(sides, 3) unit vectors square to `normal`, once around it."""
    x, y, _ = (0.0 - frame_about(normal / np.linalg.norm(normal))).T  # no zero becomes −0
    angles = 2.0 * np.pi * np.arange(sides) / sides
    return np.outer(np.cos(angles), x) + np.outer(np.sin(angles), y)
