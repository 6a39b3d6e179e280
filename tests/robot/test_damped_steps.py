"""Damped steps, where the singular values are on the table: a gantry's are those of its axes."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.robot.damped_steps import damped_steps


@pytest.mark.parametrize(
    ("small", "share"),
    [(0.5, 1.0), (2e-3, 1.0), (5e-4, 0.25), (1e-4, 0.01), (0.0, 0.0)],
)
def test_what_is_nearly_singular_fades(small: float, share: float) -> None:
    """Below a thousandth t of the largest singular value, (s/t)² of the exact step is left."""
    jacobian = np.diag([2.0, 1.0, 2.0 * small])[None]
    wanted = np.array([[0.1, 0.2, 0.3 * 2.0 * small]])
    steps = damped_steps(jacobian, wanted, np.ones(3, dtype=bool))
    np.testing.assert_allclose(steps.step[0], [0.05, 0.2, 0.3 * share], atol=1e-12)
    assert steps.damped[0] == (small < 1e-3)
