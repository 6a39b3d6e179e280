"""Narrow parts of a feasible set: where few random points come, and few climbs begin.

A wall with a window leaves a thousandth of a feasible set on its far side, and perhaps the best
experiment there. Random points of the whole box are brought to the nearest feasible ones, so that
those that stick in the wall come out on both sides; what straight lines do not join to the rest
is far behind.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.design.oracle import restore
from elastocal.design.space import DesignSpace

_POINTS = 2000  # random points of the box, restored
_NEIGHBOURS = 6  # nearest points that a point is joined to, one after the other, until it is
_STEPS = 8  # points that must be feasible between two that are joined
_MOST = 200  # points that are taken


def narrow_parts(space: DesignSpace, rng: np.random.Generator) -> Array:
    """(K, d) feasible points that no straight lines join to the largest part of the set.

    Those of different parts come in turn. There are none in a box, nor in a set so thin that
    straight lines leave it everywhere: there is no largest part then.
    """
    lower, upper = space.lower, space.upper
    if not space.evaluate(lower[None]).margins.shape[1]:
        return np.zeros((0, len(lower)))
    x = restore(space, rng.uniform(lower, upper, (_POINTS, len(lower))))
    x = x[space.feasible(x)]
    part = _joined(space, x)
    sizes = np.bincount(part, minlength=1)
    if 2 * sizes.max() < len(x):
        return x[:0]
    outside = np.flatnonzero(part != sizes.argmax())
    # The first of every part, then the second of every part, and so on.
    turn = [(part[outside[:i]] == part[k]).sum() for i, k in enumerate(outside)]
    return x[outside[np.argsort(turn, kind="stable")[:_MOST]]]


def _joined(space: DesignSpace, x: Array) -> IntArray:
    """(N,) which part the feasible points (N, d) belong to; straight lines join a part."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    part: IntArray = np.arange(len(x))
    if len(x) < 2:
        return part
    width = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
    found = cKDTree(x / width).query(x / width, k=min(_NEIGHBOURS + 1, len(x)))
    near = np.asarray(found[1])
    lines = np.zeros((2, 0), dtype=np.int64)
    for ends in near[:, 1:].T:
        lonely = np.flatnonzero((part != np.bincount(part).argmax()) & (part != part[ends]))
        joined = lonely[_lines_are_feasible(space, x[lonely], x[ends[lonely]])]
        lines = np.hstack([lines, [joined, ends[joined]]])
        graph = coo_matrix((np.ones(lines.shape[1]), tuple(lines)), shape=(len(x), len(x)))
        part = np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
    return part


def _lines_are_feasible(space: DesignSpace, begin: Array, end: Array) -> BoolArray:
    """(N,) whether the points between `begin` and `end`, (N, d) each, are feasible."""
    between = (np.arange(_STEPS) + 1.0) / (_STEPS + 1.0)
    points = begin[:, None] + between[:, None] * (end - begin)[:, None]
    held = space.feasible(points.reshape(-1, begin.shape[1]))
    return np.asarray(held.reshape(-1, _STEPS).all(axis=1))
