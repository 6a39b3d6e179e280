"""Best fits against a rotation that is known, an independent route, and their own scatter."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from elastocal.errors import InputError
from elastocal.measuring.best_fit import best_fit, best_fits, turn_errors


@given(seed=st.integers(0, 2**31))
def test_a_rotation_and_a_shift_are_found_again(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turn = Rotation.random(random_state=seed % 2**31).as_matrix()
    points, shift = rng.normal(size=(6, 3)), 10.0 * rng.normal(size=3)
    fit = best_fit(points, points @ turn.T + shift)
    np.testing.assert_allclose(fit.rotation, turn, atol=1e-12)
    np.testing.assert_allclose(fit.shift, shift, atol=1e-11)
    assert fit.rms < 1e-12
    np.testing.assert_allclose(fit.applied(points), points @ turn.T + shift, atol=1e-11)


def test_as_another_program_fits_it() -> None:
    rng = np.random.default_rng(1)
    points, nominal = rng.normal(size=(2, 20, 3))
    fit = best_fit(points, nominal)
    own, other = points - points.mean(axis=0), nominal - nominal.mean(axis=0)
    turn, left = Rotation.align_vectors(other, own)
    np.testing.assert_allclose(fit.rotation, turn.as_matrix(), atol=1e-12)
    assert fit.rms == pytest.approx(left / np.sqrt(20))


def test_a_mirror_image_is_fitted_by_a_rotation() -> None:
    points = np.random.default_rng(2).normal(size=(8, 3))
    fit = best_fit(points, points * [1, 1, -1])
    assert np.linalg.det(fit.rotation) == pytest.approx(1.0)
    assert fit.rms > 0.1


def test_many_at_once_are_each_as_alone() -> None:
    rng = np.random.default_rng(3)
    points, nominal = rng.normal(size=(9, 3)), rng.normal(size=(4, 9, 3))
    rotation, shift, rms = best_fits(points, nominal)
    for i in range(4):
        one = best_fit(points, nominal[i])
        np.testing.assert_allclose(rotation[i], one.rotation, atol=1e-13)
        np.testing.assert_allclose(shift[i], one.shift, atol=1e-13)
        assert rms[i] == pytest.approx(one.rms)


@pytest.mark.parametrize(
    ("points", "found"),
    [
        (np.zeros((5, 3)), "1 distinct point$"),
        ([[0, 0, 0], [1, 0, 0], [1, 0, 0]], "2 distinct points"),
        ([[0, 0, 0], [1, 1, 0], [2, 2, 0], [5, 5, 0]], "4 points on one line"),
    ],
)
def test_too_few_points_are_refused(points: list[list[float]], found: str) -> None:
    with pytest.raises(InputError, match=found):
        best_fit(np.array(points, dtype=float), np.array(points, dtype=float))


def test_the_rotation_is_as_uncertain_as_it_scatters() -> None:
    rng = np.random.default_rng(4)
    nominal = np.repeat(rng.uniform(-1.5, 1.5, (30, 3)), 3, axis=0)
    nominal = nominal + rng.normal(0.0, 0.2, nominal.shape)
    group = np.repeat(np.arange(30), 3)
    found, promised = [], []
    for _ in range(400):
        together = rng.normal(0.0, 4e-4, (30, 3))[group]  # all markers of a configuration
        points = nominal + together + rng.normal(0.0, 5e-5, nominal.shape)
        fit = best_fit(points, nominal)
        found.append(Rotation.from_matrix(fit.rotation).as_rotvec())
        promised.append(turn_errors(fit, points, nominal, group))
    scatter = np.cov(np.array(found).T)
    assert np.trace(np.mean(promised, axis=0)) == pytest.approx(np.trace(scatter), rel=0.12)
