"""Linear least squares: scaled columns, QR in chunks, optional bounds and prior.

In: rows and values whose noise has unit covariance, one system or a stack. Out: estimates,
triangular factors, residual sums. Nothing here knows what the unknowns are. The normal equations
are never formed: their condition number is the square of that of the rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, frozen
from elastocal.fitting.bounds import Bounds, bounded

_CHUNK = 8192  # rows that are triangularised at once: what stays in the cache
_MOST_REFINED = 65536  # rows
_REFINEMENTS = 4


@dataclass(frozen=True)
class LinearFit:
    """Least-squares fits of p unknowns: C sets of values to B systems of rows, B = 1 or C.

    Attributes:
        estimate: (C, p) unknowns.
        triangle: (B, p, p) upper triangular R with RᵀR the information matrix.
        residual_sum: (C,) sums of the squared residuals, those of the prior included.
        held: (C, p) unknowns held at their bound.
    """

    estimate: Array
    triangle: Array
    residual_sum: Array
    held: BoolArray

    def of(self, i: int) -> LinearFit:
        """The i-th fit alone, its arrays without the axis of C or B."""
        return LinearFit(
            self.estimate[i], one_of(self.triangle, i), self.residual_sum[i], self.held[i]
        )

    @property
    def information(self) -> Array:
        """(B, p, p) information matrices."""
        return np.asarray(np.swapaxes(self.triangle, -1, -2) @ self.triangle)

    @property
    def covariance(self) -> Array:
        """(B, p, p) covariances of the estimates if none is held."""
        root = inverse_root(self.triangle)
        return np.asarray(root @ np.swapaxes(root, -1, -2))


def fit(rows: Array, values: Array, *, bounds: Bounds | None = None) -> LinearFit:
    """Least-squares estimate of `values` ≈ `rows` @ unknowns, one of them, as exact as can be.

    Args:
        rows: (R, p) rows, noise of unit covariance.
        values: (R,) values.
        bounds: Bounds of the unknowns, none if not given.
    """
    return fits(rows[None], values[None], bounds=bounds).of(0)


def fits(
    rows: Array,
    values: Array,
    *,
    bounds: Bounds | None = None,
    at: Array | None = None,
    refine: bool = True,
) -> LinearFit:
    """Least-squares estimates of C sets of values.

    Args:
        rows: (B, R, p) rows, noise of unit covariance: one system for all (B = 1), or C of them.
        values: (C, R) values.
        bounds: Bounds of the unknowns, none if not given.
        at: (C, p) what is in the bounds besides the estimates, as where an iteration has come to;
            zero if not given.
        refine: Whether to refine the estimates; steps of an iteration need not be.

    Source: paper eq. (6); Björck, Numerical Methods for Least Squares Problems, ch. 2.
    """
    powers = np.round(np.log2(column_norms(rows))).astype(int)
    scale = np.ldexp(np.ones(powers.shape), -powers)  # powers of two round nothing
    sides = _as_sides(values, len(rows))
    triangle, right, rest = _triangularised(rows, sides, scale)
    held = np.zeros((len(values), rows.shape[2]), dtype=bool)
    if bounds is None:
        scaled = _solved(triangle, right)
        if refine and rows.shape[1] <= _MOST_REFINED:
            scaled = _refined(rows * scale[:, None], sides, triangle, scaled)
    else:
        scaled = np.empty_like(right)
        start = np.zeros(held.shape) if at is None else at
        for i, own in enumerate(start):
            b, m = divmod(i, right.shape[2])
            limits, own = bounds.scaled(scale[b]), own / scale[b]
            scaled[b, :, m], held[i] = bounded(triangle[b], right[b, :, m], limits, own)
    residual_sum = rest + np.sum((triangle @ scaled - right) ** 2, axis=1)
    estimate = (scale[..., None] * scaled).transpose(0, 2, 1).reshape(held.shape)
    return LinearFit(
        frozen(estimate),
        frozen(triangle / scale[:, None]),
        frozen(residual_sum.reshape(-1)),
        frozen(held, np.bool_),
    )


def one_of(arrays: Array, i: int) -> Array:
    """The i-th of C arrays, or the one that all share."""
    return np.asarray(arrays[i if len(arrays) > 1 else 0])


def inverse_root(triangle: Array) -> Array:
    """(…, p, p) S with SSᵀ the covariance (RᵀR)⁻¹ of triangles R, (…, p, p)."""
    scale = column_norms(triangle)
    return np.asarray(np.linalg.inv(triangle / scale[..., None, :]) / scale[..., None])


def column_norms(rows: Array) -> Array:
    """(…, p) norms of the columns of rows (…, R, p), 1 where a column is zero."""
    norms = np.sqrt(np.einsum("...rp,...rp->...p", rows, rows))
    return np.where(norms > 0.0, norms, 1.0)


def _as_sides(values: Array, systems: int) -> Array:
    """(B, R, C / B) right-hand sides of B systems, of values (C, R)."""
    return np.asarray(values.reshape(systems, -1, values.shape[1]).transpose(0, 2, 1))


def _triangularised(rows: Array, sides: Array, scale: Array) -> tuple[Array, Array, Array]:
    """R of rows (B, R, p) with columns times `scale` (B, p), Qᵀ sides (B, p, m), and the rest.

    The rest (B, m) are the squares that no estimate removes.
    """
    systems, count, p = rows.shape
    block = np.zeros((systems, 0, p + sides.shape[2]))
    for start in range(0, max(count, 1), _CHUNK):
        part = slice(start, start + _CHUNK)
        above, taken = block.shape[1], rows[:, part].shape[1]
        stacked = np.empty((systems, above + taken, block.shape[2]))
        stacked[:, :above] = block
        np.multiply(rows[:, part], scale[:, None], out=stacked[:, above:, :p])
        stacked[:, above:, p:] = sides[:, part]
        block = np.asarray(np.linalg.qr(stacked, mode="r"))
    full = np.zeros((systems, max(p, block.shape[1]), block.shape[2]))
    full[:, : block.shape[1]] = block
    return full[:, :p, :p], full[:, :p, p:], np.sum(full[:, p:, p:] ** 2, axis=1)


def _refined(rows: Array, sides: Array, triangle: Array, estimate: Array) -> Array:
    """Estimates refined together with their residuals, which are formed in extended precision.

    With large residuals a refinement of the estimate alone would stop at the square of the
    condition number. Very many rows are not refined: it would take longer than the fit.

    Source: Björck, Numerical Methods for Least Squares Problems, section 2.9.3.
    """
    long = np.longdouble
    wide, aim = rows.astype(long), sides.astype(long)
    x = estimate.astype(long)
    residual = aim - wide @ x
    for _ in range(_REFINEMENTS):
        open_ = aim - residual - wide @ x
        slope = -(wide.transpose(0, 2, 1) @ residual)
        _, right, _ = _triangularised(rows, open_.astype(float), np.ones(triangle.shape[::2]))
        step = _solved(triangle, right - _solved_transposed(triangle, slope.astype(float)))
        x = x + step
        residual = residual + open_ - wide @ step.astype(long)
        small = 1e-17 * np.abs(estimate).max(axis=1, initial=0.0)
        if (np.abs(step).max(axis=1, initial=0.0) <= small).all():
            break
    return np.asarray(x, dtype=float)


def _solved_transposed(triangle: Array, right: Array) -> Array:
    """Forward substitution with the transposed triangles."""
    turned = np.swapaxes(triangle[:, ::-1, ::-1], 1, 2)
    return _solved(turned, right[:, ::-1])[:, ::-1]


def _solved(triangle: Array, right: Array) -> Array:
    """(B, p, m) back substitution; least norm where a triangle is singular."""
    p = right.shape[1]
    diagonal = np.abs(np.diagonal(triangle, axis1=1, axis2=2))
    singular = ~(diagonal.min(axis=1, initial=np.inf) > 1e-13 * diagonal.max(axis=1, initial=0.0))
    pivot = np.where(singular[:, None], 1.0, np.diagonal(triangle, axis1=1, axis2=2))
    solution = np.zeros(right.shape)
    for i in range(p - 1, -1, -1):
        known = triangle[:, i : i + 1, i + 1 :] @ solution[:, i + 1 :]
        solution[:, i] = (right[:, i] - known[:, 0]) / pivot[:, i, None]
    for b in np.flatnonzero(singular):
        solution[b] = np.linalg.lstsq(triangle[b], right[b], rcond=None)[0]
    return solution
