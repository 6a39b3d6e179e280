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
_TOGETHER = 500  # points whose distances from all others are in memory at once


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
    part: IntArray = np.arange(len(x))
    if len(x) < 2:
        return part
    width = np.where(space.upper > space.lower, space.upper - space.lower, 1.0)
    lines = np.zeros((2, 0), dtype=np.int64)
    for ends in _nearest(x / width, min(_NEIGHBOURS, len(x) - 1)).T:
        lonely = np.flatnonzero((part != np.bincount(part).argmax()) & (part != part[ends]))
        joined = lonely[_lines_are_feasible(space, x[lonely], x[ends[lonely]])]
        lines = np.hstack([lines, [joined, ends[joined]]])
        part = _parts(len(x), *lines)
    return part


def _nearest(x: Array, count: int) -> IntArray:
    """(N, count) the nearest other points of each of (N, d), nearest first.

    All distances at once: to import a tree of points takes longer than these few of them.
    """
    found = np.empty((len(x), count), dtype=np.int64)
    square = (x**2).sum(axis=1)
    for start in range(0, len(x), _TOGETHER):
        rows = np.arange(start, min(start + _TOGETHER, len(x)))
        distance = square - 2.0 * (x[rows] @ x.T)
        distance[np.arange(len(rows)), rows] = np.inf
        near = np.argpartition(distance, count - 1, axis=1)[:, :count]
        order = np.argsort(np.take_along_axis(distance, near, axis=1), axis=1, kind="stable")
        found[rows] = np.take_along_axis(near, order, axis=1)
    return found


def _parts(count: int, first: IntArray, second: IntArray) -> IntArray:
    """(N,) which part each of N points belongs to, if lines join `first` to `second`."""
    lowest = np.arange(count)
    while True:
        before = lowest.copy()
        least = np.minimum(lowest[first], lowest[second])
        for ends in (first, second):
            np.minimum.at(lowest, lowest[ends], least)
        lowest = lowest[lowest]
        if (lowest == before).all():
            return np.unique(lowest, return_inverse=True)[1].reshape(count)


def _lines_are_feasible(space: DesignSpace, begin: Array, end: Array) -> BoolArray:
    """(N,) whether the points between `begin` and `end`, (N, d) each, are feasible."""
    between = (np.arange(_STEPS) + 1.0) / (_STEPS + 1.0)
    points = begin[:, None] + between[:, None] * (end - begin)[:, None]
    held = space.feasible(points.reshape(-1, begin.shape[1]))
    return np.asarray(held.reshape(-1, _STEPS).all(axis=1))
