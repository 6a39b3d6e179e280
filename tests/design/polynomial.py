"""Design spaces of textbooks: one measurement with rows f(x) at a point x of a box."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from elastocal.arrays import Array, BoolArray

Rows = Callable[[Array], tuple[Array, Array]]
"""x (N, d) -> rows (N, p) and their derivatives (N, p, d)."""


class Regression:
    """A linear model whose regressor is a smooth function on a box, without constraints."""

    def __init__(self, rows: Rows, parameters: int, lower: Array, upper: Array) -> None:
        self.rows, self.parameters = rows, parameters
        self.lower, self.upper = np.asarray(lower, float), np.asarray(upper, float)

    core = None

    def parts(self, count: int) -> int:
        return 1

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        return rng.uniform(self.lower, self.upper, (count, len(self.lower)))

    def feasible(self, x: Array) -> BoolArray:
        return np.asarray((self.evaluate(x).margins >= 0.0).all(axis=1))

    def evaluate(self, x: Array, repeats: Array | None = None) -> RegressionEvaluation:
        return RegressionEvaluation(*self.rows(x))


class RegressionEvaluation:
    """One row at each of N points."""

    def __init__(self, rows: Array, slopes: Array) -> None:
        self.blocks, self._slopes = rows[:, None, :], slopes
        self.margins = np.zeros((len(rows), 0))

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        return np.einsum("np,npd->nd", block_cotangent[:, 0], self._slopes)


def polynomial(degree: int) -> Regression:
    """1, x, ..., x^degree on [-1, 1]."""

    def rows(x: Array) -> tuple[Array, Array]:
        powers = x ** np.arange(degree + 1)
        slopes = np.zeros_like(powers)
        slopes[:, 1:] = powers[:, :-1] * np.arange(1, degree + 1)
        return powers, slopes[:, :, None]

    return Regression(rows, degree + 1, np.array([-1.0]), np.array([1.0]))


def spring_balance(objects: int) -> Regression:
    """Weighing: x in [0, 1]^p says how much of each object lies on the pan of a spring balance."""

    def rows(x: Array) -> tuple[Array, Array]:
        return x, np.tile(np.eye(objects), (len(x), 1, 1))

    return Regression(rows, objects, np.zeros(objects), np.ones(objects))
