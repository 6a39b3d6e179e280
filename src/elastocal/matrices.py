"""Information matrices: scaled and inverted; their rank, and which unknowns are confounded.

Whether information is singular is asked in many places: before a campaign, after it, when an
experiment is left out, while a design is sought. It is answered here, with the tolerances side by
side. Compliances differ by factors of a hundred, so their information by ten thousand: nothing is
judged before it is scaled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import Doubt

SINGULAR = 1e-10
"""Eigenvalue of scaled information at which a combination of unknowns counts as not seen.

Its standard error is 1e5 times that of an unknown which shares nothing with the others.
"""

NEARLY_SINGULAR = 1e-5
"""Eigenvalue at which a design is too close to singular for a search to follow its criterion."""

_BLIND = 1e-18  # share of the largest information below which that of an unknown is rounding
_INVOLVED = 1e-6  # squared component of an unknown in what is not seen, or product of two
_SYMMETRIC = 1e-6  # difference of an entry and its mirror image, as a correlation
_LOST = 1e-15  # share of the largest entry that is lost in the others
_NEGATIVE = 1e-8  # eigenvalue of correlations below zero that is put down to rounding
_LESS = 1e-9  # the same of information, as a share of its largest entry
_RIDGE = 1e-14  # added to a scaled diagonal before it is inverted


def is_symmetric(matrix: Array) -> bool:
    """Whether a covariance or information (p, p) is symmetric, but for rounding on its scale."""
    size = np.sqrt(np.abs(np.diagonal(matrix)))
    rounding = _SYMMETRIC * np.outer(size, size) + _LOST * np.abs(matrix).max()
    return bool((np.abs(matrix - matrix.T) <= rounding).all())


def is_covariance(matrix: Array) -> bool:
    """Whether no combination of unknowns has a negative variance in a symmetric (p, p)."""
    scale = np.sqrt(np.maximum(np.abs(np.diagonal(matrix)), 1e-300))
    with np.errstate(over="ignore"):  # no correlation is beyond 1, least of all infinite
        scaled = np.clip(matrix / np.outer(scale, scale), -2.0, 2.0)
    return bool(np.linalg.eigvalsh(scaled)[0] >= -_NEGATIVE * len(matrix))


def is_information(matrix: Array) -> bool:
    """Whether a symmetric (p, p) tells of no combination of unknowns less than nothing.

    What is unknown has rounding of the others in place of zero, so their size is the scale.
    """
    return bool(np.linalg.eigvalsh(matrix)[0] >= -_LESS * np.abs(matrix).max())


def scaled_inverse(information: Array) -> Array:
    """Inverses of (B, p, p) information matrices, scaled to unit diagonal before factorising.

    A ridge of 1e-14 of the scaled diagonal turns a singular matrix into one with a huge inverse,
    so that a plan that cannot identify what matters gets the value zero instead of an exception.
    """
    p = information.shape[-1]
    diagonal = np.diagonal(information, axis1=-2, axis2=-1)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    outer = scale[..., :, None] * scale[..., None, :]
    return np.linalg.inv(information * outer + _RIDGE * np.eye(p)) * outer


def eliminated(matrices: Array, right: Array) -> Array:
    """Solutions (p, m, N) of N systems (p, p, N), batch last; both are overwritten.

    Nothing is exchanged, so it is for matrices that need no pivots: positive definite ones, or
    with more on the diagonal than beside it. All N are solved together, one row at a time, which
    for few unknowns takes a quarter of the time of one after the other.
    """
    p = len(matrices)
    for i in range(p - 1):
        share = (matrices[i + 1 :, i] / matrices[i, i])[:, None]
        matrices[i + 1 :, i + 1 :] -= share * matrices[i, i + 1 :]
        right[i + 1 :] -= share * right[i]
    for i in range(p - 1, -1, -1):
        for j in range(i + 1, p):
            right[i] -= matrices[i, j] * right[j]
        right[i] /= matrices[i, i]
    return right


def square_root(matrix: Array) -> Array:
    """V with V Vᵀ = G, (p, rank), of a non-negative definite G."""
    values, vectors = np.linalg.eigh((matrix + matrix.T) / 2.0)
    keep = values > 1e-14 * max(values[-1], 0.0)
    return vectors[:, keep] * np.sqrt(values[keep])


def rank_of(
    information: Array, *, scale: Array | None = None, tolerance: float = SINGULAR
) -> IntArray:
    """(B,) numbers of combinations of unknowns that information (B, p, p) sees.

    Args:
        information: Information matrices, or one of shape (p, p).
        scale: (p, p) information whose diagonal is the scale. Give the whole where information
            is what is left of it: on its own scale a rest of rounding would look like knowledge.
        tolerance: Eigenvalue on that scale at which a combination is not seen.

    Source: ours.
    """
    values = np.linalg.eigvalsh(_scaled(information, information if scale is None else scale))
    return np.asarray(np.sum(values > tolerance, axis=-1))


@dataclass(frozen=True)
class Confounded:
    """Unknowns that information does not tell apart.

    Attributes:
        members: Their positions; a single one is not seen at all.
        seen: Number of their combinations that are seen, fewer than there are members.
    """

    members: tuple[int, ...]
    seen: int

    def doubt(self, names: Sequence[str]) -> Doubt:
        """The same of unknowns with names."""
        about = tuple(names[i] for i in self.members)
        if not self.seen:
            return Doubt("not-seen", about)
        return Doubt("confounded", about, numbers={"seen": self.seen})


def confounded(information: Array) -> tuple[Confounded, ...]:
    """What information (p, p) leaves open, in the smallest groups that have nothing in common.

    Its rank is p less what the groups lack. Empty if every unknown is identified; else those that
    are not seen at all come first.

    Source: ours. Groups are the blocks of the projector on the null space, which, unlike single
    null vectors, is unique.
    """
    values, vectors = np.linalg.eigh(_scaled(information, information))
    null = vectors[:, values <= SINGULAR]
    tied = np.abs(null @ null.T) > _INVOLVED
    groups = []
    left = set(np.flatnonzero(np.diagonal(tied)).tolist())
    while left:
        members, reached = set(), {min(left)}
        while reached:
            members |= reached
            reached = set(np.flatnonzero(tied[sorted(reached)].any(axis=0)).tolist()) - members
        left -= members
        chosen = sorted(members)
        open_ = float(np.sum(null[chosen] ** 2))
        groups.append(Confounded(tuple(chosen), len(chosen) - round(open_)))
    return tuple(sorted(groups, key=lambda group: (group.seen > 0, group.members)))


def _scaled(information: Array, whole: Array) -> Array:
    """Information over the roots of the diagonal of `whole`; unknowns it does not see are zero."""
    diagonal = np.diagonal(whole, axis1=-2, axis2=-1)
    seen = diagonal > _BLIND * np.max(diagonal, axis=-1, initial=0.0, keepdims=True)
    root = np.where(seen, 1.0 / np.sqrt(np.where(seen, diagonal, 1.0)), 0.0)
    return np.asarray(information * (root[..., :, None] * root[..., None, :]))


def freedom_of(covariance: Array, by_noise: Array, dof: float, rows: Array) -> Array:
    """Degrees of freedom of combinations of estimates.

    Args:
        covariance: (p, p) of the estimates.
        by_noise: (p, p) the part of it that grows with a noise that was found.
        dof: Degrees of freedom of that noise; infinite if it is known.
        rows: (K, p) the combinations.

    Returns:
        (K,), infinite for what rests on no noise that was found.

    Source: Satterthwaite 1946: ν (v / v_d)² with v = cᵀ C c, v_d = cᵀ D c.
    """
    whole = np.einsum("kp,pq,kq->k", rows, covariance, rows)
    noise = np.einsum("kp,pq,kq->k", rows, by_noise, rows)
    resting = noise > _RESTS * whole
    ratio = np.where(resting, whole / np.where(resting, noise, 1.0), np.inf)
    return np.asarray(dof * ratio**2)


_RESTS = 1e-9  # share of a variance that may as well be no noise at all
