"""Worst case over several criteria, and floors under what a criterion ignores."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import InformationFunction
from elastocal.design.test_pose import TestPosePrecision


class _Several(InformationFunction):
    """A function of several information functions."""

    def __init__(self, members: Sequence[InformationFunction], sharpness: float = 300.0) -> None:
        """`members` are the φ_k, all in the same unit."""
        if not members:
            raise ValueError("the worst of no criteria is not defined")
        self.members, self.sharpness = tuple(members), sharpness

    def near(self, information: Array) -> Self:
        members = [member.near(information) for member in self.members]
        if all(new is old for new, old in zip(members, self.members, strict=True)):
            return self
        return type(self)(members, self.sharpness)

    def _mixture(self, information: Array) -> tuple[Array, Array]:
        """Gradients of the members with weights (K, B) that fall off as a power of φ_k, summed."""
        values = np.array([member.value(information) for member in self.members])
        least = np.maximum(values.min(axis=0), np.finfo(float).tiny)
        powers = (np.maximum(values, least) / least) ** (-self.sharpness - 1.0)
        gradients = np.array([member.gradient(information) for member in self.members])
        return np.einsum("kb,kbij->bij", powers, gradients), powers


class Worst(_Several):
    """φ(M) = min_k φ_k(M), again an information function.

    The gradient mixes those of the members with weights of sum 1: every such mixture bounds the
    minimum from above. Source: ours.
    """

    def value(self, information: Array) -> Array:
        return np.min([member.value(information) for member in self.members], axis=0)

    def gradient(self, information: Array) -> Array:
        gradient, powers = self._mixture(information)
        return gradient / powers.sum(axis=0)[:, None, None]

    @property
    def smooth(self) -> InformationFunction:
        if len(self.members) == 1:
            return self.members[0].smooth
        return PowerMean(self.members, self.sharpness)


class PowerMean(_Several):
    """(Σ φ_k^−s)^(−1/s): smooth, below the minimum, within K^(1/s) of it."""

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


def floored(criterion: InformationFunction, scale: Array, share: float) -> InformationFunction:
    """`criterion` with a small penalty on the variance of every unknown.

    A criterion that does not involve every unknown can have a singular optimum, at which some
    unknowns are not identified at all. This one, 1 / (1/φ + share · tr(D M⁻¹)), is again an
    information function and has none. Source: ours.

    Args:
        criterion: Criterion to protect.
        scale: (p, p) typical information of one experiment: D is its diagonal over p times the
            loss 1/φ there, so that `share` is relative.
        share: Size of the penalty.
    """
    loss = 1.0 / float(criterion.value(scale[None])[0])
    weight = np.diag(np.diagonal(scale)) * (share * loss / len(scale))
    return PowerMean([criterion.smooth, TestPosePrecision(weight)], 1.0)
