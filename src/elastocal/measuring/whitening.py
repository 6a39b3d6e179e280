"""Whitening: rows and readings divided by the noise they come with."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array


def noise_factors(covariance: Array) -> tuple[Array, Array]:
    """L with LLᵀ = covariance, and its inverse, (R, 3, 3) each, for covariances (R, 3, 3)."""
    if len(covariance) and (covariance == covariance[0]).all():
        one = np.linalg.cholesky(covariance[0])
        shape = covariance.shape
        return np.broadcast_to(one, shape), np.broadcast_to(np.linalg.inv(one), shape)
    root = np.asarray(np.linalg.cholesky(covariance), dtype=float)
    return root, np.asarray(np.linalg.inv(root), dtype=float)
