"""The certificate: accepts known optima, rejects perturbed designs, and is never false."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.design.dual_bound import DualBound, dual_bound
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.oracle import climb, restore, sensitivity
from elastocal.matrices import square_root
from tests.design.polynomial import polynomial
from tests.design.test_textbook import SMOOTH, TEXTBOOK, Textbook


def bound_at(book: Textbook, total: np.ndarray, base: np.ndarray | None = None) -> DualBound:
    p = book.space.parameters
    return dual_bound(
        book.space,
        book.criterion,
        total,
        np.zeros((p, p)) if base is None else base,
        np.array(book.points),
        np.random.default_rng(0),
    )


def value(book: Textbook, total: np.ndarray) -> float:
    return float(book.criterion.value(total[None])[0])


def perturbed(book: Textbook) -> np.ndarray:
    """The optimal points with a tenth of the weight moved from the first to the last."""
    rows = book.space.evaluate(np.array(book.points)).blocks
    weights = np.array(book.weights)
    weights[0] -= 0.1
    weights[-1] += 0.1
    return np.einsum("n,nri,nrj->ij", weights, rows, rows)


@pytest.mark.parametrize("name", SMOOTH)
def test_a_known_optimum_is_accepted(name: str) -> None:
    book = TEXTBOOK[name]
    total = book.information()
    assert value(book, total) / bound_at(book, total).upper >= 1.0 - 1e-6


@pytest.mark.parametrize("name", SMOOTH)
def test_a_perturbed_design_is_rejected_and_its_bound_still_holds(name: str) -> None:
    """Its own efficiency is at most that of the true optimum; the bound is above that optimum."""
    book = TEXTBOOK[name]
    total = perturbed(book)
    bound, optimum = bound_at(book, total), value(book, book.information())
    certified = value(book, total) / bound.upper
    assert certified < 0.95
    assert certified <= value(book, total) / optimum
    assert bound.upper >= optimum * (1.0 - 1e-12)


@pytest.mark.parametrize("name", TEXTBOOK)
def test_the_bound_holds_from_any_matrix_whatever(name: str) -> None:
    """Also from an information matrix that no design has; only its tightness suffers."""
    book, rng = TEXTBOOK[name], np.random.default_rng(1)
    optimum = value(book, book.information())
    for _ in range(10):
        rows = rng.normal(size=(8, book.space.parameters))
        assert bound_at(book, rows.T @ rows).upper >= optimum * (1.0 - 1e-9)


def test_the_bound_counts_what_is_known_already() -> None:
    """φ(B + M) ≤ tr(G B) + max s, with equality for the best single addition."""
    space, d = polynomial(2), MatrixMean(0.0)
    ends = space.evaluate(np.array([[-1.0], [1.0]])).blocks[:, 0]
    base = ends.T @ ends
    middle = space.evaluate(np.array([[0.0]])).blocks[0]
    total = base + middle.T @ middle
    bound = dual_bound(space, d, total, base, np.array([[0.0]]), np.random.default_rng(0))
    assert bound.offset == pytest.approx(float(np.sum(bound.gradient * base)))
    assert bound.upper == pytest.approx(float(d.value(total[None])[0]), rel=1e-6)


def test_what_the_bound_reports_of_its_search() -> None:
    book = TEXTBOOK["quadratic, D"]
    bound = bound_at(book, perturbed(book))
    assert bound.starts == 600
    assert 0 < bound.attained <= bound.starts
    assert len(bound.x_found) == len(bound.s_found)
    assert bound.largest == bound.s_found.max()
    at = book.space.evaluate(bound.x_largest[None]).blocks[0, 0]
    assert at @ bound.gradient @ at == pytest.approx(bound.largest, rel=1e-12)


def test_fresh_starts_alone_find_the_maximum() -> None:
    """Nothing known is needed: with no starts of ours the same bound comes out."""
    book = TEXTBOOK["cubic, D"]
    total, p = perturbed(book), book.space.parameters
    alone = dual_bound(
        book.space,
        book.criterion,
        total,
        np.zeros((p, p)),
        np.zeros((0, 1)),
        np.random.default_rng(5),
    )
    assert alone.upper == pytest.approx(bound_at(book, total).upper, rel=1e-9)


def test_climbs_end_in_local_maxima() -> None:
    """Of a polynomial of degree six on [-1, 1], against a fine grid."""
    book = TEXTBOOK["cubic, D"]
    gradient = book.criterion.gradient(perturbed(book)[None])[0]
    grid = np.linspace(-1.0, 1.0, 100001)[:, None]
    fine = sensitivity(book.space, grid, square_root(gradient))
    inside = np.flatnonzero((fine[1:-1] >= fine[:-2]) & (fine[1:-1] >= fine[2:])) + 1
    tops = np.concatenate([grid[inside, 0], [-1.0, 1.0]])
    starts = book.space.sample(50, np.random.default_rng(2))
    x, s, _ = climb(book.space, starts, gradient, ((150, len(starts)),))
    assert s.max() == pytest.approx(fine.max(), rel=1e-9)
    assert np.abs(x - tops).min(axis=1).max() < 1e-3


def test_square_root_keeps_the_matrix() -> None:
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(2, 4))
    singular = rows.T @ rows
    root = square_root(singular)
    assert root.shape == (4, 2)
    assert root @ root.T == pytest.approx(singular, abs=1e-12)


def test_points_without_constraints_are_only_clipped() -> None:
    x = np.array([[-3.0], [0.2], [7.0]])
    assert restore(polynomial(1), x) == pytest.approx(np.array([[-1.0], [0.2], [1.0]]))
