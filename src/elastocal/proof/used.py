"""Constraints of a study as those of a statement, in the zero configuration.

What has no derivatives of a bounded order, such as collision or a line of sight, is left out: a
proof over more configurations than are allowed is one over those that are.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import BeamRange, Constraint, Elevation, HalfSpace, MinRadius, Tilt
from elastocal.proof.statement import (
    DirectionOverPlane,
    PointByDistance,
    PointOverPlane,
    ProofConstraint,
)

_UP = (0.0, 0.0, 1.0)
_LEVEL = (1.0, 1.0, 0.0)


def used(
    constraints: Iterable[Constraint], T_base_flange: Array
) -> tuple[tuple[ProofConstraint, ...], tuple[str, ...]]:
    """Those that a proof can use, and the names of those that are left out.

    Args:
        constraints: Constraints of a study.
        T_base_flange: (4, 4) pose of the flange in the zero configuration [m].
    """
    found: list[ProofConstraint] = []
    left_out: list[str] = []
    for constraint in constraints:
        made = _made(constraint, T_base_flange)
        if made is None:
            left_out.append(constraint.name)
        else:
            found += made
    return tuple(found), tuple(dict.fromkeys(left_out))


def _made(c: Constraint, T: Array) -> list[ProofConstraint] | None:
    """What stands for a constraint; nothing where it always holds, None where it is left out."""
    kind = type(c)
    if isinstance(c, HalfSpace) and kind is HalfSpace:
        return [PointOverPlane(c.name, _point(T, c.point), c.normal, float(c.offset))]
    if isinstance(c, MinRadius) and kind is MinRadius:
        at = _point(T, c.point)
        return _distance(c.name, at, np.zeros(3), np.array(_LEVEL), 1, float(c.radius))
    if isinstance(c, BeamRange) and kind is BeamRange:
        at = _point(T, c.point)
        return _distance(c.name, at, c.position, np.ones(3), int(c.sign), float(c.bound))
    if isinstance(c, Elevation) and kind is Elevation:
        if c.limit >= np.pi / 2.0:
            return []
        axis, up, most = T[:3, :3] @ c.axis, np.array(_UP), float(np.sin(c.limit))
        return [DirectionOverPlane(c.name, axis, way * up, -most) for way in (-1.0, 1.0)]
    if isinstance(c, Tilt) and kind is Tilt:
        if c.limit >= np.pi:
            return []
        axis = T[:3, :3] @ c.axis
        return [DirectionOverPlane(c.name, axis, c.towards, float(np.cos(c.limit)))]
    return None


def _point(T: Array, local: Array) -> Array:
    return np.asarray(T[:3, :3] @ local + T[:3, 3])


def _distance(
    name: str, point: Array, center: Array, weights: Array, sign: int, bound: float
) -> list[ProofConstraint]:
    """At least, or at most, a bound; one that is zero or less keeps nothing out, or all."""
    if bound <= 0.0 and sign > 0:
        return []
    return [PointByDistance(name, point, center, weights, sign, max(bound, 0.0))]
