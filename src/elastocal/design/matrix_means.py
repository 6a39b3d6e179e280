"""Matrix means: D-, A-, E-optimality and O5 are one family."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import Bends, InformationFunction


class MatrixMean(InformationFunction):
    """φ(M) = (tr M^q / p)^(1/q): the power mean of the eigenvalues.

    Orders 0, −1/2, −1, −∞ give D, O5, A and E. (O1 is the square root of D, O3 that of E.)
    For E the gradient is that of the mean of a very negative order, normalised to trace 1:
    every such density matrix bounds the smallest eigenvalue from above.

    Source: Pukelsheim (2006) ch. 6; Table 1 of the paper for the names.
    """

    def __init__(self, order: float, sharpness: float = 300.0) -> None:
        """`order` is q ≤ 0; `sharpness` is −q of the stand-in for q = −∞."""
        if not order <= 0.0:
            raise ValueError(f"the order of a matrix mean must be <= 0, found {order}")
        self.order, self.sharpness = order, sharpness

    def value(self, information: Array) -> Array:
        return self._mean(np.maximum(np.linalg.eigvalsh(information), 0.0))

    def gradient(self, information: Array) -> Array:
        return self.both(information)[1]

    def both(self, information: Array) -> tuple[Array, Array]:
        values, vectors = np.linalg.eigh(information)
        value = self._mean(np.maximum(values, 0.0))
        largest = np.maximum(values[:, -1:], np.finfo(float).tiny)
        values = np.maximum(values, 1e-15 * largest)
        if self.order == -np.inf:
            powers = (values / values[:, :1]) ** (-self.sharpness - 1.0)
            powers /= powers.sum(axis=1, keepdims=True)
        else:
            mean = self._mean(values)[:, None]
            powers = (values / mean) ** (self.order - 1.0) / values.shape[1]
        return value, (vectors * powers[:, None, :]) @ vectors.transpose(0, 2, 1)

    def bends(self, total: Array, directions: Array) -> Bends:
        if self.order == -np.inf:
            return self.smooth.bends(total, directions)
        values, vectors = np.linalg.eigh(total)
        count, p = len(directions), len(values)
        if not values[0] > 1e-15 * values[-1]:
            return Bends(np.full(count, np.nan), np.full((count, count), np.nan))
        seen = vectors.T @ directions @ vectors
        # −log φ = −log(tr M^q)/q, relative to the mean; divided differences of λ^(q−1).
        ratios = values / self._mean(values[None])[0]
        slopes = ratios ** (self.order - 1.0)
        apart = ratios[:, None] - ratios
        close = np.abs(apart) < 1e-6 * ratios
        middle = (0.5 * (ratios[:, None] + ratios)) ** (self.order - 2.0) * (self.order - 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            divided = np.where(close, middle, (slopes[:, None] - slopes) / apart)
        mean = values[0] / ratios[0]
        slope = -np.einsum("nii,i->n", seen, slopes) / (p * mean)
        flat = seen.reshape(count, -1)
        hessian = -(flat * divided.ravel()) @ flat.T / (p * mean**2)
        return Bends(slope, hessian + self.order * np.outer(slope, slope))

    @property
    def smooth(self) -> InformationFunction:
        if self.order == -np.inf:
            return MatrixMean(-self.sharpness)
        return self

    def _mean(self, values: Array) -> Array:
        smallest = values.min(axis=1)
        if self.order == -np.inf:
            return smallest
        safe = np.where(smallest > 0.0, smallest, 1.0)
        ratios = np.where(smallest[:, None] > 0.0, values / safe[:, None], 1.0)
        if self.order == 0.0:
            mean = np.exp(np.log(ratios).mean(axis=1))
        else:
            mean = (ratios**self.order).mean(axis=1) ** (1.0 / self.order)
        return np.where(smallest > 0.0, safe * mean, 0.0)
