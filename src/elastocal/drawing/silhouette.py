"""Silhouettes: the outlines of simple solids in a parallel view.

In: shapes, and where their bodies are. Out: points whose hull is the solid. Meshes are not opened.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape

_AROUND = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


def solid_points(shape: Shape, posture: Posture, i: int) -> Array:
    """(K, 3) points in the base frame [m] whose hull is the shape; none of a mesh."""
    local = np.c_[_local(shape), np.ones(len(_local(shape)))] @ shape.pose.T
    frame = posture.bodies[shape.body][:, :, i]
    return np.asarray(local @ frame)


def hull(points: Array) -> Array:
    """(K, 2) corners of the convex hull of points in the plane, in order.

    Source: Andrew, Information Processing Letters 9 (1979) 216.
    """
    ordered = sorted({(round(float(x), 2), round(float(y), 2)) for x, y in points})
    if len(ordered) < 3:
        return np.array(ordered).reshape(-1, 2)
    halves = []
    for run in (ordered, ordered[::-1]):
        half: list[tuple[float, float]] = []
        for point in run:
            while len(half) > 1 and _turn(half[-2], half[-1], point) <= 0.0:
                half.pop()
            half.append(point)
        halves.append(half[:-1])
    return np.array(halves[0] + halves[1])


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Twice the area of the triangle; positive if it turns left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _local(shape: Shape) -> Array:
    """(K, 3) points in the frame of the shape."""
    circle = np.c_[np.cos(_AROUND), np.sin(_AROUND)]
    if shape.kind == "box":
        return np.array(list(product([-0.5, 0.5], repeat=3))) * shape.size
    if shape.kind == "cylinder":
        radius, length = shape.size
        return np.vstack(
            [np.c_[radius * circle, np.full(24, z)] for z in (-length / 2, length / 2)]
        )
    if shape.kind in ("sphere", "capsule"):
        half = shape.size[1] / 2 if shape.kind == "capsule" else 0.0
        rings = [
            np.c_[np.cos(a) * circle, np.full(24, np.sin(a))] * shape.size[0]
            + [0.0, 0.0, half * (1.0 if a > 0.0 else -1.0)]
            for a in np.linspace(-np.pi / 2, np.pi / 2, 10)
        ]
        return np.vstack(rings)
    return np.zeros((0, 3))
