"""Signed distance of two convex solids by coal, one pair at a time; for what has no closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.collision.solid import Solid
from elastocal.errors import InputError


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
        self._transform = module.Transform3s
        self._request = module.DistanceRequest()
        self._request.enable_signed_distance = True
        self._request.gjk_tolerance = 1e-7
        self._request.epa_tolerance = 1e-7
        self._result = module.DistanceResult()
        self._distance = module.distance
        self._first, self._second = _geometry(module, first), _geometry(module, second)
        self._poses = np.array(first.pose), np.array(second.pose)

    def __reduce__(self) -> tuple[Any, ...]:
        return PairDistance, self._solids

    def __call__(
        self, T_base_first: Array, T_base_second: Array
    ) -> tuple[float, Array, Array, Array]:
        """Signed distance, points of both, direction that parts them; (4, 4) poses of bodies."""
        one, two = T_base_first @ self._poses[0], T_base_second @ self._poses[1]
        self._result.clear()
        distance = self._distance(
            self._first,
            self._transform(one[:3, :3], one[:3, 3]),
            self._second,
            self._transform(two[:3, :3], two[:3, 3]),
            self._request,
            self._result,
        )
        return (
            float(distance),
            self._result.getNearestPoint1(),
            self._result.getNearestPoint2(),
            -self._result.normal,
        )


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
