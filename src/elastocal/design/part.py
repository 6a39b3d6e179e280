"""A criterion of some of the unknowns, whatever the others are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.design.criterion import Criterion, InformationFunction
from elastocal.matrices import scaled_inverse


def information_on(wanted: Sequence[int], information: Array) -> Array:
    """(B, w, w) information on the unknowns `wanted` in (B, p, p): the Schur complement.

    Its inverse is their covariance. Source: Pukelsheim ch. 3, information for a subsystem.
    """
    return _schur(wanted, information)[0]


class OnPart(Criterion):
    """φ(M) = f of the information on some of the unknowns.

    The Schur complement is concave, monotone and homogeneous; so is φ if f is. With B the
    regression of the others on the wanted ones, the gradient is Kᵀ ∇f K, K = [I, -B].
    """

    def __init__(self, function: Criterion, wanted: Sequence[int]) -> None:
        """`function` is f, `wanted` the positions of its unknowns."""
        self.function, self.wanted = function, tuple(wanted)

    def value(self, information: Array) -> Array:
        return self.function.value(information_on(self.wanted, information))

    def gradient(self, information: Array) -> Array:
        return self.both(information)[1]

    def both(self, information: Array) -> tuple[Array, Array]:
        own, left = _schur(self.wanted, information)
        value, gradient = self.function.both(own)
        return value, left.transpose(0, 2, 1) @ gradient @ left


class InformationOnPart(OnPart, InformationFunction):
    """The same of an information function."""

    function: InformationFunction

    @property
    def smooth(self) -> InformationFunction:
        smooth = self.function.smooth
        return self if smooth is self.function else InformationOnPart(smooth, self.wanted)


def on_part(function: Criterion, wanted: Sequence[int], unknowns: int) -> Criterion:
    """`function` of the unknowns `wanted` among `unknowns`; itself if these are all."""
    if len(wanted) == unknowns:
        return function
    if isinstance(function, InformationFunction):
        return InformationOnPart(function, wanted)
    return OnPart(function, wanted)


def _schur(wanted: Sequence[int], information: Array) -> tuple[Array, Array]:
    """Schur complements (B, w, w), and K (B, w, p) with K M Kᵀ equal to them."""
    count, p = len(information), information.shape[-1]
    own = list(wanted)
    others = [i for i in range(p) if i not in own]
    cross = information[:, own][:, :, others]
    left = np.zeros((count, len(own), p))
    left[:, range(len(own)), own] = 1.0
    left[:, :, others] = -cross @ scaled_inverse(information[:, others][:, :, others])
    schur = information[:, own][:, :, own] + left[:, :, others] @ cross.transpose(0, 2, 1)
    return 0.5 * (schur + schur.transpose(0, 2, 1)), left
