"""How large sums of squares of normal numbers get: what is below with a given probability."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array

_NODES = 24  # of Talbot's contour
_HALVINGS = 50
_SHARES = 48  # nodes over the probability of a variance that is estimated
_NOTHING = 1e-12  # weight over the sum of all that does not count


def largest_likely(weight: Array, share: float = 0.95, dof: float = np.inf) -> float:
    """Root of what Σ w z² stays below with the probability `share`, z standard normal numbers.

    Args:
        weight: (s,) weights w, as the eigenvalues of a covariance.
        share: The probability, from 0.8.
        dof: Degrees of freedom of an estimated variance that all weights are multiples of; infinite
            if it is known.

    Source: Π (1 + 2 w s)^-½ / s is the Laplace transform of the distribution, and all that is
        singular of it is on the negative axis: inverted along Talbot's contour (Abate & Valkó
        2004).
    """
    total = float(np.maximum(weight, 0.0).sum())
    if not (0.0 < total < np.inf):
        return total
    weight = weight[weight > _NOTHING * total] / total
    variance: Array = np.ones(1)
    counts: Array = np.ones(1)
    if np.isfinite(dof):
        from scipy.special import chdtri

        place, width = np.polynomial.legendre.leggauss(_SHARES)
        variance = np.asarray(chdtri(dof, 0.5 - 0.5 * place) / dof, dtype=np.float64)
        counts = np.asarray(0.5 * width, dtype=np.float64)
    low, high = 0.0, 1.0
    while counts @ _below(weight, high * variance) < share:
        low, high = high, 2.0 * high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        enough = counts @ _below(weight, middle * variance) >= share
        low, high = (low, middle) if enough else (middle, high)
    return float(np.sqrt(total * high))


def weights_of(form: Array, covariance: Array) -> tuple[Array, Array]:
    """What xᵀ form x is a sum of squares of, where x is normal with a covariance (p, p).

    Returns:
        (p,) weights w, smallest first, so that it is Σ w z²; and (p,) the combination of x behind
        the largest.
    """
    scale = np.sqrt(np.diagonal(covariance))
    scale = np.where(scale > 0.0, scale, 1.0)
    size, axes = np.linalg.eigh(covariance / np.outer(scale, scale))
    root = scale[:, None] * axes * np.sqrt(np.maximum(size, 0.0))
    weight, vectors = np.linalg.eigh(root.T @ form @ root)
    return np.maximum(weight, 0.0), np.asarray(form @ root @ vectors[:, -1])


def _below(weight: Array, limit: Array) -> Array:
    """(n,) probability that Σ w z² is below each of the limits (n,), which are positive."""
    angle = np.arange(1, _NODES) * np.pi / _NODES
    cot = 1.0 / np.tan(angle)
    at = np.append(0.4 * _NODES + 0j, 0.4 * _NODES * angle * (cot + 1j))
    slope = np.append(0.5 + 0j, 1.0 + 1j * angle * (1.0 + cot**2) - 1j * cot)
    s = at / limit[:, None]
    transform = 1.0 / (s * np.prod(np.sqrt(1.0 + 2.0 * weight * s[..., None]), axis=2))
    return np.asarray(0.4 / limit * (np.exp(at) * slope * transform).real.sum(axis=1))
