"""The batched optimiser on textbook problems whose solutions are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from elastocal.design.lockstep import Minimum, Problem, Trial, minimise

Objective = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""x (B, D) -> values (B,), gradients (B, D)."""
Constraints = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
"""x (B, D) -> margins (B, C), gradients (B, C, D)."""


def unconstrained(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((len(x), 0)), np.zeros((len(x), 0, x.shape[1]))


def problem(objective: Objective, constraints: Constraints = unconstrained) -> Problem:
    def step(x: np.ndarray, _: np.ndarray) -> Trial:
        value, gradient = objective(x)
        margins, slopes = constraints(x)
        return Trial(value, margins, lambda w: gradient - np.einsum("bc,bcd->bd", w, slopes))

    return step


def rosenbrock(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Over 100, so that 1 is a large change, as the optimiser asks for."""
    a, b = 1.0 - x[:, 0], x[:, 1] - x[:, 0] ** 2
    gradient = np.stack([-2.0 * a - 400.0 * x[:, 0] * b, 200.0 * b], axis=1)
    return (a**2 + 100.0 * b**2) / 100.0, gradient / 100.0


def unit_disc(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 1.0 - (x**2).sum(axis=1, keepdims=True), -2.0 * x[:, None, :]


def quadratic(hessian: np.ndarray, slope: np.ndarray) -> Objective:
    return lambda x: (
        0.5 * np.einsum("bi,ij,bj->b", x, hessian, x) + x @ slope,
        x @ hessian + slope,
    )


def linear(matrix: np.ndarray, right: np.ndarray) -> Constraints:
    """matrix x <= right."""
    return lambda x: (right - x @ matrix.T, np.tile(-matrix, (len(x), 1, 1)))


@dataclass(frozen=True)
class Textbook:
    """A problem with a known solution."""

    problem: Problem
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    solution: tuple[float, ...]


BIG = 5.0
TEXTBOOK = {
    # Rosenbrock (1960): the valley ends at (1, 1).
    "Rosenbrock": Textbook(problem(rosenbrock), (-BIG,) * 2, (BIG,) * 2, (1.0, 1.0)),
    # With the bound x1 <= 1/2 active the valley is followed to its end at the wall.
    "Rosenbrock behind a bound": Textbook(
        problem(rosenbrock), (-BIG,) * 2, (0.5, BIG), (0.5, 0.25)
    ),
    # On the unit disc; the solution by one-dimensional search along the circle.
    "Rosenbrock on a disc": Textbook(
        problem(rosenbrock, unit_disc), (-BIG,) * 2, (BIG,) * 2, (0.786415154, 0.617698316)
    ),
    # Hock & Schittkowski (1981) 35, with x >= 0 and one constraint active.
    "HS35": Textbook(
        problem(
            quadratic(np.array([[4.0, 2, 2], [2, 4, 0], [2, 0, 2]]), np.array([-8.0, -6.0, -4.0])),
            linear(np.array([[1.0, 1.0, 2.0]]), np.array([3.0])),
        ),
        (0.0,) * 3,
        (BIG,) * 3,
        (4 / 3, 7 / 9, 4 / 9),
    ),
    # Hock & Schittkowski (1981) 76: three constraints, two active, and a bound.
    "HS76": Textbook(
        problem(
            quadratic(
                np.array([[2.0, 0, -1, 0], [0, 1, 0, 0], [-1, 0, 2, 1], [0, 0, 1, 1]]),
                np.array([-1.0, -3.0, 1.0, -1.0]),
            ),
            linear(
                np.array([[1.0, 2, 1, 1], [3, 1, 2, -1], [0, -1, -4, 0]]),
                np.array([5.0, 4.0, -1.5]),
            ),
        ),
        (0.0,) * 4,
        (BIG,) * 4,
        (3 / 11, 23 / 11, 0.0, 6 / 11),
    ),
    # Distance to a point outside a box: the nearest corner, edge or face.
    "projection on a box": Textbook(
        problem(quadratic(np.eye(3), -np.array([2.0, 0.3, -7.0]))),
        (-1.0,) * 3,
        (1.0,) * 3,
        (1.0, 0.3, -1.0),
    ),
    # Distance to a point behind a plane.
    "projection on a half-space": Textbook(
        problem(
            quadratic(np.eye(2), -np.array([2.0, 2.0])),
            linear(np.array([[3.0, 4.0]]), np.array([4.0])),
        ),
        (-BIG,) * 2,
        (BIG,) * 2,
        (2 - 0.4 * 3, 2 - 0.4 * 4),
    ),
}


def solve(book: Textbook, starts: np.ndarray, evaluations: int) -> Minimum:
    """All starts in one batch, none given up, all with the same first penalty."""
    lower, upper = np.array(book.lower), np.array(book.upper)
    stages = ((evaluations, len(starts)),)
    return minimise(book.problem, starts, lower, upper, stages=stages, penalties=(10.0,))


@pytest.mark.parametrize("name", TEXTBOOK)
def test_known_solutions_from_many_starts_at_once(name: str) -> None:
    """Multipliers move every ten evaluations and halve the error at least: 400 give 1e-12, and
    leave room for the starts far away."""
    book = TEXTBOOK[name]
    starts = np.random.default_rng(0).uniform(book.lower, book.upper, (20, len(book.lower)))
    found = solve(book, starts, 400)
    assert np.abs(found.x - book.solution).max() < 1e-6
    assert found.violation.max() < 1e-6
    best = book.problem(np.array([book.solution]), np.zeros(1, dtype=np.int64)).value
    assert found.value == pytest.approx(np.full(20, best[0]), abs=1e-6)


def test_starts_outside_the_bounds_are_brought_inside() -> None:
    book = TEXTBOOK["projection on a box"]
    found = solve(book, np.full((3, 3), 50.0), 30)
    assert found.x == pytest.approx(np.tile(book.solution, (3, 1)), abs=1e-9)


@pytest.mark.parametrize("name", TEXTBOOK)
def test_a_start_at_the_solution_comes_back_to_it(name: str) -> None:
    """It leaves at first: the multipliers begin at zero and do not hold it there yet."""
    book = TEXTBOOK[name]
    start = np.array([book.solution])
    assert solve(book, start, 400).x == pytest.approx(start, abs=1e-6)


def test_problems_of_a_batch_do_not_touch_each_other() -> None:
    """Each follows the path it would follow alone, to the last bit it can be told by."""
    book = TEXTBOOK["Rosenbrock on a disc"]
    starts = np.random.default_rng(1).uniform(-2.0, 2.0, (7, 2))
    together = solve(book, starts, 45)
    for i in range(7):
        alone = solve(book, starts[i : i + 1], 45)
        assert alone.x[0] == pytest.approx(together.x[i], abs=1e-9)


def squares(targets: np.ndarray, asked: list[int]) -> Problem:
    """Squared distance of each problem to its own target; notes how many were asked for."""

    def step(x: np.ndarray, which: np.ndarray) -> Trial:
        asked.append(len(which))
        difference = x - targets[which]
        return Trial((difference**2).sum(axis=1), np.zeros((len(x), 0)), lambda w: 2.0 * difference)

    return step


def test_resting_problems_leave_the_batch_and_keep_their_results() -> None:
    """Different objectives in one batch, told apart by the index they are asked with."""
    targets = np.array([[0.1, 0.2], [3.0, -2.0], [0.0, 0.9]])
    starts = targets + np.array([[0.0, 0.0], [2.0, 1.0], [0.0, 0.0]])
    asked: list[int] = []
    found = minimise(
        squares(targets, asked),
        starts,
        np.full(2, -9.0),
        np.full(2, 9.0),
        stages=((60, 3),),
        tolerance=1e-12,
    )
    assert found.x == pytest.approx(targets, abs=1e-6)
    assert found.origin.tolist() == [0, 1, 2]
    assert asked[-1] < asked[0]


def test_a_stage_keeps_the_best_problems_and_says_which() -> None:
    """Offsets make some problems better than others, wherever they are started."""
    offset = np.array([5.0, 0.0, 3.0, 1.0, 4.0])

    def step(x: np.ndarray, which: np.ndarray) -> Trial:
        value = (x**2).sum(axis=1) + offset[which]
        return Trial(value, np.zeros((len(x), 0)), lambda w: 2.0 * x)

    starts = np.random.default_rng(2).uniform(-1.0, 1.0, (5, 2))
    lower, upper = np.full(2, -9.0), np.full(2, 9.0)
    found = minimise(step, starts, lower, upper, stages=((15, 3), (15, 2)))
    assert found.origin.tolist() == [1, 3]
    assert found.value == pytest.approx([0.0, 1.0], abs=1e-9)
    assert found.x == pytest.approx(np.zeros((2, 2)), abs=1e-6)


def test_what_rests_at_once_does_not_keep_better_ones_out() -> None:
    """Three of five start where all is flat and bad; the others have a way to go."""

    def step(x: np.ndarray, _: np.ndarray) -> Trial:
        flat = x[:, 0] > 5.0
        value = np.where(flat, 40.0, (x[:, 0] ** 2 - 1.0) ** 2)
        slope = np.where(flat, 0.0, 4.0 * x[:, 0] * (x[:, 0] ** 2 - 1.0))[:, None]
        return Trial(value, np.zeros((len(x), 0)), lambda w: slope)

    starts = np.array([[6.0], [7.0], [4.0], [8.0], [3.0]])
    stages = ((10, 2), (60, 2))
    found = minimise(step, starts, np.array([-9.0]), np.array([9.0]), stages=stages, tolerance=1e-9)
    moved = found.x[np.isin(found.origin, [2, 4]), 0]
    assert np.abs(moved) == pytest.approx([1.0, 1.0], abs=1e-4)


def test_no_evaluations_return_the_starts() -> None:
    book = TEXTBOOK["HS35"]
    found = solve(book, np.array([[0.5, 0.5, 0.5], [9.0, 0.0, 0.0]]), 0)
    assert found.x == pytest.approx(np.array([[0.5, 0.5, 0.5], [BIG, 0.0, 0.0]]))
    assert found.violation == pytest.approx([0.0, 2.0])


def test_infinite_values_shorten_the_step_and_nothing_else() -> None:
    """A criterion of a singular plan is worth -log 0: the line search has to walk around it."""

    def step(x: np.ndarray, _: np.ndarray) -> Trial:
        with np.errstate(divide="ignore", invalid="ignore"):
            value = np.where(x[:, 0] > 0.0, x[:, 0] - np.log(np.maximum(x[:, 0], 0.0)), np.inf)
            slope = np.where(x > 0.0, 1.0 - 1.0 / np.where(x > 0.0, x, 1.0), 0.0)
        return Trial(value, np.zeros((len(x), 0)), lambda w: slope)

    starts = np.array([[4.0], [0.05], [0.9]])
    found = minimise(step, starts, np.array([-5.0]), np.array([5.0]), stages=((80, 3),))
    assert found.x[:, 0] == pytest.approx([1.0, 1.0, 1.0], abs=1e-6)
