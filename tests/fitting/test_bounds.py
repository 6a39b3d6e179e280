"""Least squares under bounds, against other ways to minimise the same."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from elastocal.arrays import Array
from elastocal.fitting.bounds import Bounds, bounded, tangent
from elastocal.fitting.least_squares import fits

INF = np.inf


def symmetric(place: int, count: int) -> Array:
    """(3, 3, count) a tensor across z of three unknowns from `place`: n1, n2, n12."""
    tensor = np.zeros((3, 3, count))
    tensor[0, 0, place] = tensor[1, 1, place + 1] = 1.0
    tensor[0, 1, place + 2] = tensor[1, 0, place + 2] = 1.0
    return tensor


BOUNDS = Bounds(
    np.array([-INF, 0.0, 0.0, 0.0, -INF, 0.0, 0.0, -INF]),
    np.stack([symmetric(2, 8), symmetric(5, 8)]),
)


def problem(rng: np.random.Generator) -> tuple[Array, Array]:
    """A triangle of eight unknowns, and values whose tensors are often negative."""
    triangle = np.linalg.qr(rng.normal(size=(20, 8)) * rng.uniform(0.3, 3.0, 8), mode="r")
    wanted = rng.normal(size=8)
    wanted[[2, 3, 5, 6]] = rng.uniform(-0.2, 1.0, 4)
    return triangle, triangle @ wanted


def by_roots(triangle: Array, right: Array, start: Array) -> float:
    """Least sum of squares with the tensors written as L Lᵀ."""

    def unknowns(z: Array) -> Array:
        parts = [z[:1], z[1:2] ** 2]
        for a, b, c in (z[2:5], z[5:8]):
            parts.append(np.array([a * a, b * b + c * c, a * b]))
        return np.concatenate(parts)

    def square(z: Array) -> float:
        return float(np.sum((triangle @ unknowns(z) - right) ** 2))

    return float(minimize(square, start, method="BFGS", options={"gtol": 1e-10}).fun)


@pytest.mark.parametrize("seed", range(30))
def test_tensors_are_never_negative_and_nothing_fits_better(seed: int) -> None:
    rng = np.random.default_rng(seed)
    triangle, right = problem(rng)
    at = 0.3 * rng.normal(size=8)
    step, held = bounded(triangle, right - triangle @ at, BOUNDS, at)
    found = at + step
    for tensor in BOUNDS.tensors:
        size = np.linalg.eigvalsh(tensor @ found)
        assert size[0] >= -1e-10 * size[-1]
    assert (found >= BOUNDS.lower - 1e-12).all()
    assert (found[held] == 0.0).all()
    square = float(np.sum((triangle @ found - right) ** 2))
    others = min(by_roots(triangle, right, rng.normal(size=8)) for _ in range(4))
    assert square <= others + 1e-7
    # What may move is at rest, to more digits than a sum of squares shows.
    moving = tangent(BOUNDS, held, found)
    slope = moving.T @ triangle.T @ (triangle @ found - right)
    assert np.abs(slope).max(initial=0.0) < 1e-8


@pytest.mark.parametrize("seed", range(10))
def test_no_unit_of_the_unknowns_loses_a_bound(seed: int) -> None:
    """Compliances are tiny numbers: tensors that are made of them are as tiny."""
    rng = np.random.default_rng(seed)
    triangle, right = problem(rng)
    units = 10.0 ** rng.uniform(8.0, 12.0, 8)
    units[[2, 3, 4]], units[[5, 6, 7]] = units[2], units[5]
    one = fits(triangle[None], right[None], bounds=BOUNDS)
    small = fits((triangle * units)[None], right[None], bounds=BOUNDS)
    np.testing.assert_allclose(small.estimate * units, one.estimate, rtol=1e-6, atol=1e-9)
    assert small.held.tolist() == one.held.tolist()
    for tensor in BOUNDS.tensors:
        size = np.linalg.eigvalsh(tensor @ small.estimate[0])
        assert size[0] >= -1e-10 * size[-1]


def test_a_tensor_of_which_nothing_is_left_is_held_as_a_whole() -> None:
    right = np.array([1.0, 2.0, -3.0, -3.0, 0.5, 1.0, 1.0, 0.0])
    found, held = bounded(np.eye(8), right, BOUNDS, np.zeros(8))
    np.testing.assert_array_equal(found, [1.0, 2.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    np.testing.assert_array_equal(held, [False] * 2 + [True] * 3 + [False] * 3)
    assert tangent(BOUNDS, held, found).shape == (8, 5)


def test_the_nearest_tensor_has_its_negative_part_taken_off() -> None:
    """n12 counts twice in the norm of the tensor: the projection onto those without one."""
    weight = np.diag([1.0, 1.0, 1.0, 1.0, np.sqrt(2.0), 1.0, 1.0, 1.0])
    wanted = np.array([0.0, 0.0, 2.0, 1.0, 1.8, 1.0, 1.0, 0.0])
    found, held = bounded(weight, weight @ wanted, BOUNDS, np.zeros(8))
    size, axes = np.linalg.eigh(np.array([[2.0, 1.8], [1.8, 1.0]]))
    nearest = size[1] * np.outer(axes[:, 1], axes[:, 1])
    np.testing.assert_allclose(found[2:5], [nearest[0, 0], nearest[1, 1], nearest[0, 1]], rtol=1e-9)
    assert not held[2:5].any()
    moving = tangent(BOUNDS, held, found)
    across = axes[:, 0]
    turned = np.einsum("k,klp,l->p", np.append(across, 0.0), BOUNDS.tensors[0],
                       np.append(across, 0.0))  # fmt: skip
    assert np.abs(turned @ moving).max() < 1e-9
