"""How far two solids are apart along given directions: lower bounds of their signed distance.

For any unit vector n the least n·a over the first solid less the largest n·b over the second is at
most their signed distance, and equal to it for the best n. The direction in which capsules
around them part is nearly that.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
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


FIELDS = 6
"""Fields along a side of the cube of directions, see `by_direction`."""


def by_direction(points: Array) -> tuple[IntArray, IntArray]:
    """Which of points (P, 3) may be the farthest along a direction, for parts of all directions.

    The sides of a cube, +x, -x, +y to -z, have `FIELDS`² fields each, side by side first along
    the axis after that of the side, y after x and x after z, then along the next one.

    Returns:
        Where the points of each field begin, (6 `FIELDS`² + 1,), and their numbers.

    Source: ours. A point is out of the question if another one is as far along all corners of a
    field, for so it is along what is between them.
    """
    return _by_direction(np.ascontiguousarray(points, dtype=float).tobytes())


@lru_cache(maxsize=256)
def _by_direction(data: bytes) -> tuple[IntArray, IntArray]:
    points = np.frombuffer(data).reshape(-1, 3)
    _, first = np.unique(points, axis=0, return_index=True)
    low, step = np.mgrid[:FIELDS, :FIELDS].reshape(2, -1, 1), np.indices((2, 2)).reshape(2, 1, 4)
    across = 2.0 / FIELDS * (low + step) - 1.0  # (2, F², 4) of the corners of the fields
    counts, found = [0], []
    for side in range(6):
        ahead = np.full(across.shape[1:], 1.0 - 2.0 * (side % 2))
        corners = np.roll([ahead, *across], side // 2, axis=0)
        far = np.tensordot(corners, points[first], axes=(0, 1))  # (F², 4, P)
        rivals = np.column_stack([far.argmax(axis=2), far.sum(axis=1).argmax(axis=1)])
        best = np.take_along_axis(far, rivals[:, None], axis=2)[:, :, :, None]
        beaten = (best >= far[:, :, None]).all(axis=1) & (best > far[:, :, None]).any(axis=1)
        left = ~np.any(beaten, axis=1)
        counts += left.sum(axis=1).tolist()
        found.append(first[np.nonzero(left)[1]])
    return frozen(np.cumsum(counts), np.int64), frozen(np.concatenate(found), np.int64)


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
