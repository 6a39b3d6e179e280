"""How far two solids are apart along given directions: lower bounds of their signed distance.

For any unit vector n the least n·a over the first solid less the largest n·b over the second is at
most their signed distance, and equal to it for the best n. The direction in which capsules
around them part is nearly that.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.constraints.collision.solid import Solid
from elastocal.robot.posture import Posture


def largest(posture: Posture, solid: Solid, case: IntArray, direction: Array) -> Array:
    """(K,) largest n·x over the points x of a solid in K of the postures, in the base frame [m].

    Args:
        posture: N postures.
        solid: The solid.
        case: (K,) which of the postures.
        direction: (3, K) unit vectors n.
    """
    frame = posture.bodies[solid.body][:, :, case]
    local = (frame[:3] * direction).sum(axis=1)
    offset = (frame[3] * direction).sum(axis=0)
    pose = solid.pose
    offset = offset + pose[:3, 3] @ local
    return np.asarray(offset + _support(solid, pose[:3, :3].T @ local))


def _support(solid: Solid, n: Array) -> Array:
    """(K,) support function of a solid in its own frame."""
    size = solid.size
    if solid.kind == "hull":
        return (solid.vertices @ n).max(axis=0)
    if solid.kind == "box":
        return np.asarray(0.5 * size @ np.abs(n))
    if solid.kind == "cylinder":
        return np.asarray(size[0] * np.hypot(n[0], n[1]) + 0.5 * size[1] * np.abs(n[2]))
    length = size[1] if solid.kind == "capsule" else 0.0
    return np.asarray(size[0] + 0.5 * length * np.abs(n[2]))
