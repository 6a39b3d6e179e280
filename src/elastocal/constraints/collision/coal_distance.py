"""Signed distances of two convex solids by coal, one by one; for what has no closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.constraints.collision.solid import Solid
from elastocal.errors import InputError
from elastocal.robot.posture import Posture


def coal() -> Any:
    """The module coal.

    Raises:
        InputError: it is not installed.
    """
    try:
        import coal as module
    except ImportError:
        raise InputError(
            "collision needs the package coal: pip install 'elastocal[collision]'"
        ) from None
    return module


class PairDistance:
    """Distance of two solids; keeps the geometry that coal needs."""

    def __init__(self, first: Solid, second: Solid) -> None:
        module = coal()
        self._solids = first, second
        self._request = module.DistanceRequest()
        self._request.enable_signed_distance = True
        self._request.gjk_tolerance = 1e-7
        self._request.epa_tolerance = 1e-7
        self._result = module.DistanceResult()
        self._distance = module.distance
        self._first, self._second = _geometry(module, first), _geometry(module, second)

    def __reduce__(self) -> tuple[Any, ...]:
        return PairDistance, self._solids

    def __call__(self, places: Placements, case: IntArray) -> tuple[Array, Array, Array, Array]:
        """Signed distances (K,) [m] in K postures, nearest points of both and the direction that
        parts them, (3, K) each.
        """
        first, second = (places.of(solid, case) for solid in self._solids)
        request, result, measure = self._request, self._result, self._distance
        distance, points = np.empty(len(case)), np.empty((len(case), 3, 3))
        for k, (one, two) in enumerate(zip(first, second, strict=True)):
            result.clear()
            distance[k] = measure(self._first, one, self._second, two, request, result)
            point = points[k]  # copied: what coal returns is a view of what it changes next
            point[0], point[1] = result.getNearestPoint1(), result.getNearestPoint2()
            point[2] = result.normal
        a, b, normal = points.transpose(1, 2, 0)
        return distance, a, b, -normal


class Placements:
    """Where solids are in N postures, as coal takes it."""

    def __init__(self, posture: Posture) -> None:
        self._posture, self._transform = posture, coal().Transform3s

    def of(self, solid: Solid, case: IntArray) -> list[Any]:
        """Places of a solid in K of the postures."""
        if solid.body == 0:
            pose = np.array(solid.pose)
            return [self._transform(pose[:3, :3], pose[:3, 3])] * len(case)
        # (4, 3, K) axes and origin of the body to (K, 3, 4), times the pose of the solid
        placed = self._posture.bodies[solid.body][:, :, case].transpose(2, 1, 0) @ solid.pose
        rotation, origin = np.ascontiguousarray(placed[:, :, :3]), placed[:, :, 3].copy()
        return [self._transform(R, p) for R, p in zip(rotation, origin, strict=True)]


def _geometry(module: Any, solid: Solid) -> Any:
    size = [float(value) for value in solid.size]
    if solid.kind == "box":
        return module.Box(*size)
    if solid.kind == "cylinder":
        return module.Cylinder(*size)
    if solid.kind == "sphere":
        return module.Sphere(*size)
    if solid.kind == "capsule":
        return module.Capsule(*size)
    points = module.StdVec_Vec3s()
    for vertex in solid.vertices:
        points.append(np.array(vertex))
    return module.ConvexBase.convexHull(points, True, "Qt")
