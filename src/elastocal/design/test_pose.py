"""Test-pose precision: the paper's criterion, for one or many test poses."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, frozen
from elastocal.design.criterion import InformationFunction
from elastocal.matrices import scaled_inverse


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
