"""Polytopes of few faces around solids, and how far their faces part them: closed forms.

In: corners of a hull. Out: a `Shell`; the distances that the faces of two shells prove. A box has
six faces; a capsule has none here, its ends stand for it with their radius.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.robot.chain import transform
from elastocal.robot.posture import Posture

MOST = 32
"""Faces of a shell at most."""
_OVER = 0.005  # share of the size of a solid by which its shell may stand out where faces are left
_ROUND = 1e-6  # overhangs that differ by less [m] are alike: the first plane in order is taken
_BINS = 24.0  # directions that differ by less than some 2° are alike
_SLACK = 1e-9  # room for rounding [m]
_SENTINELS = 8  # corners that tell which face promises most
_CHUNK = 256  # pairs looked at at once


class Shell(NamedTuple):
    """All x with n·x <= h for every face, and its corners; in the frame of a body.

    Attributes:
        body: Number of the body it moves with.
        faces: (F, 4) unit normals n and h [m]; F may be 0.
        corners: (C, 3) points whose hull, made thicker by the radius, is the solid [m].
        radius: That radius [m].
    """

    body: int
    faces: Array
    corners: Array
    radius: float


def box_shell(body: int, pose: Array, half: Array) -> Shell:
    """The shell of a box, half its sides (3,) [m], at a pose (4, 4) in the frame of a body."""
    normals = np.vstack([pose[:3, :3].T, -pose[:3, :3].T])
    heights = normals @ pose[:3, 3] + np.tile(half, 2)
    signs = 2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1.0
    corners = (signs * half) @ pose[:3, :3].T + pose[:3, 3]
    return Shell(body, np.column_stack([normals, heights]), corners, 0.0)


def enclosing(points: Array) -> tuple[Array, Array]:
    """Faces (F, 4) and corners (C, 3) of a polytope that holds the hull of points (V, 3) [m].

    It starts as a box along x, y, z; where a corner stands out most the plane of a facet of the
    hull cuts it off, until none stands out much or there are `MOST` faces.

    Source: ours.
    """
    points = np.ascontiguousarray(points, dtype=float)
    return _enclosing(points.tobytes())


@lru_cache(maxsize=256)
def _enclosing(data: bytes) -> tuple[Array, Array]:
    from scipy.spatial import ConvexHull, QhullError

    points = np.frombuffer(data).reshape(-1, 3)
    low, high = points.min(axis=0), points.max(axis=0)
    box = box_shell(0, transform(None, (low + high) / 2.0), (high - low) / 2.0)
    try:
        faces, corners = _cut(points, box.faces)
        outward = ConvexHull(corners).equations
        if (points @ outward[:, :3].T + outward[:, 3]).max() <= _ROUND:
            return frozen(faces), frozen(corners)
    except QhullError:
        pass  # too thin to be cut
    return frozen(box.faces), frozen(box.corners)


def _cut(points: Array, faces: Array) -> tuple[Array, Array]:
    """Faces and corners of a polytope whose corners are cut off while they stand out much."""
    from scipy.spatial import ConvexHull, HalfspaceIntersection

    normals = _directions(ConvexHull(points))
    facets = np.column_stack([normals, (points @ normals.T).max(axis=0)])
    most = _OVER * float(np.linalg.norm(np.ptp(points, axis=0)))
    while True:
        held = np.column_stack([faces[:, :3], -faces[:, 3] - _SLACK])
        corners = HalfspaceIntersection(held, points.mean(axis=0)).intersections
        over = ((corners @ facets[:, :3].T - facets[:, 3]) / _ROUND).round().max(axis=0)
        if len(faces) == MOST or over.max() * _ROUND <= most:
            return faces, np.unique(corners.round(12), axis=0)
        faces = np.vstack([faces, facets[over.argmax()]])


def _directions(hull: Any) -> Array:
    """Normals of the facets of a hull; of those of nearly one direction that of the largest."""
    normals = hull.equations[:, :3]
    sides = np.diff(hull.points[hull.simplices], axis=1)
    area = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
    order = np.argsort(-area.round(9), kind="stable")
    _, first = np.unique((_BINS * normals[order]).round(), axis=0, return_index=True)
    return np.asarray(normals[order[first]])


class Stack(NamedTuple):
    """S shells in arrays of one size, to look at many pairs of them at once."""

    body: IntArray  # (S,)
    normals: Array  # (S, F, 3) zero where a shell has fewer faces than another ...
    heights: Array  # (S, F) [m] ... and infinite
    corners: Array  # (S, C, 3) [m] the first ones again where it has fewer; far apart ones first
    radius: Array  # (S,) [m]


def stacked(shells: Sequence[Shell]) -> Stack:
    """Shells in arrays of one size."""
    faces = max([1, *(len(shell.faces) for shell in shells)])
    corners = max([1, *(len(shell.corners) for shell in shells)])
    normals, heights = np.zeros((len(shells), faces, 3)), np.full((len(shells), faces), np.inf)
    points = np.zeros((len(shells), corners, 3))
    for s, shell in enumerate(shells):
        normals[s, : len(shell.faces)] = shell.faces[:, :3]
        heights[s, : len(shell.faces)] = shell.faces[:, 3]
        points[s] = np.resize(far_apart_first(shell.corners), (corners, 3))
    body = frozen([shell.body for shell in shells], np.int64)
    radius = frozen([shell.radius for shell in shells])
    return Stack(body, frozen(normals), frozen(heights), frozen(points), radius)


def far_apart_first(points: Array) -> Array:
    """The same points, at the beginning `_SENTINELS` that are far apart."""
    away = np.linalg.norm(points - points.mean(axis=0), axis=1)
    chosen: list[int] = []
    for _ in range(min(_SENTINELS, len(points))):
        chosen.append(int(away.argmax()))
        apart = np.linalg.norm(points - points[chosen[-1]], axis=1)
        away = np.minimum(away if len(chosen) > 1 else np.inf, apart)
        away[chosen] = -1.0
    return np.concatenate([points[chosen], np.delete(points, chosen, axis=0)])


def parted(
    posture: Posture,
    stack: Stack,
    first: IntArray,
    second: IntArray,
    case: IntArray,
    known: Array,
    enough: Array,
) -> tuple[Array, Array, Array, Array]:
    """How far apart the faces of two shells hold them, for K pairs each in one of the postures.

    A lower bound of the signed distance of what they enclose: the height of all of the one over a
    face of the other, of the best face. Where a face and a corner are nearest it is the distance.

    Args:
        posture: N postures.
        stack: Shells.
        first: (K,) which of them is the first ...
        second: (K,) ... and which the second.
        case: (K,) in which of the postures.
        known: (K,) another lower bound [m]; what shows less is not looked for.
        enough: (K,) a distance [m] that need not be known better once it is exceeded.

    Returns:
        Signed distances (K,) [m], those known where no face shows more; where one does, nearest
        points of both and the unit vector along which the first gets away, (3, K) each.

    Source: ours; the separating axis test (Gottschalk et al. 1996) with the normals of the faces.
    """
    frames = np.array(posture.bodies)
    distance, found = np.array(known), np.zeros((3, 3, len(case)))
    for start in range(0, len(case), _CHUNK):
        part = slice(start, start + _CHUNK)
        i, j, gap = first[part], second[part], known[part]
        one, two = (frames[stack.body[which], :, :, case[part]] for which in (i, j))
        # Both ways in one go: the second over faces of the first, the first over the second's.
        heights, foot, normal = _over(
            stack,
            (np.concatenate([i, j]), np.concatenate([one, two])),
            (np.concatenate([j, i]), np.concatenate([two, one])),
            np.concatenate([gap, gap]),
            np.concatenate([enough[part], enough[part]]),
        )
        forth, back = heights[: len(i)], heights[len(i) :]
        way = np.arange(len(i)) + np.where(back > forth, len(i), 0)
        gap = distance[part] = heights[way]
        foot, normal = foot[way], normal[way]
        point = foot + gap[:, None] * normal
        turned = (way >= len(i))[:, None]
        found[0, :, part] = np.where(turned, point, foot).T
        found[1, :, part] = np.where(turned, foot, point).T
        found[2, :, part] = np.where(turned, normal, -normal).T
    return distance, found[0], found[1], found[2]


def _over(
    stack: Stack,
    own: tuple[IntArray, Array],
    other: tuple[IntArray, Array],
    known: Array,
    enough: Array,
) -> tuple[Array, Array, Array]:
    """Height (K,) of shells over the best faces of others, the point below, that normal, (K, 3).

    Each is a shell and the axes and origin of its body, (K, 4, 3), in the base frame. Over no face
    all of a shell is higher than some of its corners: what they promise most is tried first.
    """
    (one, first), (two, second) = own, other
    turn = first[:, :3] @ second[:, :3].transpose(0, 2, 1)
    shift = first[:, :3] @ (second[:, 3] - first[:, 3])[:, :, None]
    normals, corners = stack.normals[one], stack.corners[two]
    base = (normals @ shift)[:, :, 0] - stack.heights[one] - stack.radius[two][:, None]
    seen = normals @ turn  # from the body of the other
    most = base + (corners[:, :_SENTINELS] @ seen.transpose(0, 2, 1)).min(axis=1)
    gap, face, lowest = np.array(known), np.zeros_like(one), np.zeros_like(one)
    open_ = np.flatnonzero(most.max(axis=1) > gap)
    while len(open_):
        best = most[open_].argmax(axis=1)
        height = (corners[open_] @ seen[open_, best][:, :, None])[:, :, 0]
        low, each = height.argmin(axis=1), np.arange(len(open_))
        height = base[open_, best] + height[each, low]
        k = height > gap[open_]
        better = open_[k]
        gap[better], face[better], lowest[better] = height[k], best[k], low[k]
        most[open_, best] = -np.inf
        open_ = open_[gap[open_] < enough[open_]]
        open_ = open_[most[open_].max(axis=1) > gap[open_]]
    each = np.arange(len(one))
    corner = (corners[each, lowest][:, None] @ second[:, :3])[:, 0] + second[:, 3]
    normal = (normals[each, face][:, None] @ first[:, :3])[:, 0]
    return gap, corner - (gap + stack.radius[two])[:, None] * normal, normal
