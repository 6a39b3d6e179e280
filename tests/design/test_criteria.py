"""What makes a criterion an information function, checked on every criterion there is."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.design.criterion import InformationFunction
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.power_mean import PowerMean
from elastocal.design.test_pose import TestPosePrecision
from elastocal.errors import InputError
from elastocal.study.criteria import CRITERIA, criterion_of, losses, mean_test_pose
from tests.design.examples import (
    ALL,
    INFORMATION_FUNCTIONS,
    SMOOTH,
    information_matrix,
    study_with_two_test_poses,
)
from tests.design.worst import Worst

seeds = st.integers(0, 2**32 - 1)
reproducible = settings(max_examples=30)
# Eigenvalues and inverses of matrices of condition 1e3 are good to about 1e-13; means of order
# -300 multiply a relative error by 300.
ROUNDING = 1e-9


def value(criterion: object, matrix: np.ndarray) -> float:
    return float(criterion.value(matrix[None])[0])  # type: ignore[attr-defined]


def gradient(criterion: object, matrix: np.ndarray) -> np.ndarray:
    return np.asarray(criterion.gradient(matrix[None])[0])  # type: ignore[attr-defined]


def direction(rng: np.random.Generator, size: float) -> np.ndarray:
    matrix = rng.normal(size=(3, 3))
    return (matrix + matrix.T) * size


@pytest.mark.parametrize("name", ALL)
def test_gradient_against_central_differences(name: str) -> None:
    """Of the smooth stand-in where the criterion has kinks. Five-point stencil; its step is a
    small part of the smallest eigenvalue, for means of order -300 see their derivatives."""
    criterion = ALL[name]
    if isinstance(criterion, InformationFunction):
        criterion = criterion.smooth
    rng = np.random.default_rng(0)
    for _ in range(10):
        matrix = information_matrix(rng)
        smallest = np.linalg.eigvalsh(matrix)[0]
        along = direction(rng, 1e-4 * smallest)
        near = value(criterion, matrix + along) - value(criterion, matrix - along)
        far = value(criterion, matrix + 2 * along) - value(criterion, matrix - 2 * along)
        expected = (8.0 * near - far) / 12.0
        found = gradient(criterion, matrix)
        assert np.allclose(found, found.T, rtol=1e-9, atol=0.0)
        size = np.abs(found * along).sum()  # what could cancel in the scalar product
        assert np.sum(found * along) == pytest.approx(expected, abs=1e-6 * size)


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
def test_second_derivatives_against_differences(name: str) -> None:
    """In closed form, of the smooth stand-in; and the general ones, by differences."""
    smooth = INFORMATION_FUNCTIONS[name].smooth
    rng = np.random.default_rng(1)
    for _ in range(5):
        matrix = information_matrix(rng)
        size = np.linalg.eigvalsh(matrix)[0]
        rows = rng.normal(size=(4, 2, 3))
        directions = size * rows.transpose(0, 2, 1) @ rows

        def slopes(at: np.ndarray, along: np.ndarray = directions) -> np.ndarray:
            return -np.sum(gradient(smooth, at) * along, axis=(1, 2)) / value(smooth, at)

        step = 1e-4 * directions
        near = np.array([slopes(matrix + d) - slopes(matrix - d) for d in step])
        far = np.array([slopes(matrix + 2 * d) - slopes(matrix - 2 * d) for d in step])
        expected = (8.0 * near - far) / 12e-4
        for bends in (smooth.bends, partial(InformationFunction.bends, smooth)):
            found = bends(matrix, directions)
            np.testing.assert_allclose(found.slope, slopes(matrix), rtol=1e-9)
            np.testing.assert_allclose(found.hessian, expected, atol=1e-5 * np.abs(expected).max())
            assert np.linalg.eigvalsh(found.hessian)[0] > -1e-6 * np.abs(expected).max()  # convex


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
@reproducible
@given(seeds, st.floats(1e-6, 1e6))
def test_homogeneous(name: str, seed: int, factor: float) -> None:
    """Twice the experiments, twice the criterion: so efficiencies count experiments."""
    criterion, matrix = INFORMATION_FUNCTIONS[name], information_matrix(np.random.default_rng(seed))
    expected = factor * value(criterion, matrix)
    assert value(criterion, factor * matrix) == pytest.approx(expected, rel=ROUNDING)


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
@reproducible
@given(seeds)
def test_concave_at_midpoints(name: str, seed: int) -> None:
    rng, criterion = np.random.default_rng(seed), INFORMATION_FUNCTIONS[name]
    a, b = information_matrix(rng), information_matrix(rng)
    mean = (value(criterion, a) + value(criterion, b)) / 2.0
    assert value(criterion, (a + b) / 2.0) >= mean * (1.0 - ROUNDING)


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
@reproducible
@given(seeds)
def test_an_added_experiment_never_hurts(name: str, seed: int) -> None:
    rng, criterion = np.random.default_rng(seed), INFORMATION_FUNCTIONS[name]
    matrix, row = information_matrix(rng), rng.normal(size=3)
    assert value(criterion, matrix + np.outer(row, row)) >= value(criterion, matrix) * (
        1.0 - ROUNDING
    )


@pytest.mark.parametrize("name", SMOOTH)
@reproducible
@given(seeds)
def test_euler_identity(name: str, seed: int) -> None:
    """tr(G M) = φ(M), which makes the mean sensitivity over a design its value."""
    criterion, matrix = SMOOTH[name], information_matrix(np.random.default_rng(seed))
    total = np.sum(gradient(criterion, matrix) * matrix)
    assert total == pytest.approx(value(criterion, matrix), rel=ROUNDING)


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
@reproducible
@given(seeds)
def test_the_gradient_bounds_the_criterion_everywhere(name: str, seed: int) -> None:
    """φ(N) ≤ tr(G(M) N) for all M, N: what every certificate rests on, kinks included."""
    rng, criterion = np.random.default_rng(seed), INFORMATION_FUNCTIONS[name]
    slope = gradient(criterion, information_matrix(rng))
    for _ in range(20):
        other = information_matrix(rng)
        assert value(criterion, other) <= np.sum(slope * other) * (1.0 + ROUNDING)


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
def test_the_bound_holds_near_the_singular_and_at_kinks(name: str) -> None:
    """Equal eigenvalues (the kink of E) and nearly singular matrices, in both roles.

    Inverses carry a ridge of 1e-14, which costs 1e-8 where the smallest eigenvalue is 1e-6.
    """
    criterion, rng = INFORMATION_FUNCTIONS[name], np.random.default_rng(1)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    spectra = [(1.0, 1.0, 1.0), (1.0, 1.0, 5.0), (1.0, 1.0 + 1e-9, 2.0), (1e-6, 1.0, 1.0)]
    matrices = [turn @ np.diag(spectrum) @ turn.T for spectrum in spectra]
    for m in matrices:
        for n in matrices:
            assert value(criterion, n) <= np.sum(gradient(criterion, m) * n) * (1.0 + 1e-8)


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
def test_singular_information_is_worth_nothing_and_raises_nothing(name: str) -> None:
    """A plan that cannot identify what matters; relative to the same with it identified."""
    criterion = INFORMATION_FUNCTIONS[name]
    regular = value(criterion, np.eye(3))
    for singular in (np.diag([1.0, 0.0, 1.0]), np.ones((3, 3)), np.zeros((3, 3))):
        assert 0.0 <= value(criterion, singular) <= 1e-12 * regular
        assert np.isfinite(gradient(criterion, singular)).all()


def test_what_a_test_pose_does_not_involve_need_not_be_identified() -> None:
    criterion = INFORMATION_FUNCTIONS["rank-deficient test pose"]
    assert value(criterion, np.diag([1.0, 1.0, 0.0])) == pytest.approx(1.0 / 3.0)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("count", [0, 1, 7])
def test_a_batch_is_a_loop(name: str, count: int) -> None:
    criterion, rng = ALL[name], np.random.default_rng(2)
    batch = np.array([information_matrix(rng) for _ in range(count)]).reshape(count, 3, 3)
    values, gradients = criterion.value(batch), criterion.gradient(batch)
    assert values.shape == (count,)
    assert gradients.shape == (count, 3, 3)
    for matrix, v, g in zip(batch, values, gradients, strict=True):
        assert value(criterion, matrix) == pytest.approx(v, rel=1e-12)
        assert gradient(criterion, matrix) == pytest.approx(g, rel=1e-9)


@pytest.mark.parametrize("name", ALL)
def test_value_and_gradient_together_are_value_and_gradient(name: str) -> None:
    criterion, rng = ALL[name], np.random.default_rng(10)
    batch = np.array([*(information_matrix(rng) for _ in range(3)), np.diag([1.0, 1.0, 0.0])])
    values, gradients = criterion.both(batch)
    assert values == pytest.approx(criterion.value(batch), rel=1e-12)
    assert np.allclose(gradients, criterion.gradient(batch), rtol=1e-12)


@pytest.mark.parametrize("name", INFORMATION_FUNCTIONS)
def test_the_smooth_stand_in_is_close(name: str) -> None:
    """Means of order -300 of up to p = 3 eigenvalues, or six members, are within 1 percent."""
    criterion, rng = INFORMATION_FUNCTIONS[name], np.random.default_rng(3)
    for _ in range(20):
        matrix = information_matrix(rng)
        assert value(criterion.smooth, matrix) == pytest.approx(value(criterion, matrix), rel=1e-2)


def test_a_kink_costs_little_of_the_bound() -> None:
    """Where the worst criterion is clearly the worst, the bound of its gradient is tight."""
    matrix = np.diag([1.0, 1.2, 3.0])
    for criterion in (MatrixMean(-np.inf), Worst([MatrixMean(0.0), MatrixMean(-1)])):
        total = np.sum(gradient(criterion, matrix) * matrix)
        assert total == pytest.approx(value(criterion, matrix), rel=1e-3)


def test_matrix_means_are_means_of_eigenvalues() -> None:
    rng = np.random.default_rng(4)
    matrix = information_matrix(rng)
    eigenvalues = np.linalg.eigvalsh(matrix)
    expected = {
        0.0: np.prod(eigenvalues) ** (1 / 3),
        -1.0: 3.0 / np.sum(1.0 / eigenvalues),
        -0.5: (np.mean(eigenvalues**-0.5)) ** -2,
        -np.inf: eigenvalues.min(),
    }
    for order, mean in expected.items():
        assert value(MatrixMean(order), matrix) == pytest.approx(mean, rel=1e-12)
    with pytest.raises(ValueError, match="order of a matrix mean must be <= 0, found 1"):
        MatrixMean(1.0)


def test_d_does_not_depend_on_the_parametrisation() -> None:
    """det(TᵀMT) = det(T)² det(M): the ranking of plans stays as it was."""
    rng, d = np.random.default_rng(5), MatrixMean(0.0)
    a, b, T = information_matrix(rng), information_matrix(rng), rng.normal(size=(3, 3))
    ratio = value(d, T.T @ a @ T) / value(d, T.T @ b @ T)
    assert ratio == pytest.approx(value(d, a) / value(d, b), rel=1e-10)


def test_test_pose_precision_is_the_inverse_mean_square_error() -> None:
    """Paper eq. (20), and its mean over weighted test poses."""
    study, matrix = study_with_two_test_poses(), information_matrix(np.random.default_rng(6))
    covariance = np.linalg.inv(matrix)
    errors = [np.trace(p.regressor @ covariance @ p.regressor.T) for p in study.test_poses]
    expected = 1.0 / (0.25 * errors[0] + 0.75 * errors[1])
    assert value(mean_test_pose(study), matrix) == pytest.approx(expected, rel=1e-12)


def test_worst_is_the_minimum_of_its_members() -> None:
    study, matrix = study_with_two_test_poses(), information_matrix(np.random.default_rng(7))
    covariance = np.linalg.inv(matrix)
    errors = [np.trace(p.regressor @ covariance @ p.regressor.T) for p in study.test_poses]
    coordinates = [
        np.diagonal(p.regressor @ covariance @ p.regressor.T).max() for p in study.test_poses
    ]
    worst, one = (CRITERIA[name].function(study) for name in ("worst", "coordinate"))
    assert value(worst, matrix) == pytest.approx(1.0 / max(errors), rel=1e-12)
    assert value(one, matrix) == pytest.approx(1.0 / max(coordinates), rel=1e-12)
    with pytest.raises(ValueError, match="mean of no criteria"):
        PowerMean([])


def test_a_power_mean_lies_below_the_minimum_but_not_far() -> None:
    members = [TestPosePrecision(np.diag(w)) for w in ((1.0, 1, 1), (1.0, 2, 0.5), (0.9, 1, 1.2))]
    matrix = information_matrix(np.random.default_rng(8))
    least = value(Worst(members), matrix)
    for sharpness in (1.0, 10.0, 300.0):
        mean = value(PowerMean(members, sharpness=sharpness), matrix)
        assert least * 3.0 ** (-1.0 / sharpness) * (1 - 1e-12) <= mean <= least


def test_losses_are_in_physical_units() -> None:
    """All values of one diagonal information matrix, by hand."""
    study = study_with_two_test_poses()
    found = losses(study, np.diag([1.0, 4.0, 16.0]))
    assert found["A"] == pytest.approx(np.sqrt((1 + 1 / 4 + 1 / 16) / 3))
    assert found["D"] == pytest.approx(1 / 2)
    assert found["E"] == pytest.approx(1.0)
    assert found["G"] == pytest.approx(1.0)
    assert found["O1"] == pytest.approx(2.0)
    assert found["O2"] == pytest.approx(1 / 4)
    assert found["O3"] == pytest.approx(1.0)
    assert found["O4"] == pytest.approx(1 / 4)
    assert found["O5"] == pytest.approx(1 + 1 / 2 + 1 / 4)
    assert found["test-pose"] > 0.0
    assert found["coordinate"] <= found["worst"]


def test_losses_of_singular_information_are_infinite() -> None:
    found = losses(study_with_two_test_poses(), np.diag([1.0, 4.0, 0.0]))
    for name in ("A", "D", "E", "O5"):
        assert found[name] == np.inf
    for name in ("O2", "O3", "O4"):
        assert found[name] == 0.0
    assert found["test-pose"] > 1e6


def test_criteria_that_are_not_concave_are_not_information_functions() -> None:
    """O2 and O4 can be searched and reported, never certified: their type says so."""
    study = study_with_two_test_poses()
    plain = {
        name
        for name, criterion in CRITERIA.items()
        if not isinstance(criterion.function(study), InformationFunction)
    }
    assert plain == {"O2", "O4"}


def test_an_unknown_criterion_is_refused() -> None:
    with pytest.raises(
        InputError, match="no criterion 'T'; there are test-pose, worst, coordinate, A, D"
    ):
        criterion_of(replace(study_with_two_test_poses(), criterion="T"))


@pytest.mark.parametrize("order", [0.0, -0.5, -1.0, -np.inf])
def test_gradients_do_not_depend_on_the_scale(order: float) -> None:
    """Of degree 1: 1e-30 times the information, the same gradient."""
    root = np.random.default_rng(3).normal(size=(4, 4))
    matrix = (root @ root.T)[None]
    for scale in (1e-30, 1e30):
        here, there = (MatrixMean(order).gradient(m) for m in (matrix, scale * matrix))
        np.testing.assert_allclose(there, here, rtol=1e-9)
