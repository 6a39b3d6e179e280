"""Signed distance of two convex solids by coal, one pair at a time; for what has no closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.collision.solid import Solid
from elastocal.errors import InputError
from elastocal.posture import Posture


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

    def __call__(self, first: Any, second: Any) -> tuple[float, Array, Array, Array]:
        """Signed distance [m], nearest points of both, direction that parts them.

        The arguments are where the two solids are, from `placements`.
        """
        self._result.clear()
        distance = self._distance(
            self._first, first, self._second, second, self._request, self._result
        )
        return (
            float(distance),
            self._result.getNearestPoint1(),
            self._result.getNearestPoint2(),
            -self._result.normal,
        )


class Placements:
    """Where solids are in N postures, as coal takes it; each is made when it is first asked for."""

    def __init__(self, posture: Posture) -> None:
        self._posture, self._transform = posture, coal().Transform3s
        self._frames: dict[int, tuple[Array, Array]] = {}
        self._fixed: dict[int, Any] = {}

    def at(self, solid: Solid, case: int) -> Any:
        """Place of a solid in one posture."""
        if solid.body == 0:
            if id(solid) not in self._fixed:
                pose = np.array(solid.pose)
                self._fixed[id(solid)] = self._transform(pose[:3, :3], pose[:3, 3])
            return self._fixed[id(solid)]
        if id(solid) not in self._frames:
            # (4, 3, N) axes and origin of the body to (N, 3, 4), times the pose of the solid
            frame = self._posture.bodies[solid.body].transpose(2, 1, 0)
            placed = frame @ solid.pose
            self._frames[id(solid)] = (
                np.ascontiguousarray(placed[:, :, :3]),
                np.ascontiguousarray(placed[:, :, 3]),
            )
        rotation, origin = self._frames[id(solid)]
        return self._transform(rotation[case], origin[case])


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
