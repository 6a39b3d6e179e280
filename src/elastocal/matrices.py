"""Information matrices: scaled to unit diagonal, inverted, judged."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array


def scaled_inverse(information: Array) -> Array:
    """Inverses of (B, p, p) information matrices, scaled to unit diagonal before factorising.

    Compliances differ by factors of a hundred, so their information by ten thousand. A ridge of
    1e-14 of the scaled diagonal turns a singular matrix into one with a huge inverse, so that a
    plan that cannot identify what matters gets the value zero instead of an exception.
    """
    p = information.shape[-1]
    diagonal = np.diagonal(information, axis1=-2, axis2=-1)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    outer = scale[..., :, None] * scale[..., None, :]
    return np.linalg.inv(information * outer + _RIDGE * np.eye(p)) * outer


def weakest(information: Array) -> float:
    """Smallest eigenvalue of a (p, p) information matrix scaled to unit diagonal."""
    diagonal = np.diagonal(information)
    if (diagonal <= 0.0).any():
        return 0.0
    scale = 1.0 / np.sqrt(diagonal)
    return float(np.linalg.eigvalsh(information * np.outer(scale, scale))[0])


_RIDGE = 1e-14
