"""Functions of a statement as finite series: trigonometric in what turns, Chebyshev in what slides.

Rows and constraints are trigonometric polynomials of degree 2, or 1, in every joint that turns and
polynomials in every one that slides, so that values on a small grid say all of them: exact
derivatives of any order, and proofs that a function does not depend on a variable.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import chebyshev

from elastocal.arrays import Array, BoolArray, IntArray, freeze
from elastocal.proof.reference import margins, rows, size_of_rows
from elastocal.proof.statement import PointByDistance, Statement

ROUNDING = 2e-12
"""Share of the size of a function that coefficients, summed up, may have and be rounding."""


@dataclass(frozen=True)
class FiniteSeries:
    """A function of a variables with C components.

    Attributes:
        variables: (a,) numbers of the variables of the statement, those of lowest degree last.
        slides: (a,) which of them slide.
        low: (a,) lower end of the range of what slides [m], 0 for what turns.
        high: (a,) upper end.
        coefficients: (m_1, …, m_a, C): of 1, cos x, sin x, cos 2x, sin 2x, …, or of the
            polynomials T_0, T_1, … over the range.
        size: How large the terms are that the function is the sum of.
        dropped: Sum of the absolute coefficients that were left out as rounding.
    """

    variables: IntArray
    slides: BoolArray
    low: Array
    high: Array
    coefficients: Array
    size: float
    dropped: float

    def __post_init__(self) -> None:
        freeze(self, "variables", dtype=np.int64)
        freeze(self, "slides", dtype=np.bool_)
        freeze(self, "low", "high", "coefficients")

    @property
    def degrees(self) -> tuple[int, ...]:
        """Degree in each variable."""
        terms = self.coefficients.shape[:-1]
        return tuple(
            m - 1 if slides else m // 2 for m, slides in zip(terms, self.slides, strict=True)
        )

    def terms(self, i: int, x: Array, order: int = 0) -> Array:
        """(N, m_i) derivatives of the terms in the i-th variable at (N,) values of it."""
        count = self.coefficients.shape[i]
        if self.slides[i]:
            return chebyshev_terms(x, count, self.low[i], self.high[i], order)
        return turning_terms(x, count // 2, order)

    def at(self, x: Array, orders: Sequence[int] | None = None) -> Array:
        """(N, C) derivatives of these orders in the a variables at points (N, n)."""
        orders = orders if orders is not None else [0] * len(self.variables)
        found = np.broadcast_to(self.coefficients, (len(x), *self.coefficients.shape))
        for i, variable in enumerate(self.variables.tolist()):
            terms = self.terms(i, x[:, variable], orders[i])
            found = np.einsum("nm,nm...->n...", terms, found)
        return found


def turning_terms(x: Array, degree: int, order: int = 0) -> Array:
    """(N, 2 degree + 1) derivatives of 1, cos x, sin x, cos 2x, … at x (N,)."""
    found = np.empty((len(x), 2 * degree + 1))
    found[:, 0] = 1.0 if order == 0 else 0.0
    for k in range(1, degree + 1):
        turn = k * x + order * np.pi / 2.0
        found[:, 2 * k - 1] = k**order * np.cos(turn)
        found[:, 2 * k] = k**order * np.sin(turn)
    return found


def chebyshev_terms(x: Array, count: int, low: float, high: float, order: int = 0) -> Array:
    """(N, count) derivatives of T_0, T_1, … over [low, high] at x (N,)."""
    scale = 2.0 / (high - low)
    u = scale * (x - 0.5 * (low + high))
    each = [chebyshev.chebder(row, order) if order else row for row in np.eye(count)]
    return np.stack([scale**order * chebyshev.chebval(u, row) for row in each], axis=1)


def nodes(count: int, slides: bool, low: float, high: float) -> Array:
    """(count,) equidistant points of a turn, or Chebyshev points of a range."""
    if not slides:
        return 2.0 * np.pi * np.arange(count) / count
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    return middle + half * np.cos((2.0 * np.arange(count) + 1.0) * np.pi / (2.0 * count))


def series_of(
    statement: Statement, function: Callable[[Array], Array], degree: int, size: float
) -> FiniteSeries:
    """The series of a function of the points x of a statement.

    Args:
        statement: The statement; variables without width stay where they are.
        function: Values (N, C) at points (N, n); of `degree` in each q that turns, and in what
            slides.
        degree: Its degree.
        size: How large the terms are that it is the sum of.
    """
    return _cut(_sampled(statement, function, degree, size))


def _sampled(
    statement: Statement, function: Callable[[Array], Array], degree: int, size: float
) -> FiniteSeries:
    """The same with all degrees that it could have."""
    chosen = statement.active
    slides = statement.joints.slides[chosen]
    low, high = np.where(slides, statement.root[:, chosen], 0.0)
    # A variable that turns is in every joint value that it is mixed into.
    most = [degree * int(np.count_nonzero(statement.mix[:, i])) for i in chosen]
    counts = [m + 1 if s else 2 * m + 1 for m, s in zip(most, slides, strict=True)]
    axes = [nodes(c, *one) for c, *one in zip(counts, slides, low, high, strict=True)]
    grid = np.meshgrid(*axes, indexing="ij")
    x = np.tile(statement.root[0], (grid[0].size if grid else 1, 1))
    for i, values in zip(chosen, grid, strict=True):
        x[:, i] = values.ravel()
    found = function(x).reshape(*counts, -1)
    for axis, (values, count) in enumerate(zip(axes, counts, strict=True)):
        terms = (
            chebyshev_terms(values, count, low[axis], high[axis])
            if slides[axis]
            else turning_terms(values, count // 2)
        )
        found = np.moveaxis(np.tensordot(np.linalg.inv(terms), found, (1, axis)), 0, axis)
    return FiniteSeries(chosen, slides, low, high, found, size, 0.0)


def _cut(whole: FiniteSeries) -> FiniteSeries:
    """The same without degrees that it does not have, the variables of lowest degree last."""
    length = np.linalg.norm(whole.coefficients, axis=-1)
    kept: list[slice] = []
    for axis, slides in enumerate(whole.slides.tolist()):
        others = tuple(other for other in range(length.ndim) if other != axis)
        tail = length.sum(axis=others)[::-1].cumsum()[::-1]  # of a term and all behind it
        last = int(np.flatnonzero(np.append(True, tail[1:] > ROUNDING * whole.size)).max())
        kept.append(slice(last + 1 if slides else 2 * ((last + 1) // 2) + 1))
    inside = np.zeros(length.shape, dtype=bool)
    inside[tuple(kept)] = True
    dropped = float(length[~inside].sum())
    coefficients = whole.coefficients[tuple(kept)]
    order = np.argsort([-m for m in coefficients.shape[:-1]], kind="stable")
    return FiniteSeries(
        whole.variables[order],
        whole.slides[order],
        whole.low[order],
        whole.high[order],
        coefficients.transpose(*order, len(order)),
        whole.size,
        dropped,
    )


def rows_series(statement: Statement) -> FiniteSeries:
    """B(x), with C = rows · r components, times the k columns of a free load, which vary first."""

    def function(x: Array) -> Array:
        return rows(statement, x).reshape(len(x), -1)

    return series_of(statement, function, 2, size_of_rows(statement))


def constraint_series(statement: Statement) -> tuple[FiniteSeries, ...]:
    """The constraints, each of one component."""
    if not statement.constraints:
        return ()
    reach = _reach(statement)
    whole = _sampled(statement, lambda x: margins(statement, x), 2, 0.0)
    found = []
    for i, constraint in enumerate(statement.constraints):
        own = np.ascontiguousarray(whole.coefficients[..., i : i + 1])
        size = reach ** (2 if isinstance(constraint, PointByDistance) else 1) + np.abs(own).max()
        found.append(_cut(replace(whole, coefficients=own, size=float(size))))
    return tuple(found)


def _reach(statement: Statement) -> float:
    """How far points of the statement are from the origin, roughly [m]; at least 1."""
    points = [statement.joints.point, statement.markers, statement.load.point[None]]
    return float(max(1.0, np.abs(np.concatenate(points)).max()))
