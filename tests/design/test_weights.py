"""Best weights on a finite set: against cvxpy with Clarabel, and against closed forms."""

from __future__ import annotations

from typing import Any

import cvxpy as cp
import numpy as np
import pytest

from elastocal.design import approximate
from elastocal.design.approximate import (
    few_points,
    interior_point,
    nearly_best,
    optimal_weights,
)
from elastocal.design.criterion import InformationFunction
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.test_pose import TestPosePrecision
from tests.design.worst import Worst

P = 4
# The equivalence theorem is asked to hold to 1e-7 on the points, so the value is good to 1e-7;
# Clarabel's own gap is about 1e-8. Both values are compared, not the weights: those of an
# optimum need not be unique.
TOLERANCE = 1e-7
AGREEMENT = 1e-6


def blocks(seed: int, count: int = 60) -> np.ndarray:
    """(count, 3, P) rows, of columns that differ in size as compliances do."""
    return np.random.default_rng(seed).normal(size=(count, 3, P)) * np.array([1.0, 0.3, 3.0, 1.5])


def informations(seed: int, count: int = 60) -> np.ndarray:
    rows = blocks(seed, count)
    return np.asarray(rows.transpose(0, 2, 1) @ rows)


def task_rows(seed: int, rows: int = P) -> np.ndarray:
    """Rows of a test pose."""
    return np.random.default_rng(100 + seed).normal(size=(rows, P))


def reference(kind: str, matrices: np.ndarray, base: np.ndarray, seed: int) -> float:
    """The optimum by a general convex solver, as a value of our criterion."""
    weights = cp.Variable(len(matrices), nonneg=True)
    flat = matrices.reshape(len(matrices), -1)
    total = cp.reshape(weights @ flat, (P, P), order="C") + base
    loss = {
        "A": lambda: sum(cp.matrix_frac(row, total) for row in np.eye(P)) / P,
        "test-pose": lambda: sum(cp.matrix_frac(row, total) for row in task_rows(seed)),
        "one coordinate": lambda: cp.matrix_frac(task_rows(seed, 1)[0], total),
        "G": lambda: cp.max(cp.hstack([cp.matrix_frac(row, total) for row in task_rows(seed)])),
    }
    goal = {"D": lambda: cp.log_det(total), "E": lambda: cp.lambda_min(total)}
    objective = cp.Minimize(loss[kind]()) if kind in loss else cp.Maximize(goal[kind]())
    value = cp.Problem(objective, [cp.sum(weights) == 1.0]).solve(solver=cp.CLARABEL)
    if kind in loss:
        return float(1.0 / value)
    return float(np.exp(value / P)) if kind == "D" else float(value)


def criterion(kind: str, seed: int) -> InformationFunction:
    rows = task_rows(seed)
    return {
        "A": lambda: MatrixMean(-1.0),
        "D": lambda: MatrixMean(0.0),
        "E": lambda: MatrixMean(-np.inf),
        "test-pose": lambda: TestPosePrecision(rows.T @ rows),
        "one coordinate": lambda: TestPosePrecision(np.outer(*[task_rows(seed, 1)[0]] * 2)),
        "G": lambda: Worst([TestPosePrecision(np.outer(row, row)) for row in rows]),
    }[kind]()


def value(f: InformationFunction, matrices: np.ndarray, base: np.ndarray) -> float:
    design = optimal_weights(f, matrices, base, tolerance=TOLERANCE)
    assert design.weights.sum() == pytest.approx(1.0)
    assert (design.weights > 0.0).all()
    assert len(set(design.support)) == len(design.support)
    total = base + np.einsum("i,ijk->jk", design.weights, matrices[design.support])
    return float(f.value(total[None])[0])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["A", "D", "test-pose"])
def test_smooth_criteria_against_a_general_convex_solver(kind: str, seed: int) -> None:
    matrices, base = informations(seed), np.zeros((P, P))
    found = value(criterion(kind, seed), matrices, base)
    assert found == pytest.approx(reference(kind, matrices, base, seed), rel=AGREEMENT)


def test_a_single_coordinate_against_a_general_convex_solver() -> None:
    """c-optimality, whose best design does not identify every unknown: M is singular there."""
    matrices, base = informations(2), np.zeros((P, P))
    best = reference("one coordinate", matrices, base, 2)
    found = value(criterion("one coordinate", 2), matrices, base)
    assert best * (1.0 - 1e-4) <= found <= best * (1.0 + AGREEMENT)


@pytest.mark.parametrize("kind", ["A", "D", "E", "test-pose"])
def test_prior_information_against_a_general_convex_solver(kind: str) -> None:
    matrices, base = informations(0), 0.3 * informations(9, 4).sum(axis=0)
    found = value(criterion(kind, 0), matrices, base)
    assert found == pytest.approx(
        reference(kind, matrices, base, 0), rel=1e-2 if kind == "E" else AGREEMENT
    )


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", ["E", "G"])
def test_kinked_criteria_against_a_general_convex_solver(kind: str, seed: int) -> None:
    """Their smooth stand-in is a mean of order -300 of p values: p^(1/300) = 0.5 % of it may be
    lost, and nothing may be gained."""
    matrices, base = informations(seed), np.zeros((P, P))
    best = reference(kind, matrices, base, seed)
    found = value(criterion(kind, seed), matrices, base)
    assert best * (1.0 - 5e-3) <= found <= best * (1.0 + AGREEMENT)


def test_the_multiplier_of_a_general_convex_solver_agrees_on_optimality() -> None:
    """Equivalence theorem on the points: no sensitivity above the mean, equal on the support."""
    matrices, f = informations(4), criterion("test-pose", 4)
    design = optimal_weights(f, matrices, np.zeros((P, P)), tolerance=TOLERANCE)
    total = np.einsum("i,ijk->jk", design.weights, matrices[design.support])
    sensitivity = np.einsum("ijk,jk->i", matrices, f.gradient(total[None])[0])
    level = float(f.value(total[None])[0])
    assert sensitivity.max() <= level * (1.0 + 2.0 * TOLERANCE)
    heavy = design.support[design.weights > 1e-3]
    assert sensitivity[heavy] == pytest.approx(np.full(len(heavy), level), rel=1e-4)


SIZES = np.array([1.0, 4.0, 9.0, 25.0])


@pytest.mark.parametrize(
    ("f", "expected"),
    [
        (MatrixMean(0.0), np.full(P, 1 / P)),
        (MatrixMean(-1.0), SIZES**-0.5 / (SIZES**-0.5).sum()),
        (MatrixMean(-0.5), SIZES ** (-1 / 3) / (SIZES ** (-1 / 3)).sum()),
        (
            TestPosePrecision(np.diag([4.0, 1.0, 1.0, 1.0])),
            (w := np.sqrt(np.array([4.0, 1.0, 1.0, 1.0]) / SIZES)) / w.sum(),
        ),
        (MatrixMean(-np.inf), SIZES**-1.0 / (SIZES**-1.0).sum()),
    ],
    ids=["D", "A", "O5", "test-pose", "E"],
)
def test_independent_unknowns_have_weights_in_closed_form(
    f: InformationFunction, expected: np.ndarray
) -> None:
    """Points that see one unknown each with information s_i: weights go as s_i^(q/(1-q)), by the
    Lagrange condition; for D they are equal, for A they go as 1/√s, for E as 1/s.

    E is replaced by a mean of order -300, which moves its weights by about 1 in 300.
    """
    matrices = SIZES[:, None, None] * np.eye(P)[:, :, None] * np.eye(P)[:, None, :]
    design = optimal_weights(f, matrices, np.zeros((P, P)), tolerance=1e-8)
    weights = np.zeros(P)
    weights[design.support] = design.weights
    assert weights == pytest.approx(expected, rel=2e-2 if f.smooth is not f else 1e-4)


def test_useless_points_get_no_weight() -> None:
    """Points that repeat a tenth of others."""
    matrices = informations(5, 20)
    both = np.concatenate([0.1 * matrices, matrices])
    design = optimal_weights(criterion("A", 5), both, np.zeros((P, P)), tolerance=TOLERANCE)
    assert design.support.min() >= 20


def test_the_points_to_begin_with_do_not_matter() -> None:
    matrices, f = informations(6), criterion("test-pose", 6)
    totals = []
    for start in (None, np.arange(60), np.array([3, 14, 15, 9, 26])):
        design = optimal_weights(f, matrices, np.zeros((P, P)), start=start, tolerance=TOLERANCE)
        totals.append(np.einsum("i,ijk->jk", design.weights, matrices[design.support]))
    values = f.value(np.array(totals))
    assert values == pytest.approx(np.full(3, values[0]), rel=AGREEMENT)


def test_a_single_point_gets_all_the_weight() -> None:
    design = optimal_weights(criterion("A", 0), informations(0, 1) + np.eye(P), np.zeros((P, P)))
    assert design.support.tolist() == [0]
    assert design.weights == pytest.approx([1.0])


def test_interior_point_weights_are_a_design() -> None:
    weights = interior_point(criterion("D", 1), informations(1, 12), np.zeros((P, P)), 1e-6)
    assert weights.sum() == pytest.approx(1.0)
    assert (weights > 0.0).all()


@pytest.mark.parametrize("order", [-np.inf, -1.0, 0.0])
def test_points_that_identify_too_little_get_equal_weights(order: float) -> None:
    """Three unknowns, two seen, one of them faintly: no exception, no warning, no preference."""
    rows = np.array([[1.0, 0.0, 0.0], [1.0, 1e-12, 0.0], [2.0, 0.0, 0.0]])
    informations = rows[:, :, None] * rows[:, None, :]
    criterion = MatrixMean(order).smooth
    weights = interior_point(criterion, informations, np.zeros((3, 3)), 1e-3)
    assert weights == pytest.approx(np.full(3, 1.0 / 3.0))


def test_nothing_is_lost_and_taken_back_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many points around each of few tops, so that many weights are as small as what may be lost.

    A sweep takes up points; a fault made sixty sweeps of it, and the last one was returned.
    """
    rows = blocks(11, 12)
    rows = np.repeat(rows, 60, axis=0)
    rows = rows * (1.0 + 1e-8 * np.random.default_rng(1).normal(size=rows.shape))
    matrices = np.asarray(rows.transpose(0, 2, 1) @ rows)
    sweeps = []
    real = approximate.interior_point

    def spy(*args: Any) -> np.ndarray:
        sweeps.append(len(args[1]))
        return real(*args)

    monkeypatch.setattr(approximate, "interior_point", spy)
    f = criterion("test-pose", 11)
    for tolerance in (1e-5, 5e-7):
        sweeps.clear()
        design = optimal_weights(f, matrices, np.zeros((P, P)), tolerance=tolerance)
        assert len(sweeps) < 12
        total = np.einsum("i,ijk->jk", design.weights, matrices[design.support])
        sensitivity = np.einsum("ijk,jk->i", matrices, f.gradient(total[None])[0])
        assert sensitivity.max() <= f.value(total[None])[0] * (1.0 + 2.0 * tolerance)


def test_where_sweeps_end_early_the_best_is_returned(monkeypatch: pytest.MonkeyPatch) -> None:
    matrices, f, base = informations(6, 400), criterion("test-pose", 6), np.zeros((P, P))
    excess = []
    for sweeps in (1, 2, 3, 60):
        monkeypatch.setattr(approximate, "_SWEEPS", sweeps)
        design = optimal_weights(f, matrices, base, start=np.arange(8), tolerance=TOLERANCE)
        total = np.einsum("i,ijk->jk", design.weights, matrices[design.support])
        sensitivity = np.einsum("ijk,jk->i", matrices, f.gradient(total[None])[0])
        excess.append(float(sensitivity.max() / f.value(total[None])[0] - 1.0))
    assert excess == sorted(excess, reverse=True)
    assert excess[-1] < 2.0 * TOLERANCE


@pytest.mark.parametrize(("p", "count"), [(1, 9), (3, 40), (6, 150)])
def test_few_points_give_the_same_information(p: int, count: int) -> None:
    rng = np.random.default_rng(p)
    rows = rng.normal(size=(count, 2, p)) * 10.0 ** rng.uniform(-3, 3, p)
    matrices = rows.transpose(0, 2, 1) @ rows
    weights = rng.dirichlet(np.full(count, 0.3)) + 1e-12
    weights /= weights.sum()
    found = few_points(matrices, weights)
    assert len(found.support) <= p * (p + 1) // 2 + 1
    assert (found.weights > 0.0).all()
    assert found.weights.sum() == pytest.approx(1.0, abs=1e-12)
    total = np.einsum("i,ijk->jk", weights, matrices)
    size = np.sqrt(np.diagonal(total))
    again = np.einsum("i,ijk->jk", found.weights, matrices[found.support])
    np.testing.assert_allclose(
        again / np.outer(size, size), total / np.outer(size, size), atol=1e-9
    )


def test_few_points_are_left_as_they_are() -> None:
    found = few_points(informations(0, 7), np.full(7, 1.0 / 7.0))
    assert found.support.tolist() == list(range(7))
    assert found.weights == pytest.approx(np.full(7, 1.0 / 7.0), rel=1e-14)


@pytest.mark.parametrize("kind", ["A", "D", "test-pose", "G"])
def test_weights_that_are_to_be_rounded_are_nearly_the_best(kind: str) -> None:
    """Of many sets at once; a set that identifies too little keeps equal weights.

    At a kink the steps go to and fro: less is asked there."""
    matrices, base = informations(3, 40), np.zeros((P, P))
    f, rng = criterion(kind, 3), np.random.default_rng(0)
    parts = np.array([rng.choice(40, 5, replace=False) for _ in range(8)])
    found = nearly_best(f, matrices, parts, base)
    assert found.sum(axis=1) == pytest.approx(np.ones(8))
    for part, weights in zip(parts, found, strict=True):
        best = interior_point(f.smooth, matrices[part], base, 1e-6)
        totals = np.einsum("ti,ijk->tjk", np.array([weights, best]), matrices[part])
        reached, most = f.value(totals)
        assert reached >= (0.98 if kind != "G" else 0.85) * most
    blind = np.zeros((3, P, P))
    blind[:, 0, 0] = 1.0
    alone = nearly_best(f, blind, np.array([[0, 1, 2]]), base)
    assert alone == pytest.approx(np.full((1, 3), 1.0 / 3.0))
