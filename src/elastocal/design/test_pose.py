"""Test-pose precision: the paper's criterion, for one or many test poses."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.design.criterion import Bends, InformationFunction, Losses
from elastocal.matrices import scaled_inverse, square_root


class TestPosePrecision(InformationFunction):
    """φ(M) = 1 / tr(L M⁻¹), with L = Σ w_k A0_kᵀ A0_k over the test poses.

    1/φ is the mean square position error after compensation at the test poses, ρ0². With L the
    identity it is A-optimality. Known to statisticians as L- or I-optimality.

    Source: paper eq. (20); several weighted test poses are ours.
    """

    __test__ = False  # not a test, whatever pytest may think

    def __init__(self, weight: Array) -> None:
        """`weight` is L, (p, p), non-negative definite."""
        self.weight = frozen(weight)

    @property
    def losses(self) -> Losses:
        return Losses((square_root(self.weight),), 1.0)

    def value(self, information: Array) -> Array:
        loss = np.einsum("bij,ij->b", scaled_inverse(information), self.weight)
        with np.errstate(divide="ignore"):
            return np.where(loss > 0.0, 1.0 / loss, np.inf)

    def gradient(self, information: Array) -> Array:
        return self.both(information)[1]

    def both(self, information: Array) -> tuple[Array, Array]:
        inverse = scaled_inverse(information)
        pulled = inverse @ self.weight @ inverse
        loss = np.einsum("bij,ij->b", inverse, self.weight)
        with np.errstate(divide="ignore"):
            return 1.0 / loss, pulled / loss[:, None, None] ** 2

    def bends(self, total: Array, directions: Array) -> Bends:
        inverse = scaled_inverse(total[None])[0]
        loss = float(np.sum(inverse * self.weight))
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = -np.einsum("nij,ij->n", directions, inverse @ self.weight @ inverse) / loss
            hessian = bent_losses(inverse, self.weight, directions) / loss
        return Bends(slope, hessian - np.outer(slope, slope))


def bent_losses(inverse: Array, weight: Array, directions: Array) -> Array:
    """(n, n) second derivatives of tr(L M⁻¹) in n directions: tr(L M⁻¹ M_i M⁻¹ M_j M⁻¹), twice.

    Source: ours. With L = C Cᵀ and Y_i = Cᵀ M⁻¹ M_i these are tr(Y_i M⁻¹ Y_jᵀ).
    """
    count, p = len(directions), len(inverse)
    # Directions are symmetric; few products of large matrices take less than many of small ones.
    images = directions.reshape(-1, p) @ (inverse @ square_root(weight))
    images = images.reshape(count, p, -1).transpose(0, 2, 1).reshape(-1, p)
    turned = images @ inverse
    return np.asarray(2.0 * turned.reshape(count, -1) @ images.reshape(count, -1).T)
