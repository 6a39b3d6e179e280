"""Several criteria as one: their power mean, and floors under what a criterion ignores."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import Bends, InformationFunction, Losses
from elastocal.design.test_pose import TestPosePrecision
from elastocal.matrices import scaled_inverse


class PowerMean(InformationFunction):
    """(Σ φ_k^−s)^(−1/s): smooth, below the minimum of the φ_k, within K^(1/s) of it."""

    def __init__(self, members: Sequence[InformationFunction], sharpness: float = 300.0) -> None:
        """`members` are the φ_k, all in the same unit."""
        if not members:
            raise ValueError("the mean of no criteria is not defined")
        self.members, self.sharpness = tuple(members), sharpness

    def near(self, information: Array) -> PowerMean:
        members = [member.near(information) for member in self.members]
        if all(new is old for new, old in zip(members, self.members, strict=True)):
            return self
        return PowerMean(members, self.sharpness)

    @property
    def losses(self) -> Losses | None:
        each = [member.losses for member in self.members]
        if any(losses is None or len(losses.roots) > 1 for losses in each):
            return None
        return Losses(tuple(losses.roots[0] for losses in each if losses), self.sharpness)

    def value(self, information: Array) -> Array:
        values = np.array([member.value(information) for member in self.members])
        least = values.min(axis=0)
        safe = np.where(least > 0.0, least, 1.0)
        ratios = np.where(least > 0.0, values / safe, 1.0)
        total = (ratios**-self.sharpness).sum(axis=0)
        return np.where(least > 0.0, safe * total ** (-1.0 / self.sharpness), 0.0)

    def gradient(self, information: Array) -> Array:
        gradient, powers = self._mixture(information)
        total = (powers ** (self.sharpness / (self.sharpness + 1.0))).sum(axis=0)
        return gradient * (total ** (-1.0 / self.sharpness - 1.0))[:, None, None]

    def bends(self, total: Array, directions: Array) -> Bends:
        values = np.array([member.value(total[None])[0] for member in self.members])
        least = np.maximum(values.min(), np.finfo(float).tiny)
        shares = (np.maximum(values, least) / least) ** -self.sharpness
        each = [member.bends(total, directions) for member in self.members]
        return mean_of_bends(
            shares / shares.sum(),
            np.array([bends.slope for bends in each]),
            sum(s * bends.hessian for s, bends in zip(shares / shares.sum(), each, strict=True)),
            self.sharpness,
        )

    def _mixture(self, information: Array) -> tuple[Array, Array]:
        """Gradients of the members with weights (K, B) that fall off as a power of φ_k, summed."""
        values = np.array([member.value(information) for member in self.members])
        least = np.maximum(values.min(axis=0), np.finfo(float).tiny)
        powers = (np.maximum(values, least) / least) ** (-self.sharpness - 1.0)
        gradients = np.array([member.gradient(information) for member in self.members])
        return np.einsum("kb,kbij->bij", powers, gradients), powers


def mean_of_bends(shares: Array, slopes: Array, hessian: Array, sharpness: float) -> Bends:
    """The `Bends` of a power mean from those of its members: log of a sum of exponentials.

    Args:
        shares: (K,) φ_k^−s over their sum.
        slopes: (K, n) of the members.
        hessian: (n, n) mean of the Hessians of the members, by those shares.
        sharpness: s.

    Source: ours.
    """
    slope = shares @ slopes
    spread = (slopes.T * shares) @ slopes - np.outer(slope, slope)
    return Bends(slope, hessian + sharpness * spread)


def floored(criterion: InformationFunction, scale: Array, share: float) -> InformationFunction:
    """`criterion` with a small penalty on the variance of every unknown.

    A criterion that does not involve every unknown can have a singular optimum, at which some
    unknowns are not identified at all. This one, 1 / (1/φ + share · tr(D M⁻¹)), is again an
    information function and has none. Source: ours.

    Args:
        criterion: Criterion to protect.
        scale: (p, p) typical information of one experiment, regular. D is diagonal, so that each
            unknown has the same part in tr(D M⁻¹) there, and all of them together the loss 1/φ:
            `share` is relative. What only prior information tells apart has no more of it.
        share: Size of the penalty.
    """
    loss = 1.0 / float(criterion.value(scale[None])[0])
    variance = np.diagonal(scaled_inverse(scale[None])[0])
    weight = np.diag(1.0 / variance) * (share * loss / len(scale))
    return PowerMean([criterion.smooth, TestPosePrecision(weight)], 1.0)
