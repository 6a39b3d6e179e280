"""Influence: what single experiments do to a fit.

In: rows and residuals of a least-squares fit, in groups. Out: leverage, Cook's distance, what the
estimate and the residuals become when a group is left out. No refit is made: with M the
information, M_i that of group i and g_i = X_iᵀ e_i, the estimate changes by -(M - M_i)⁻¹ g_i.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, frozen
from elastocal.matrices import eliminated, rank_of

_PORTION = 2048  # readings looked at together
_FEW = 6  # unknowns up to which NumPy is the faster over all groups at once, LAPACK beyond


@dataclass(frozen=True)
class Influence:
    """Influence of G groups of readings on p unknowns.

    Attributes:
        leverage: (G,) traces of their blocks of the hat matrix; they sum to p without prior.
        cook: (G,) Cook's distances: squared shift of the estimate, over p, in standard errors.
        shift: (G, p) change of the estimate when the group is left out.
        error_ratio: (G, p) standard errors without the group over those with it; infinite where
            the group alone carries an unknown.
    """

    leverage: Array
    cook: Array
    shift: Array
    error_ratio: Array


def influence(
    rows: Array, residual: Array, group: IntArray, count: int, information: Array
) -> Influence:
    """Influence of `count` groups.

    Args:
        rows: (R, r, p) rows of R readings, noise of unit covariance.
        residual: (R, r) residuals, likewise.
        group: (R,) group of each reading, from 0.
        count: Number of groups G.
        information: (p, p) information of the whole fit, prior included.

    Source: Cook & Weisberg, Residuals and Influence in Regression, ch. 3, for blocks of rows.
    """
    p = rows.shape[2]
    scale, whole = _scaled(information)
    covariance = np.linalg.inv(whole)
    # What no reading is in: without it nothing changes.
    leverage, cook, shift = np.zeros(count), np.zeros(count), np.zeros((count, p))
    ratio = np.ones((count, p))
    for groups, own, pulled in _sums(rows, residual, group, scale):
        leverage[groups] = np.einsum("gpq,pq->g", own, covariance)
        left, carried = _left(whole, own, leverage[groups])
        if p > _FEW:
            inverse = np.asarray(np.linalg.inv(left), dtype=float)
            moved, freed = _times(inverse, -pulled), np.diagonal(inverse, axis1=1, axis2=2)
        else:
            unit = np.broadcast_to(np.eye(p), left.shape)
            solved = _eliminated(left, np.concatenate([pulled[:, :, None], unit], axis=2))
            moved, freed = -solved[:, 0].T, np.diagonal(solved[:, 1:])
        moved[carried] = np.nan
        cook[groups] = np.einsum("gp,pq,gq->g", moved, whole, moved) / p
        spread = freed / np.diagonal(covariance)
        ratio[groups] = np.where(carried[:, None], np.inf, np.sqrt(spread))
        shift[groups] = moved * scale
    return Influence(
        leverage=frozen(leverage), cook=frozen(cook), shift=frozen(shift), error_ratio=frozen(ratio)
    )


def shifts(rows: Array, residual: Array, group: IntArray, count: int, information: Array) -> Array:
    """(G, p) change of the estimate when each of `count` groups is left out, and nothing else.

    Args as those of `influence`; NaN where a group alone carries an unknown.
    """
    p = rows.shape[2]
    scale, whole = _scaled(information)
    covariance = np.linalg.inv(whole)
    shift = np.zeros((count, p))
    for groups, own, pulled in _sums(rows, residual, group, scale):
        left, carried = _left(whole, own, np.einsum("gpq,pq->g", own, covariance))
        if p > _FEW:
            moved = np.linalg.solve(left, -pulled[..., None])[..., 0]
        else:
            moved = -_eliminated(left, pulled[..., None])[:, 0].T
        moved[carried] = np.nan
        shift[groups] = moved * scale
    return shift


def _scaled(information: Array) -> tuple[Array, Array]:
    """(p,) sizes of the unknowns, and (p, p) information in these."""
    scale = 1.0 / np.sqrt(np.diagonal(information))
    return scale, information * np.outer(scale, scale)


def _sums(
    rows: Array, residual: Array, group: IntArray, scale: Array
) -> Iterator[tuple[IntArray, Array, Array]]:
    """Some groups, their information (g, p, p), and what residuals pull at the estimate (g, p)."""
    p = rows.shape[2]
    for groups, begin, these in _portions(group):
        scaled, left_over = rows[these] * scale, residual[these]
        each = len(scaled) // len(begin)
        if (np.diff(begin, append=len(scaled)) == each).all():  # as many readings in every group
            scaled = scaled.reshape(len(begin), -1, p)
            turned = scaled.transpose(0, 2, 1)
            pulled = _times(turned, left_over.reshape(len(begin), -1))
            yield groups, turned @ scaled, pulled
        else:
            turned = scaled.transpose(0, 2, 1)
            pulled = np.add.reduceat(_times(turned, left_over), begin)
            yield groups, np.add.reduceat(turned @ scaled, begin), pulled


def _left(whole: Array, own: Array, leverage: Array) -> tuple[Array, BoolArray]:
    """(g, p, p) information without each group, and where nothing is left of an unknown."""
    left, p = whole - own, len(whole)
    carried = np.zeros(len(left), dtype=bool)
    likely = leverage > 0.999  # below that something of every unknown is left
    carried[likely] = rank_of(left[likely], scale=whole) < p
    left[carried] = np.eye(p)
    return left, carried


def _times(matrices: Array, vectors: Array) -> Array:
    """(g, p) matrices (g, p, q) times vectors (g, q)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])


def _eliminated(matrices: Array, sides: Array) -> Array:
    """(p, m, g) solutions, of matrices (g, p, p) and sides (g, p, m)."""
    first, second = (np.ascontiguousarray(a.transpose(1, 2, 0)) for a in (matrices, sides))
    return eliminated(first, second)


def _portions(group: IntArray) -> Iterator[tuple[IntArray, IntArray, IntArray | slice]]:
    """Some groups, where each begins among the readings of all of them, and these readings.

    `group`, (R,), says of which each reading is; a portion stays in the cache.
    """
    in_order = not (np.diff(group) < 0).any()
    order = np.arange(len(group)) if in_order else np.argsort(group, kind="stable")
    begin = np.flatnonzero(np.diff(group[order], prepend=-1))
    ends = np.append(begin, len(group))
    place = 0
    while place < len(begin):
        beyond = max(int(np.searchsorted(ends, begin[place] + _PORTION, "right")) - 1, place + 1)
        some = slice(int(begin[place]), int(ends[beyond]))
        these = some if in_order else order[some]
        yield group[order[begin[place:beyond]]], begin[place:beyond] - begin[place], these
        place = beyond


def influence_on(wanted: Sequence[int], found: Influence, information: Array) -> Influence:
    """The same influence on some of the unknowns, at the positions `wanted`.

    Cook's distance is that of their shift in their own confidence ellipsoid.
    """
    p = len(wanted)
    shift = found.shift[:, wanted]
    scale = 1.0 / np.sqrt(np.diagonal(information))
    covariance = np.linalg.inv(information * np.outer(scale, scale))[np.ix_(wanted, wanted)]
    scaled = shift / scale[wanted]
    cook = np.einsum("gp,pq,gq->g", scaled, np.linalg.inv(covariance), scaled) / p
    return Influence(
        found.leverage, frozen(cook), frozen(shift), frozen(found.error_ratio[:, wanted])
    )


def reordered(found: Influence, order: IntArray) -> Influence:
    """The same groups in another order: the new i-th was the `order[i]`-th."""
    return Influence(
        frozen(found.leverage[order]),
        frozen(found.cook[order]),
        frozen(found.shift[order]),
        frozen(found.error_ratio[order]),
    )
