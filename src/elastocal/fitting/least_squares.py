"""Linear least squares: scaled columns, QR in chunks, optional bounds and prior.

In: rows and values whose noise has unit covariance. Out: estimate, triangular factor, residual sum.
Nothing here knows what the unknowns are. The normal equations are never formed: their condition
number is the square of that of the rows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, frozen

_CHUNK = 65536  # rows that are triangularised at once
_REFINEMENTS = 4


@dataclass(frozen=True)
class LinearFit:
    """A least-squares fit of p unknowns.

    Attributes:
        estimate: (p,) unknowns.
        triangle: (p, p) upper triangular R with RᵀR the information matrix.
        residual_sum: Sum of the squared residuals, those of the prior included.
        held: (p,) unknowns held at their bound.
    """

    estimate: Array
    triangle: Array
    residual_sum: float
    held: BoolArray

    @property
    def information(self) -> Array:
        """(p, p) information matrix."""
        return np.asarray(self.triangle.T @ self.triangle)


def fit(rows: Array, values: Array, *, lower: Array | None = None) -> LinearFit:
    """Least-squares estimate of `values` ≈ `rows` @ unknowns.

    Args:
        rows: (R, p) rows, noise of unit covariance.
        values: (R,) values.
        lower: (p,) lower bounds of the unknowns, none if not given.

    Source: paper eq. (6); Björck, Numerical Methods for Least Squares Problems, ch. 2.
    """
    powers = np.round(np.log2(column_norms(rows))).astype(int)
    scale = np.ldexp(np.ones(len(powers)), -powers)  # powers of two round nothing
    triangle, right, rest = _triangularised(rows, values, scale)
    if lower is None:
        scaled = _solved(triangle, right)
        if len(rows) <= _CHUNK:
            scaled = _refined(rows * scale, values, triangle, scaled)
        held = np.zeros(len(scale), dtype=bool)
    else:
        scaled, held = _bounded(triangle, right, lower / scale)
    residual_sum = rest + float(np.sum((triangle @ scaled - right) ** 2))
    return LinearFit(
        frozen(scale * scaled), frozen(triangle / scale), residual_sum, frozen(held, np.bool_)
    )


def column_norms(rows: Array) -> Array:
    """(p,) norms of the columns, 1 where a column is zero."""
    norms = np.sqrt(np.einsum("rp,rp->p", rows, rows))
    return np.where(norms > 0.0, norms, 1.0)


def _triangularised(rows: Array, values: Array, scale: Array) -> tuple[Array, Array, float]:
    """R of the scaled rows, Qᵀ values, and the sum of squares that no estimate can remove."""
    p = rows.shape[1]
    block = np.zeros((0, p + 1))
    for start in range(0, max(len(rows), 1), _CHUNK):
        part = slice(start, start + _CHUNK)
        stacked = np.concatenate([block, np.column_stack([rows[part] * scale, values[part]])])
        block = np.asarray(np.linalg.qr(stacked, mode="r"))
    full = np.zeros((p + 1, p + 1))
    full[: len(block)] = block
    return full[:p, :p], full[:p, p], float(full[p, p] ** 2)


def _refined(rows: Array, values: Array, triangle: Array, estimate: Array) -> Array:
    """Estimate refined together with its residuals, which are formed in extended precision.

    With large residuals a refinement of the estimate alone would stop at the square of the
    condition number. More rows than one chunk are not refined: it would take longer than the fit.

    Source: Björck, Numerical Methods for Least Squares Problems, section 2.9.3.
    """
    long = np.longdouble
    wide, aim = rows.astype(long), values.astype(long)
    x = estimate.astype(long)
    residual = aim - wide @ x
    for _ in range(_REFINEMENTS):
        open_ = aim - residual - wide @ x
        slope = -(wide.T @ residual)
        _, right, _ = _triangularised(rows, open_.astype(float), np.ones(rows.shape[1]))
        step = _solved(triangle, right - _solved_transposed(triangle, slope.astype(float)))
        x = x + step
        residual = residual + open_ - wide @ step.astype(long)
        if np.abs(step).max(initial=0.0) <= 1e-17 * np.abs(estimate).max(initial=0.0):
            break
    return np.asarray(x, dtype=float)


def _solved_transposed(triangle: Array, right: Array) -> Array:
    """Forward substitution with the transposed triangle."""
    return _solved(triangle[::-1, ::-1].T, right[::-1])[::-1]


def _solved(triangle: Array, right: Array) -> Array:
    """Back substitution; least norm where the triangle is singular."""
    p = len(right)
    diagonal = np.abs(np.diagonal(triangle))
    if p and diagonal.min() > 1e-13 * diagonal.max(initial=0.0):
        solution = np.zeros(p)
        for i in range(p - 1, -1, -1):
            solution[i] = (right[i] - triangle[i, i + 1 :] @ solution[i + 1 :]) / triangle[i, i]
        return solution
    return np.asarray(np.linalg.lstsq(triangle, right, rcond=None)[0])


def _bounded(triangle: Array, right: Array, lower: Array) -> tuple[Array, BoolArray]:
    """Estimate under lower bounds, and which unknowns are held at theirs."""
    from scipy.optimize import nnls

    above, _ = nnls(triangle, right - triangle @ lower)
    held = above == 0.0
    free = ~held
    solution = np.array(lower)
    if free.any():  # the free ones again, to the accuracy of the unbounded fit
        rest = right - triangle[:, held] @ lower[held]
        solution[free] = np.linalg.lstsq(triangle[:, free], rest, rcond=None)[0]
    return solution, held
