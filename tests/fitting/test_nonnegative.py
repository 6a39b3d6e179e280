"""Least squares of what cannot be negative, against SciPy's and the conditions of an optimum."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import nnls

from elastocal.fitting.nonnegative import nonnegative


def made(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Rows of any shape, some of whose columns depend on others or point one way, and values."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=rng.integers(1, 25, 2))
    half = rows.shape[1] // 2
    if seed % 3 == 0:
        rows[:, :half] = np.abs(rows[:, :half])
    if seed % 4 == 0 and half:
        rows[:, -1] = 2.0 * rows[:, 0]
    if seed % 5 == 0:
        rows *= 10.0 ** rng.uniform(-6.0, 6.0, rows.shape[1])
    values = rng.normal(size=len(rows))
    return rows, -np.abs(values) if seed % 7 == 0 else values


@given(st.integers(0, 100_000))
def test_nothing_fits_better(seed: int) -> None:
    rows, values = made(seed)
    found = nonnegative(rows, values)
    left = values - rows @ found
    assert (found >= 0.0).all()
    size = np.linalg.norm(rows, axis=0) * np.linalg.norm(values)
    slope = rows.T @ left
    assert (slope <= 1e-9 * size).all()  # none that is held would gain
    assert (np.abs(slope[found > 0.0]) <= 1e-9 * size[found > 0.0]).all()
    assert np.linalg.norm(left) == pytest.approx(nnls(rows, values)[1], rel=1e-9, abs=1e-12)


def test_what_is_held_is_exactly_zero() -> None:
    found = nonnegative(np.eye(3), np.array([1.0, -2.0, 3.0]))
    assert found.tolist() == [1.0, 0.0, 3.0]
    assert nonnegative(np.zeros((2, 0)), np.ones(2)).shape == (0,)
    assert nonnegative(-np.ones((3, 2)), np.ones(3)).tolist() == [0.0, 0.0]
