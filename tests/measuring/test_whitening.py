"""Factors of covariances."""

from __future__ import annotations

import numpy as np

from elastocal.measuring.whitening import noise_factors


def test_every_reading_has_the_factor_of_its_own_covariance() -> None:
    rng = np.random.default_rng(0)
    roots = rng.normal(size=(5, 3, 3))
    several = roots @ roots.transpose(0, 2, 1)
    for covariance in (several, np.broadcast_to(several[0], (4, 3, 3))):
        lower, inverse = noise_factors(covariance)
        np.testing.assert_allclose(lower @ lower.transpose(0, 2, 1), covariance, rtol=1e-12)
        np.testing.assert_allclose(
            inverse @ lower, np.tile(np.eye(3), (len(lower), 1, 1)), atol=1e-10
        )
        assert not np.triu(lower, 1).any()
