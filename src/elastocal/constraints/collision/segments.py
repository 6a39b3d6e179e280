"""Closest points of two segments, and how deep a segment is in a box: closed forms, in batches.

Everything here is K independent pairs, components first: (3, K). A capsule is a segment with a
radius, a sphere a segment of no length: their signed distance is that of the segments less radii.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.posture import cross, dot


class Closest(NamedTuple):
    """Signed distance of K pairs, with where it is attained."""

    distance: Array  # (K,) [m]; negative: depth of penetration
    first: Array  # (3, K) point of the first solid
    second: Array  # (3, K) point of the second
    normal: Array  # (3, K) unit vector along which moving the first one parts them


def between_segments(a: Array, b: Array, c: Array, d: Array) -> Closest:
    """Closest points of the segments a-b and c-d, each (3, K) [m].

    Source: Ericson, Real-Time Collision Detection, 5.1.9; that the parameters are projected once
    more at the end, which settles points and parallel segments, is ours.
    """
    u, v, r = b - a, d - c, a - c
    uu, vv, uv = dot(u, u), dot(v, v), dot(u, v)
    ur, vr = dot(u, r), dot(v, r)
    square = uu * vv - uv * uv
    skew = square > 1e-12 * uu * vv
    s = np.where(skew, (uv * vr - ur * vv) / np.where(skew, square, 1.0), 0.5)
    np.clip(s, 0.0, 1.0, out=s)
    for _ in range(2):
        t = np.clip((uv * s + vr) / np.maximum(vv, _TINY), 0.0, 1.0)
        s = np.clip((uv * t - ur) / np.maximum(uu, _TINY), 0.0, 1.0)
    first, second = a + s * u, c + t * v
    gap = first - second
    distance = np.sqrt(dot(gap, gap))
    touching = distance < 1e-12
    normal = gap / np.where(touching, 1.0, distance)
    if touching.any():  # they cross: any parting direction is square to both
        normal[:, touching] = _square_to(u[:, touching], v[:, touching])
    return Closest(distance, first, second, normal)


def segment_and_plane(a: Array, b: Array, pose: Array) -> Closest:
    """Signed distance of segments from all below z = 0 of `pose`, (4, 4), as `between_segments`."""
    normal, origin = pose[:3, 2], pose[:3, 3]
    heights = [normal @ (end - origin[:, None]) for end in (a, b)]
    lower = heights[1] < heights[0]
    distance, first = np.where(lower, heights[1], heights[0]), np.where(lower, b, a)
    outward = np.repeat(normal[:, None], len(distance), axis=1)
    return Closest(distance, first, first - distance * outward, outward)


def segment_and_box(a: Array, b: Array, rotation: Array, centre: Array, half: Array) -> Closest:
    """Signed distance of segments from boxes, the point of the box second.

    Args:
        a: (3, K) starts [m].
        b: (3, K) ends [m].
        rotation: (3, 3) axes of the box as columns.
        centre: (3,) its centre [m].
        half: (3,) half its sides [m].

    Source: ours. Outside, the squared distance along the segment is convex and piecewise
    quadratic, so its slope changes sign between two of at most eight parameters. Inside, the
    Minkowski difference of box and segment is a polytope whose faces have six directions.
    """
    start, end = rotation.T @ (a - centre[:, None]), rotation.T @ (b - centre[:, None])
    along = end - start
    half = half[:, None]
    t = _nearest_parameter(start, along, half)
    point = start + t * along
    inside = np.clip(point, -half, half)
    gap = point - inside
    distance = np.sqrt(dot(gap, gap))
    hit = distance < 1e-12
    normal = gap / np.where(hit, 1.0, distance)
    if hit.any():
        k = np.flatnonzero(hit)
        depth, normal[:, k], point[:, k] = _depth(start[:, k], along[:, k], half)
        distance[k] = -depth
        inside[:, k] = point[:, k] + depth * normal[:, k]
    back = centre[:, None]
    return Closest(distance, rotation @ point + back, rotation @ inside + back, rotation @ normal)


_TINY = 1e-300


def _nearest_parameter(start: Array, along: Array, half: Array) -> Array:
    """(K,) where along the segments the box is nearest."""
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = np.concatenate([(half - start) / along, (-half - start) / along])
    crossings = np.where(np.isfinite(crossings), crossings, 0.0)
    knots = np.zeros((8, start.shape[1]))
    knots[1:7] = np.clip(crossings, 0.0, 1.0)
    knots[7] = 1.0
    knots.sort(axis=0)
    x = start[:, None] + knots * along[:, None]
    slope = dot(along[:, None], x - np.clip(x, -half[:, None], half[:, None]))
    # The slope rises along the knots: find the two between which it passes through zero.
    right = np.minimum((slope < 0.0).sum(axis=0), 7)
    left = np.maximum(right - 1, 0)
    k = np.arange(len(right))
    low, high = slope[left, k], slope[right, k]
    rise = high - low
    share = np.where(rise > 0.0, np.clip(-low / np.where(rise > 0.0, rise, 1.0), 0.0, 1.0), 0.0)
    t = knots[left, k] + share * (knots[right, k] - knots[left, k])
    return np.where(slope[7] < 0.0, 1.0, np.where(slope[0] > 0.0, 0.0, t))


def _depth(start: Array, along: Array, half: Array) -> tuple[Array, Array, Array]:
    """Depth (K,), direction out of the box (3, K), deepest point of the segment (3, K)."""
    count = start.shape[1]
    middle, reach = start + 0.5 * along, 0.5 * along
    axes = np.empty((6, 3, count))
    axes[:3] = np.eye(3)[:, :, None]
    for i in range(3):
        axes[3 + i] = cross(np.broadcast_to(np.eye(3)[i][:, None], along.shape), along)
    size = np.sqrt((axes**2).sum(axis=1))
    flat = size < 1e-9 * (1.0 + np.sqrt(dot(along, along)))
    axes /= np.where(flat, 1.0, size)[:, None]
    offset = (axes * middle).sum(axis=1)
    axes *= np.where(offset < 0.0, -1.0, 1.0)[:, None]
    overlap = (np.abs(axes) * half).sum(axis=1) + np.abs((axes * reach).sum(axis=1))
    overlap = np.where(flat, np.inf, overlap - np.abs(offset))
    best = overlap.argmin(axis=0)
    k = np.arange(count)
    normal = axes[best, :, k].T
    # A face is met by an end of the segment, an edge of the box somewhere along it.
    t = np.where(dot(normal, along) > 0.0, 0.0, 1.0)
    for i in range(3):
        edge = np.flatnonzero(best == 3 + i)
        if len(edge):
            n = normal[:, edge]
            side = cross(n, np.broadcast_to(np.eye(3)[i][:, None], n.shape))
            corner = np.where(n < 0.0, -half, half)
            where = dot(side, corner - start[:, edge]) / dot(side, along[:, edge])
            t[edge] = np.clip(where, 0.0, 1.0)
    return overlap[best, k], normal, start + t * along


def _square_to(u: Array, v: Array) -> Array:
    """(3, K) unit vectors square to u and v, to u alone where they are parallel, else any."""
    for other in (v, np.eye(3)[:, :1] + 0.0 * v, np.eye(3)[:, 1:2] + 0.0 * v):
        normal = cross(u, other)
        length = np.sqrt(dot(normal, normal))
        fine = length > 1e-12 * (1.0 + np.sqrt(dot(u, u)))
        if other is v:
            result, known = np.where(fine, normal / np.where(fine, length, 1.0), 0.0), fine
        else:
            new = fine & ~known
            result = np.where(new, normal / np.where(fine, length, 1.0), result)
            known = known | fine
    result[2, ~known] = 1.0
    return result
