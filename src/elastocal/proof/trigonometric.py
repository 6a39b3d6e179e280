"""Tables of third derivatives: how large they are at most, wherever the arm is.

A trigonometric polynomial of degree d that is at most g at N > 2d equidistant points is at most
g / cos(πd/N) anywhere; a polynomial at N > d Chebyshev points of a range g / cos(πd/2N) in it. So
the largest value on a grid, times one factor for each variable, is a bound: of scalars, and of
norms of vectors, which are the largest of scalars.

Source: Ehlich & Zeller 1964, by Riesz' lemma; in the notation of docs/math.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement, permutations
from math import prod

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.proof.grids import Grids
from elastocal.proof.series import FiniteSeries, constraint_series, rows_series
from elastocal.proof.statement import Statement

_LOOSE = 1.5  # factor of one variable that is too large
_HARDLY = 2e-3  # by how much the bound falls if all points become e times as many: not worth it
_ROUNDING = 1e-12  # share of the size of a function that its derivatives may be wrong by
_MARGIN = 1e-9  # share that is added to every entry


@dataclass(frozen=True)
class Thirds:
    """Bounds of third derivatives in x, at every point of the root and of its whole turns.

    Attributes:
        rows: (n, n, n) of the norm of ∂³B/∂x_i∂x_j∂x_k: Frobenius over rows and columns of V; of a
            free load the operator norm, the largest over |u| ≤ 1. Symmetric; zero where a
            variable is held.
        constraints: (C, n, n, n) the same of the constraints.
        points: (n,) points per variable of the table of the rows; 0 where it is held.
        factor: By what the largest value on the grid was multiplied, at most.
    """

    rows: Array
    constraints: Array
    points: IntArray
    factor: float

    def __post_init__(self) -> None:
        freeze(self, "rows", "constraints")
        freeze(self, "points", dtype=np.int64)


def third_derivatives(
    statement: Statement, effort: float = 1.0, points: Sequence[int] | None = None
) -> Thirds:
    """Bounds of all third derivatives of a statement.

    Args:
        statement: The statement, reduced.
        effort: About how many seconds of one core the table of the rows may take; more of them
            make it tighter.
        points: (n,) points per variable instead; held variables do not matter.
    """
    n = len(statement.joints)
    directions = statement.directions
    k = 1 if directions is None else directions.shape[1]
    series = rows_series(statement)
    chosen = None if points is None else [points[i] for i in series.variables]
    counts = chosen or points_for(series, effort, k)
    used = np.zeros(n, dtype=np.int64)
    used[series.variables] = counts
    constraints = [
        _table(one, points_for(one, effort / 20.0), 1, n) for one in constraint_series(statement)
    ]
    return Thirds(
        _table(series, counts, k, n),
        np.reshape(constraints, (len(constraints), n, n, n)),
        used,
        float(np.prod([factor(series, i, count) for i, count in enumerate(counts)])),
    )


def factor(series: FiniteSeries, i: int, count: int, order: int = 0) -> float:
    """By what the largest value at `count` points of the i-th variable is to be multiplied."""
    degree = series.degrees[i]
    if series.slides[i]:
        return float(1.0 / np.cos(np.pi * max(degree - order, 0) / (2.0 * count)))
    return float(1.0 / np.cos(np.pi * degree / count))


def points_for(series: FiniteSeries, effort: float, k: int = 1) -> list[int]:
    """Points per variable: as many as take `effort` seconds of a core, where they help most.

    There are never so few that one variable makes the bound half as large again.
    """
    counts = []
    for i, degree in enumerate(series.degrees):
        count = degree + 1 if series.slides[i] else 2 * degree + 1
        while factor(series, i, count) > _LOOSE:
            count += 1
        counts.append(count)
    while True:
        gains = [
            np.log(factor(series, i, count) / factor(series, i, count + 1)) * count
            for i, count in enumerate(counts)
        ]
        best = int(np.argmax(gains)) if gains else 0
        if not gains or gains[best] < _HARDLY:
            return counts
        counts[best] += 1
        if _seconds(series, counts, k) > effort:
            counts[best] -= 1
            return counts


def _seconds(series: FiniteSeries, counts: Sequence[int], k: int) -> float:
    """About how long a table takes on one core."""
    a, size = len(counts), series.coefficients.shape[-1]
    enough = [
        2 * d + 1 if slides else 4 * d + 1
        for d, slides in zip(series.degrees, series.slides, strict=True)
    ]
    few = prod(map(float, np.minimum(counts, enough)))
    made = few * size * (5.0 + 0.7 * k) + prod(map(float, counts)) * 0.5 * k * (k + 1) * 5.0
    return float(1e-9 * made * a * (a + 1) * (a + 2) / 6)


def _table(series: FiniteSeries, counts: Sequence[int], k: int, n: int) -> Array:
    """(n, n, n) bounds of the third derivatives of a function with k columns."""
    table = np.zeros((n, n, n))
    left_out = series.dropped + _ROUNDING * series.size
    grids = Grids(series, counts, k)
    for triple in combinations_with_replacement(range(len(counts)), 3):
        orders = [triple.count(i) for i in range(len(counts))]
        bound = grids.largest(orders)
        for i, count in enumerate(counts):
            bound *= factor(series, i, count, orders[i])
        steepest = prod(_steepest(series, i, order) for i, order in enumerate(orders))
        bound = bound * (1.0 + _MARGIN) + left_out * steepest
        for order in permutations(series.variables[list(triple)].tolist()):
            table[order] = bound
    return table


def _steepest(series: FiniteSeries, i: int, order: int) -> float:
    """How much a derivative in the i-th variable may be of a term that was left out, of size 1.

    Before it was cut what turns had a degree of 8 at most, what slides of 2.
    """
    if series.slides[i]:
        width = float(series.high[i] - series.low[i])
        return (1.0, 8.0 / width, 16.0 / width**2, 0.0)[order]
    return float(8.0**order)
