"""Criteria: how good an information matrix is.

An information function φ is concave, monotone and positively homogeneous of degree 1 on the
non-negative definite matrices (Pukelsheim, Optimal Design of Experiments, ch. 5). For such a
function everything else is written once. With G = ∇φ(M):

    φ(N) ≤ tr(G N) for every N, equality at N = M     (concave and homogeneous)
    sensitivity of a design point x:  s(x) = tr(G M_x)
    φ(any design of total weight m) ≤ m max_x s(x)     (the certificate)

Larger is better throughout this folder.
"""

from __future__ import annotations

import abc
from typing import NamedTuple, Self

import numpy as np

from elastocal.arrays import Array
from elastocal.matrices import scaled_inverse


class Bends(NamedTuple):
    """How −log φ changes along n directions."""

    slope: Array  # (n,)
    hessian: Array  # (n, n)


class Losses(NamedTuple):
    """φ(M) = (Σ_k tr(C_kᵀ M⁻¹ C_k)^s)^(−1/s), which compiled code knows; s is 1 for one loss."""

    roots: tuple[Array, ...]  # (p, r_k) the C_k
    sharpness: float  # s


class Criterion(abc.ABC):
    """A figure of merit of information matrices; larger is better."""

    @abc.abstractmethod
    def value(self, information: Array) -> Array:
        """(B,) values of information matrices (B, p, p); 0 where singular in what matters."""

    @abc.abstractmethod
    def gradient(self, information: Array) -> Array:
        """(B, p, p) symmetric gradients."""

    def both(self, information: Array) -> tuple[Array, Array]:
        """Values and gradients; a criterion may share work between the two."""
        return self.value(information), self.gradient(information)

    @property
    def losses(self) -> Losses | None:
        """The criterion as a mean of losses, None if it is none."""
        return None

    def near(self, information: Array) -> Self:
        """A cheaper criterion, nowhere smaller, and the same at (B, p, p) information matrices.

        A minimum over very many is replaced by one over those that decide there; what comes out
        can be asked again and only grows. Itself where nothing is cheaper, or nothing is missing.
        """
        return self


class InformationFunction(Criterion):
    """A concave, monotone, homogeneous criterion: it can be certified.

    `gradient` returns a G with φ(N) ≤ tr(G N) for every N. Where φ has a kink, G is that of a
    smooth function nearby, scaled so that the inequality holds: sound, and nearly tight.
    """

    @property
    def smooth(self) -> InformationFunction:
        """The differentiable function to optimise in place of this one; itself if smooth."""
        return self

    def bends(self, total: Array, directions: Array) -> Bends:
        """First and second derivatives of −log φ(M + Σ t_i M_i) in t at t = 0, for a smooth φ.

        −log φ is convex. Not finite where φ is 0. By differences of the gradient here; the
        criteria of this folder have closed forms.

        Args:
            total: (p, p) the M.
            directions: (n, p, p) the M_i, non-negative definite.
        """
        count = len(directions)
        reach = 1e-5 / np.einsum("nij,ij->n", directions, scaled_inverse(total[None])[0])
        step = reach[:, None, None] * directions
        nearby = np.concatenate([total[None], total + step, total - step])
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            gradients = self.gradient(nearby) / self.value(nearby)[:, None, None]
            slopes = -gradients.reshape(2 * count + 1, -1) @ directions.reshape(count, -1).T
            hessian = (slopes[1 : count + 1] - slopes[count + 1 :]) / (2.0 * reach[:, None])
        return Bends(slopes[0], (hessian + hessian.T) / 2.0)
