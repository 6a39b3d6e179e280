"""Influence: what single experiments do to a fit.

In: rows and residuals of a least-squares fit, in groups. Out: leverage, Cook's distance, what the
estimate and the residuals become when a group is left out. No refit is made: with M the
information, M_i that of group i and g_i = X_iᵀ e_i, the estimate changes by -(M - M_i)⁻¹ g_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.matrices import rank_of


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
    scale = 1.0 / np.sqrt(np.diagonal(information))
    scaled = rows * scale
    whole = information * np.outer(scale, scale)
    own = _summed(np.einsum("rip,riq->rpq", scaled, scaled).reshape(len(rows), -1), group, count)
    own = own.reshape(count, p, p)
    pulled = _summed(np.einsum("rip,ri->rp", scaled, residual), group, count)
    covariance = np.linalg.inv(whole)
    left = whole - own
    leverage = np.einsum("gpq,pq->g", own, covariance)
    carried = np.zeros(count, dtype=bool)
    likely = leverage > 0.999  # below that something of every unknown is left
    carried[likely] = rank_of(left[likely], scale=whole) < p
    left[carried] = np.eye(p)
    without = np.linalg.inv(left)
    shift = -np.einsum("gpq,gq->gp", without, pulled)
    shift[carried] = np.nan
    cook = np.einsum("gp,pq,gq->g", shift, whole, shift) / p
    ratio = np.sqrt(np.diagonal(without, axis1=1, axis2=2) / np.diagonal(covariance))
    ratio[carried] = np.inf
    return Influence(
        leverage=frozen(leverage),
        cook=frozen(cook),
        shift=frozen(shift * scale),
        error_ratio=frozen(ratio),
    )


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


def _summed(values: Array, group: IntArray, count: int) -> Array:
    """(count, c) sums of `values`, (R, c), over the groups."""
    columns = [np.bincount(group, column, count).astype(float) for column in values.T]
    return np.array(columns, dtype=float).T.reshape(count, values.shape[1])
