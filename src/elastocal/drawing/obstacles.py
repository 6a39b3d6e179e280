"""Obstacles: what stands in the cell, as something one can see in the scene.

In: a clearance. Out: a translucent solid with its outline. A mesh is drawn as what is kept clear
of: the hulls of its parts.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Clearance
from elastocal.constraints.collision.mesh import hulls
from elastocal.drawing.solids import Mesh, ball, circle, tube, union
from elastocal.robot.shapes import Shape

OPACITY = 0.35


def solid_of(shape: Shape) -> tuple[Mesh, tuple[Array, ...]]:
    """Triangles of an obstacle in the base frame [m], and polylines (., 3) that outline it."""
    body, lines = _LOOKS[shape.kind](shape)
    rotation, origin = shape.pose[:3, :3], shape.pose[:3, 3]
    placed = Mesh(body.vertices @ rotation.T + origin, body.triangles)
    return placed, tuple(line @ rotation.T + origin for line in lines)


def top_of(solid: Mesh) -> Array:
    """(3,) where the name of an obstacle is written [m]: over its middle."""
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    return np.array([(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0, high[2]])


def corners(constraint: Clearance) -> Array:
    """(., 3) points that an obstacle covers [m], one of a floor; none for the robot itself."""
    if constraint.height is not None:
        return np.array([[0.0, 0.0, constraint.height]])
    if constraint.obstacle is None:
        return np.zeros((0, 3))
    return solid_of(constraint.obstacle)[0].vertices


def _box(shape: Shape) -> tuple[Mesh, list[Array]]:
    half = np.array(shape.size) / 2.0
    points = half * (2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1.0)
    return _hull(points), [points[list(ring)] for ring in _EDGES]


_EDGES = ((0, 1, 3, 2, 0), (4, 5, 7, 6, 4), (0, 4), (1, 5), (2, 6), (3, 7))


def _cylinder(shape: Shape) -> tuple[Mesh, list[Array]]:
    radius, length = map(float, shape.size)
    end = np.array([0.0, 0.0, length / 2.0])
    rim = radius * circle(np.array([0.0, 0.0, 1.0]), 32)
    rings = [np.vstack([rim, rim[:1]]) + side * end for side in (-1.0, 1.0)]
    return tube(-end, end, radius, sides=32), rings


def _capsule(shape: Shape) -> tuple[Mesh, list[Array]]:
    body, rings = _cylinder(shape)
    radius, length = map(float, shape.size)
    end = np.array([0.0, 0.0, length / 2.0])
    return union([body, ball(-end, radius), ball(end, radius)]), rings


def _sphere(shape: Shape) -> tuple[Mesh, list[Array]]:
    radius = float(shape.size[0])
    rings = [radius * circle(axis, 32) for axis in np.eye(3)]
    return ball(np.zeros(3), radius), [np.vstack([ring, ring[:1]]) for ring in rings]


def _mesh(shape: Shape) -> tuple[Mesh, list[Array]]:
    return union(_hull(points) for points in hulls(shape)), []


def _hull(points: Array) -> Mesh:
    from scipy.spatial import ConvexHull

    return Mesh(points, ConvexHull(points).simplices.astype(np.int64))


_LOOKS = {
    "box": _box,
    "cylinder": _cylinder,
    "capsule": _capsule,
    "sphere": _sphere,
    "mesh": _mesh,
}
