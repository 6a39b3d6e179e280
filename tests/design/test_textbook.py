"""Continuous designs with optima in closed form, found without being told of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from elastocal.design.continuous import ContinuousDesign, continuous_design
from elastocal.design.criterion import InformationFunction
from elastocal.design.exact import exact_design
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.refinement import Goal
from elastocal.design.test_pose import TestPosePrecision
from tests.design.polynomial import Regression, polynomial, spring_balance

D, A, E = MatrixMean(0.0), MatrixMean(-1.0), MatrixMean(-np.inf)
PAIRS = ((1.0, 1.0, 0.0), (1.0, 0.0, 1.0), (0.0, 1.0, 1.0))


@dataclass(frozen=True)
class Textbook:
    """A problem with its optimal design."""

    space: Regression
    criterion: InformationFunction
    points: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]

    def information(self) -> np.ndarray:
        rows = self.space.evaluate(np.array(self.points)).blocks
        return np.einsum("n,nri,nrj->ij", self.weights, rows, rows)


def line(*points: float) -> tuple[tuple[float, ...], ...]:
    return tuple((point,) for point in points)


ROOT = 1.0 / np.sqrt(5.0)
TEXTBOOK = {
    # Guest (1958), Hoel (1958): zeros of (1 - x²) P'(x), equal weights.
    "straight line, D": Textbook(polynomial(1), D, line(-1, 1), (1 / 2, 1 / 2)),
    "quadratic, D": Textbook(polynomial(2), D, line(-1, 0, 1), (1 / 3,) * 3),
    "cubic, D": Textbook(polynomial(3), D, line(-1, -ROOT, ROOT, 1), (1 / 4,) * 4),
    "quartic, D": Textbook(
        polynomial(4), D, line(-1, -np.sqrt(3 / 7), 0, np.sqrt(3 / 7), 1), (1 / 5,) * 5
    ),
    # Pukelsheim (2006) ch. 9: quadratic regression.
    "quadratic, A": Textbook(polynomial(2), A, line(-1, 0, 1), (1 / 4, 1 / 2, 1 / 4)),
    "quadratic, E": Textbook(polynomial(2), E, line(-1, 0, 1), (1 / 5, 3 / 5, 1 / 5)),
    # The leading coefficient alone: extrema of the Chebyshev polynomial, half weights at the ends.
    "quadratic, its leading coefficient": Textbook(
        polynomial(2),
        TestPosePrecision(np.diag([0.0, 0.0, 1.0])),
        line(-1, 0, 1),
        (1 / 4, 1 / 2, 1 / 4),
    ),
    # Spring balance, p odd: all weighings of (p + 1)/2 objects equally often.
    "spring balance of three, D": Textbook(spring_balance(3), D, PAIRS, (1 / 3,) * 3),
    "spring balance of three, A": Textbook(spring_balance(3), A, PAIRS, (1 / 3,) * 3),
}
SMOOTH = [name for name, book in TEXTBOOK.items() if book.criterion.smooth is book.criterion]


def sensitivities(book: Textbook, x: np.ndarray) -> np.ndarray:
    gradient = book.criterion.gradient(book.information()[None])[0]
    rows = book.space.evaluate(x).blocks[:, 0]
    return np.einsum("ni,ij,nj->n", rows, gradient, rows)


@pytest.mark.parametrize("name", SMOOTH)
def test_the_textbook_is_right(name: str) -> None:
    """Equivalence theorem on a fine grid, before anything is compared with these designs. For
    the spring balance the sensitivity is a convex quadratic, so the eight corners suffice."""
    book = TEXTBOOK[name]
    dimension = len(book.space.lower)
    fine = (
        np.linspace(-1.0, 1.0, 20001)[:, None]
        if dimension == 1
        else np.array(np.meshgrid(*[[0.0, 1.0]] * dimension)).reshape(dimension, -1).T
    )
    level = float(book.criterion.value(book.information()[None])[0])
    assert sensitivities(book, fine).max() <= level * (1.0 + 1e-9)
    support = sensitivities(book, np.array(book.points))
    assert support == pytest.approx(np.full(len(support), level), rel=1e-9)


@pytest.fixture(scope="module")
def designs() -> dict[str, ContinuousDesign]:
    return {
        name: continuous_design(book.space, book.criterion, np.random.default_rng(0))
        for name, book in TEXTBOOK.items()
    }


def weight_near(design: ContinuousDesign, point: tuple[float, ...], radius: float) -> float:
    near = np.linalg.norm(design.x - np.array(point), axis=1) < radius
    return float(design.weights[near].sum())


@pytest.mark.parametrize("name", SMOOTH)
def test_support_and_weights_are_found(name: str, designs: dict[str, ContinuousDesign]) -> None:
    """The gap of 5e-6 in the criterion, which is flat at its optimum, allows points to lie off
    by its root, and weights to differ by about as much."""
    book, design = TEXTBOOK[name], designs[name]
    for point, weight in zip(book.points, book.weights, strict=True):
        assert weight_near(design, point, 0.02) == pytest.approx(weight, abs=3e-3)


@pytest.mark.parametrize("name", TEXTBOOK)
def test_value_and_bound_meet_at_the_optimum(
    name: str, designs: dict[str, ContinuousDesign]
) -> None:
    """For E the search optimises a mean of order -300: within 3^(1/300) = 0.4 % of it."""
    book, design = TEXTBOOK[name], designs[name]
    optimum = float(book.criterion.value(book.information()[None])[0])
    slack = 1e-5 if name in SMOOTH else 4e-3
    assert design.certificate.upper >= optimum * (1.0 - 1e-9)  # never false
    assert design.certificate.upper <= optimum * (1.0 + slack)
    assert float(book.criterion.value(design.total[None])[0]) >= optimum * (1.0 - slack)
    assert design.weights.sum() == pytest.approx(1.0)
    assert design.total == pytest.approx(
        np.einsum("i,ijk->jk", design.weights, design.informations)
    )


def test_e_optimal_weights_are_found_nearly(designs: dict[str, ContinuousDesign]) -> None:
    book, design = TEXTBOOK["quadratic, E"], designs["quadratic, E"]
    for point, weight in zip(book.points, book.weights, strict=True):
        assert weight_near(design, point, 0.05) == pytest.approx(weight, abs=0.02)


def test_g_and_d_optimum_are_the_same() -> None:
    """Kiefer & Wolfowitz (1960): the D-optimum minimises the largest prediction variance, which
    is then p. Here by the sensitivity of the D-optimal design, p times φ over φ."""
    book = TEXTBOOK["cubic, D"]
    rows = book.space.evaluate(np.linspace(-1, 1, 2001)[:, None]).blocks[:, 0]
    variance = np.einsum("ni,ij,nj->n", rows, np.linalg.inv(book.information()), rows)
    assert variance.max() == pytest.approx(4.0, abs=1e-9)


@pytest.mark.parametrize(
    ("name", "count", "expected"),
    [
        ("quadratic, D", 3, {-1.0: 1, 0.0: 1, 1.0: 1}),
        ("quadratic, D", 6, {-1.0: 2, 0.0: 2, 1.0: 2}),
        ("quadratic, A", 4, {-1.0: 1, 0.0: 2, 1.0: 1}),
        ("straight line, D", 10, {-1.0: 5, 1.0: 5}),
    ],
)
def test_exact_designs_where_the_weights_divide(
    name: str, count: int, expected: dict[float, int], designs: dict[str, ContinuousDesign]
) -> None:
    """Where weights times m are integers the exact optimum is the continuous one."""
    book = TEXTBOOK[name]
    found = exact_design(
        Goal(book.space, book.criterion, np.zeros((book.space.parameters,) * 2)),
        count,
        min(count, 5),
        np.random.default_rng(0),
        continuous=designs[name],
    )
    repeats = {point: 0 for point in expected}
    for x, n in zip(found.x[:, 0], found.counts, strict=True):
        repeats[min(expected, key=lambda point: abs(point - x))] += int(n)
        assert min(abs(point - x) for point in expected) < 5e-3
    assert repeats == expected
    optimum = float(book.criterion.value(book.information()[None])[0])
    assert found.value == pytest.approx(count * optimum, rel=1e-5)


def test_prior_information_moves_the_weights_to_what_is_missing() -> None:
    """With the end points known already, the D-optimal single experiment is at the middle."""
    space = polynomial(2)
    ends = space.evaluate(np.array([[-1.0], [1.0]])).blocks[:, 0]
    base = ends.T @ ends
    design = continuous_design(space, D, np.random.default_rng(0), base=base)
    assert weight_near(design, (0.0,), 0.02) == pytest.approx(1.0, abs=3e-3)
    assert design.certificate.upper == pytest.approx(
        float(D.value(design.total[None])[0]), rel=1e-5
    )


def test_same_seed_same_design() -> None:
    first, second = (
        continuous_design(polynomial(3), A, np.random.default_rng(7)) for _ in range(2)
    )
    assert np.array_equal(first.x, second.x)
    assert np.array_equal(first.weights, second.weights)
    assert first.certificate.upper == second.certificate.upper
