"""Bounds: least squares where unknowns, or tensors that they make, cannot be negative.

In: the triangle of a fit. Out: the estimate nearest to its own that keeps the bounds. A tensor is
a symmetric matrix whose entries are linear in the unknowns; that it has no negative eigenvalue is
infinitely many linear bounds, one for each direction. Those that are needed are found one by one.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, BoolArray, unset
from elastocal.fitting.nonnegative import nonnegative

_MOST_CUTS = 80
_NEAR, _NEARER = 1e-5, 1e-10  # share of its largest eigenvalue by which a tensor may be negative
_NOTHING = 1e-9  # size of a tensor, by what its unknowns move in the noise, that is none
_ON_THE_EDGE = 1e-8  # eigenvalue over the largest that is zero
_MOST_STEPS = 8


@dataclass(frozen=True)
class Bounds:
    """What p unknowns cannot be.

    Attributes:
        lower: (p,) least values, -inf where there is none.
        tensors: (G, k, k, p) what makes each of G tensors, all of which are k x k; none if not
            given.
    """

    lower: Array
    tensors: Array = field(default_factory=unset)

    def scaled(self, scale: Array) -> Bounds:
        """The same on unknowns that are (p,) `scale` times as small; tensors of size one."""
        tensors = self.tensors
        if len(tensors):
            tensors = tensors * scale
            tensors = tensors / np.abs(tensors).max(axis=(1, 2, 3), keepdims=True)
        return Bounds(self.lower / scale, tensors)


def bounded(triangle: Array, right: Array, bounds: Bounds, at: Array) -> tuple[Array, BoolArray]:
    """Least squares under bounds, as a step from where the unknowns are.

    Args:
        triangle: (p, p) upper triangular R.
        right: (p,) values of R times the step.
        bounds: Bounds of the unknowns.
        at: (p,) the unknowns before the step.

    Returns:
        (p,) step, and which unknowns are held at their bounds, or at zero with all of a tensor.

    Source: Kelley's cutting planes, each fit by non-negative least squares, Lawson & Hanson ch. 23.
    """
    step, held = _above(triangle, right, bounds.lower - at)
    diagonal = np.abs(np.diagonal(triangle))
    if not len(bounds.tensors) or not diagonal.min() > 1e-13 * diagonal.max():
        return step, held
    limits, cuts = bounds.lower - at, np.zeros((0, len(at)))
    for rounding in (_NEAR, _NEARER):
        for _ in range(_MOST_CUTS):
            more = _negative(bounds.tensors, at + step, rounding)
            if not len(more):
                break
            cuts = np.concatenate([cuts, more])
            step, held = _above_cuts(triangle, right, limits, cuts, -(cuts @ at))
        if not len(cuts):
            return step, held
        gone = _gone(bounds.tensors, at + step)
        step, held = np.where(gone, -at, step), held | gone
        exact = _along_edges(triangle, right, held, bounds.tensors, at, step)
        if _kept(bounds, at + exact):
            return exact, held
    return step, held


def tangent(bounds: Bounds | None, held: BoolArray, at: Array) -> Array:
    """(p, m) basis of the directions in which unknowns `at`, (p,), may move; `held` (p,) stay.

    A tensor on its edge, with an eigenvalue of zero, moves along it and not across.
    """
    free = np.eye(len(at))[:, ~held]
    if bounds is None or not len(bounds.tensors):
        return free
    across = np.concatenate([_edge(tensor, at, _ON_THE_EDGE)[0] for tensor in bounds.tensors])
    _, size, directions = np.linalg.svd(across.reshape(-1, len(at)) @ free)
    return np.asarray(free @ directions[int((size > _ON_THE_EDGE).sum()) :].T)


def _edge(tensor: Array, at: Array, rounding: float) -> tuple[Array, Array]:
    """What moves a tensor across its edge (z z, p), and along it: (z, w, p) over √eigenvalues.

    V are its z eigenvectors of eigenvalue zero, W the others: VᵀTV, and VᵀTW (WᵀTW)^(-1/2). Beside
    a step d the edge bends away by what the square of the second is.
    """
    size, axes = np.linalg.eigh(tensor @ at)
    empty = size <= rounding * size[-1]
    v, w = axes[:, empty], axes[:, ~empty]
    across = np.einsum("ki,klp,lj->ijp", v, tensor, v)
    along = np.einsum("ki,klp,lj->ijp", v, tensor, w / np.sqrt(size[~empty]))
    return across.reshape(-1, len(at)), along


def _along_edges(
    triangle: Array, right: Array, held: BoolArray, tensors: Array, at: Array, step: Array
) -> Array:
    """(p,) the estimate on the edges of the tensors that are near theirs, from nearby.

    Source: Newton on the optimality conditions; the edge's curvature is that of a Schur complement.
    """
    free = np.flatnonzero(~held)
    for _ in range(_MOST_STEPS):
        x, left = at + step, right - triangle @ step
        across, bent = np.zeros((0, len(at))), [np.zeros((0, len(at)))]
        for tensor in tensors:
            rows, along = _edge(tensor, x, 10.0 * _NEAR)
            push = np.linalg.lstsq(rows[:, free].T, -triangle[:, free].T @ left, rcond=1e-9)[0]
            size, axes = np.linalg.eigh(push.reshape(len(along), -1))
            pushed = np.sqrt(2.0 * np.maximum(size, 0.0))[:, None] * axes.T
            bent.append(np.einsum("ij,jwp->iwp", pushed, along).reshape(-1, len(at)))
            across = np.concatenate([across, rows])
        whole = np.concatenate([triangle, *bent])[:, free]
        values = np.append(left, np.zeros(len(whole) - len(left)))
        move = np.zeros(len(at))
        move[free] = _where(whole, values, across[:, free], -(across @ x))
        step = step + move
        if np.abs(move).max() <= 1e-14 * np.abs(step).max():
            break
    return step


def _where(rows: Array, values: Array, fixed: Array, to: Array) -> Array:
    """Least squares of `rows` where `fixed` times the estimate is `to`."""
    u, size, directions = np.linalg.svd(fixed)
    rank = int((size > _ON_THE_EDGE).sum())
    first = directions[:rank].T @ ((u.T @ to)[:rank] / size[:rank])
    free = directions[rank:].T
    rest = np.linalg.lstsq(rows @ free, values - rows @ first, rcond=None)[0]
    return np.asarray(first + free @ rest)


def _negative(tensors: Array, at: Array, rounding: float) -> Array:
    """(n, p) rows of which none may be below zero, and all are: one a tensor at most."""
    rows = []
    for tensor in tensors:
        size, axes = np.linalg.eigh(tensor @ at)
        if size[0] < -rounding * max(size[-1], 0.0) - _NOTHING * np.abs(tensor).max():
            rows.append(np.einsum("k,klp,l->p", axes[:, 0], tensor, axes[:, 0]))
    return np.reshape(rows, (-1, len(at)))


def _kept(bounds: Bounds, at: Array) -> bool:
    """Whether unknowns keep their bounds as well as rounding lets them."""
    return bool((at >= bounds.lower - 1e-12 * np.abs(at).max()).all()) and not len(
        _negative(bounds.tensors, at, _NEARER)
    )


def _gone(tensors: Array, at: Array) -> BoolArray:
    """(p,) unknowns of tensors of which nothing is left."""
    gone = np.zeros(len(at), dtype=bool)
    for tensor in tensors:
        if np.linalg.eigvalsh(tensor @ at)[-1] <= 4.0 * _NOTHING * np.abs(tensor).max():
            gone |= (tensor != 0.0).any(axis=(0, 1))
    return gone


def _above(triangle: Array, right: Array, lower: Array) -> tuple[Array, BoolArray]:
    """Estimate under lower bounds, -inf for none, and which unknowns are held at theirs."""
    bounded = np.isfinite(lower)
    held = np.zeros(len(lower), dtype=bool)
    if bounded.any():
        # Those without a bound first: below them the triangle is that of the others.
        order = np.append(np.flatnonzero(~bounded), np.flatnonzero(bounded))
        moved, part = np.linalg.qr(triangle[:, order])
        loose = int((~bounded).sum())
        least, below = lower[bounded], part[loose:, loose:]
        above = nonnegative(below, (moved.T @ right)[loose:] - below @ least)
        held[bounded] = above == 0.0
    free = ~held
    solution = np.array(lower)
    if free.any():  # the free ones again, to the accuracy of the unbounded fit
        rest = right - triangle[:, held] @ lower[held]
        solution[free] = np.linalg.lstsq(triangle[:, free], rest, rcond=None)[0]
    return solution, held


def _above_cuts(
    triangle: Array, right: Array, lower: Array, cuts: Array, least: Array
) -> tuple[Array, BoolArray]:
    """The same with `cuts` (n, p) times the estimate at `least` (n,) besides.

    Source: least distance programming, Lawson & Hanson, Solving Least Squares Problems, ch. 23.
    """
    bounded = np.flatnonzero(np.isfinite(lower))
    rows = np.concatenate([np.eye(len(lower))[bounded], cuts])
    limits = np.append(lower[bounded], least)
    whole = np.linalg.solve(triangle.T, rows.T)  # one column for each bound
    size = np.linalg.norm(whole, axis=0)
    open_ = (limits - right @ whole) / size
    reach = max(float(np.abs(open_).max()), 1e-300)
    wanted = np.append(np.zeros(len(right)), 1.0)
    weight = nonnegative(np.vstack([whole / size, open_ / reach]), wanted)
    active = weight > 0.0
    held = np.zeros(len(lower), dtype=bool)
    held[bounded[active[: len(bounded)]]] = True
    solution = _where(triangle, right, rows[active], limits[active])  # as exact as can be
    return np.where(held, lower, solution), held
