"""Worst case over test poses, few or very many: the points of a path.

φ(M) = min_k 1 / tr(L_k M⁻¹), L_k = A_kᵀ A_k. Of the thousands of points of a path only a handful
decide a plan. So a search takes the minimum over those that were worst somewhere on its way and
compares with all of them where it ends: `near`. Fewer points make φ larger, so what bounds the
minimum over some bounds the minimum over all.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from elastocal.arrays import Array, IntArray, frozen
from elastocal.design.criterion import Bends, InformationFunction, Losses
from elastocal.design.power_mean import mean_of_bends
from elastocal.design.test_pose import bent_losses
from elastocal.matrices import scaled_inverse, square_root

_FEW = 12  # poses that are all kept
_COVERED = 1e-7  # relative difference of losses that counts as none
_TOGETHER = 4_000_000  # losses that are in memory at once


class _Poses(InformationFunction):
    """A function of the losses tr(L_k M⁻¹) of K poses, or of some of them.

    Args:
        blocks: (K, r, p) rows A_k of every pose.
        sharpness: s of the power mean that stands in for the minimum.
    """

    def __init__(self, blocks: Array, sharpness: float = 300.0) -> None:
        if not len(blocks):
            raise ValueError("the worst of no criteria is not defined")
        self.sharpness = sharpness
        self._upper = np.triu_indices(blocks.shape[-1])
        losses = np.einsum("kri,krj->kij", blocks, blocks)
        # The trace of a product of symmetric matrices counts what is off the diagonal twice.
        twice = np.where(self._upper[0] == self._upper[1], 1.0, 2.0)
        self._all = frozen(losses[:, *self._upper] * twice)
        self._some = self._all
        self.chosen: IntArray | None = None

    def _with(self, chosen: IntArray | None, kind: type[_Poses]) -> _Poses:
        """The same poses, of which only `chosen` count; None for all."""
        other = kind.__new__(kind)
        other.sharpness, other._upper, other._all = self.sharpness, self._upper, self._all
        other.chosen = chosen
        other._some = self._all if chosen is None else self._all[chosen]
        return other

    def near(self, information: Array) -> Self:
        """These poses and those that are worst at any of (B, p, p) information matrices."""
        if self.chosen is None and len(self._all) <= _FEW:
            return self
        flat = self._flat(scaled_inverse(information))
        size = max(1, _TOGETHER // len(self._all))
        found: list[IntArray] = []
        for start in range(0, len(flat), size):
            losses = self._all @ flat[start : start + size].T
            worst = losses.argmax(axis=0)
            if self.chosen is not None:
                largest = losses[worst, np.arange(len(worst))]
                worst = worst[losses[self.chosen].max(axis=0) < largest * (1.0 - _COVERED)]
            found.append(worst)
        new = np.unique(np.concatenate(found)) if found else np.zeros(0, dtype=np.int64)
        if self.chosen is not None:
            new = np.setdiff1d(new, self.chosen)
        if not len(new):
            return self
        before = new[:0] if self.chosen is None else self.chosen
        return self._with(np.concatenate([before, new]), type(self))  # type: ignore[return-value]

    def _flat(self, inverse: Array) -> Array:
        """(B, p(p + 1)/2) upper triangles of symmetric matrices."""
        return inverse[:, *self._upper]

    def _shares(self, inverse: Array) -> tuple[Array, Array]:
        """Largest loss (B,) at inverses (B, p, p), and all losses over it (K, B)."""
        losses = self._some @ self._flat(inverse).T
        largest = losses.max(axis=0)
        safe = np.where(largest > 0.0, largest, 1.0)
        return largest, np.where(largest > 0.0, np.maximum(losses, 0.0) / safe, 1.0)

    def _mixture(self, inverse: Array, largest: Array, shares: Array) -> Array:
        """(B, p, p) gradients of the φ_k with weights share^(s + 1), summed."""
        safe = np.where(largest > 0.0, largest, np.finfo(float).tiny ** 0.5)
        weights = shares ** (self.sharpness - 1.0) / safe**2  # gradients are over loss squared
        return np.asarray(inverse @ self._summed(weights.T) @ inverse)

    def _summed(self, weights: Array) -> Array:
        """(B, p, p) sums of the L_k, with weights (B, K)."""
        row, column = self._upper
        sums = np.zeros((len(weights), row[-1] + 1, row[-1] + 1))
        sums[:, row, column] = (weights @ self._some) * np.where(row == column, 1.0, 0.5)
        sums[:, column, row] = sums[:, row, column]
        return sums


class WorstPose(_Poses):
    """φ(M) = min_k 1 / tr(L_k M⁻¹).

    Its gradient mixes those of the poses with weights of sum 1: every such mixture bounds the
    minimum from above. Source: ours.
    """

    def value(self, information: Array) -> Array:
        largest, _ = self._shares(scaled_inverse(information))
        with np.errstate(divide="ignore"):
            return np.where(largest > 0.0, 1.0 / largest, np.inf)

    def gradient(self, information: Array) -> Array:
        inverse = scaled_inverse(information)
        largest, shares = self._shares(inverse)
        total = (shares ** (self.sharpness + 1.0)).sum(axis=0)
        return self._mixture(inverse, largest, shares) / total[:, None, None]

    @property
    def smooth(self) -> InformationFunction:
        return self._with(self.chosen, SoftWorstPose)


class SoftWorstPose(_Poses):
    """(Σ φ_k^−s)^(−1/s): smooth, below the minimum, within K^(1/s) of it."""

    @property
    def losses(self) -> Losses:
        each = np.eye(len(self._some))
        weights = [self._summed(one[None])[0] for one in each]
        return Losses(tuple(square_root(weight) for weight in weights), self.sharpness)

    def value(self, information: Array) -> Array:
        return self._mean(*self._shares(scaled_inverse(information)))

    def gradient(self, information: Array) -> Array:
        return self.both(information)[1]

    def both(self, information: Array) -> tuple[Array, Array]:
        inverse = scaled_inverse(information)
        largest, shares = self._shares(inverse)
        total = (shares**self.sharpness).sum(axis=0)
        slope = self._mixture(inverse, largest, shares)
        return self._mean(largest, shares), slope * (total ** (-1.0 / self.sharpness - 1.0))[
            :, None, None
        ]

    def bends(self, total: Array, directions: Array) -> Bends:
        inverse = scaled_inverse(total[None])
        largest, shares = self._shares(inverse)
        losses = largest[0] * shares[:, 0]
        weights = shares[:, 0] ** self.sharpness
        weights /= weights.sum()
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = -self._some @ self._flat(inverse @ directions @ inverse).T / losses[:, None]
            mixed = self._summed((weights / losses)[None])[0]
            hessian = bent_losses(inverse[0], mixed, directions)
        hessian -= (slopes.T * weights) @ slopes
        return mean_of_bends(weights, slopes, hessian, self.sharpness)

    def _mean(self, largest: Array, shares: Array) -> Array:
        mean = (shares**self.sharpness).sum(axis=0) ** (-1.0 / self.sharpness)
        with np.errstate(divide="ignore"):
            return np.where(largest > 0.0, mean / largest, np.inf)
