"""Largest norms of derivatives of a series on a grid, without the rows at all of its points.

The square of a function of degree d has degree 2d: 4d + 1 points of a turn, or 2d + 1 of a range,
say all of it. So rows are made on a small grid only, and one number is carried on from there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.proof.series import FiniteSeries, chebyshev_terms, nodes, turning_terms

_AT_ONCE = 400_000  # numbers of rows that are made at once
_BLOCK = 40_000  # values that are made, looked at and forgotten
_FIRST = 50  # points of the largest traces, whose eigenvalues are taken first


class Grids:
    """A product grid of a series of k columns.

    Of one column norms are Euclidean; of several, operator norms: the root of the largest
    eigenvalue of the (k, k) products of the columns.
    """

    def __init__(self, series: FiniteSeries, counts: Sequence[int], k: int) -> None:
        """`counts` are the points per variable."""
        self._series, self._k = series, k
        self._few: list[Array] = []  # points of each variable at which rows are made
        self._more: list[Array | None] = []  # from what is there to all points
        places = zip(series.slides.tolist(), series.low.tolist(), series.high.tolist(), strict=True)
        for degree, count, (slides, low, high) in zip(series.degrees, counts, places, strict=True):
            enough = 2 * degree + 1 if slides else 4 * degree + 1
            few = nodes(min(enough, count), slides, low, high)
            self._few.append(few)
            if enough >= count:
                self._more.append(None)
                continue
            terms = [
                chebyshev_terms(x, enough, low, high) if slides else turning_terms(x, enough // 2)
                for x in (few, nodes(count, slides, low, high))
            ]
            self._more.append(terms[1] @ np.linalg.inv(terms[0]))

    def largest(self, orders: Sequence[int]) -> float:
        """The largest norm of the derivative of these orders in the variables."""
        few = zip(range(len(orders)), self._few, orders, strict=True)
        products = self._products([self._series.terms(*one) for one in few])
        if self._k == 1:
            square = max(float(block.max()) for block in self._blocks(products[0]))
        else:
            square = self._largest_eigenvalue(products)
        return float(np.sqrt(max(square, 0.0)))

    def _products(self, terms: list[Array]) -> Array:
        """(k (k + 1) / 2, points) products of the columns with each other on the small grid."""
        coefficients, k = self._series.coefficients, self._k
        *shape, size = coefficients.shape
        first, second = np.triu_indices(k)
        found = np.zeros((len(first), int(np.prod([len(t) for t in terms]))))
        by_column = coefficients.reshape(*shape, size // k, k)
        inner = found.shape[1] // len(terms[0])
        step = max(1, _AT_ONCE // (k * inner))
        for start in range(0, size // k, step):
            part = np.ascontiguousarray(by_column[..., start : start + step, :])
            for i, row in enumerate(terms[0]):  # what is made stays in the cache
                values = row @ part.reshape(len(row), -1)
                for matrix in terms[1:]:
                    values = values.reshape(matrix.shape[1], -1).T @ matrix.T
                values = values.reshape(-1, k, inner)
                here = found[:, i * inner : (i + 1) * inner]
                for pair, (a, b) in enumerate(zip(first, second, strict=True)):
                    here[pair] += np.einsum("cn,cn->n", values[:, a], values[:, b])
        return found

    def _spread(self, few: Array) -> Array:
        """What is given on the small grid, on all points of all variables but the last."""
        values = few
        for points, more in zip(self._few[:-1], self._more[:-1], strict=True):
            values = values.reshape(len(points), -1).T
            values = values if more is None else values @ more.T
        return np.ascontiguousarray(values.reshape(len(self._few[-1]), -1).T)

    def _blocks(self, few: Array) -> Iterator[Array]:
        """Values on all points, a part of them at a time."""
        values = self._spread(few)
        for part in self._parts(len(values)):
            yield self._last(values[part])

    def _parts(self, count: int) -> Iterator[slice]:
        step = max(1, _BLOCK // len(self._few[-1]))
        return (slice(i, i + step) for i in range(0, count, step))

    def _last(self, values: Array) -> Array:
        """Values on all points of the last variable, too."""
        more = self._more[-1]
        return values if more is None else np.asarray(values @ more.T)

    def _largest_eigenvalue(self, products: Array) -> float:
        """The largest eigenvalue of the forms whose entries are given on the small grid.

        Looked at are those alone whose trace, and then whose bound by trace and square, is above
        the largest so far.
        """
        first, second = np.triu_indices(self._k)
        diagonal = first == second
        trace = products[diagonal].sum(axis=0)
        top = np.argsort(-trace)[:_FIRST]
        largest = float(self._eigenvalues(products[:, top]).max())
        spread = [self._spread(row) for row in (trace, *products)]
        for part in self._parts(len(spread[0])):
            block = self._last(spread[0][part]).ravel()
            left = np.flatnonzero(block > largest)
            if not len(left):
                continue
            entries = np.stack([self._last(row[part]).ravel()[left] for row in spread[1:]])
            twice = np.where(diagonal, 1.0, 2.0)
            square = (twice[:, None] * entries**2).sum(axis=0)
            k = self._k
            most = block[left] / k + np.sqrt(
                np.maximum((square - block[left] ** 2 / k) * (k - 1) / k, 0.0)
            )
            left = np.flatnonzero(most > largest)
            if len(left):
                largest = max(largest, float(self._eigenvalues(entries[:, left]).max()))
        return largest

    def _eigenvalues(self, entries: Array) -> Array:
        """(N,) largest eigenvalues of forms with these entries, (k (k + 1) / 2, N)."""
        k = self._k
        forms = np.zeros((entries.shape[1], k, k))
        first, second = np.triu_indices(k)
        forms[:, first, second] = entries.T
        forms[:, second, first] = entries.T
        return np.asarray(np.linalg.eigvalsh(forms)[:, -1])
