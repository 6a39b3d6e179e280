"""How far two solids are apart along given directions: lower bounds of their signed distance.

For any unit vector n the least n·a over the first solid less the largest n·b over the second is at
most their signed distance, and equal to it for the best n. The direction in which capsules
around them part is nearly that.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.constraints.collision.shell import box_shell
from elastocal.constraints.collision.solid import Solid
from elastocal.robot.posture import Posture


class Spanned(NamedTuple):
    """The hull of points, widened by a disc and thickened by a skin; in the frame of a body.

    Attributes:
        points: (P, 3) [m].
        spokes: (2, 3) two radii of the disc, square to each other; zero if there is none [m].
        skin: How thick the skin is [m].
    """

    points: Array
    spokes: Array
    skin: float


def spanned(solid: Solid) -> Spanned:
    """A solid that is no plane, as what determines how far it reaches in any direction."""
    turn, size = solid.pose[:3, :3], solid.size
    points, rim, skin = solid.vertices, 0.0, 0.0
    if solid.kind == "box":
        points = box_shell(0, np.eye(4), size / 2.0).corners
    elif solid.kind != "hull":  # about z, of a length that a sphere does not have
        half = size[1] / 2.0 if len(size) > 1 else 0.0
        points = np.array([[0.0, 0.0, -half], [0.0, 0.0, half]])
        rim, skin = (size[0], 0.0) if solid.kind == "cylinder" else (0.0, size[0])
    return Spanned(points @ turn.T + solid.pose[:3, 3], rim * turn[:, :2].T, float(skin))


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


def lowest(posture: Posture, solid: Solid, case: IntArray, direction: Array) -> Array:
    """(3, K) point of a solid that is farthest against a direction, as `largest` takes them [m]."""
    frame = posture.bodies[solid.body][:, :, case]
    turn, local = solid.pose[:3, :3], (frame[:3] * direction).sum(axis=1)
    if len(solid.faces):
        corner = solid.corners[(solid.corners @ local).argmin(axis=0)].T
    else:
        corner = turn @ _corner(solid, turn.T @ -local) + solid.pose[:3, 3:]
    return np.asarray((frame[:3] * corner[:, None]).sum(axis=0) + frame[3])


def _corner(solid: Solid, n: Array) -> Array:
    """(3, K) point of a solid in its own frame that is farthest along n."""
    size = solid.size
    if solid.kind == "hull":
        return np.asarray(solid.vertices[(solid.vertices @ n).argmax(axis=0)].T)
    if solid.kind == "box":
        return np.asarray(0.5 * size[:, None] * np.sign(n))
    if solid.kind == "cylinder":
        across = n[:2] / np.maximum(np.hypot(n[0], n[1]), 1e-12)
        return np.concatenate([size[0] * across, 0.5 * size[1] * np.sign(n[2:])])
    length = size[1] if solid.kind == "capsule" else 0.0
    end = np.zeros_like(n)
    end[2] = 0.5 * length * np.sign(n[2])
    return np.asarray(end + size[0] * n)


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
