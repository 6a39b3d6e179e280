"""Tables of third derivatives: never too small, and not much too large."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations_with_replacement, permutations

import numpy as np
import pytest
from scipy.optimize import minimize

from elastocal.arrays import Array
from elastocal.proof.grids import Grids
from elastocal.proof.reference import margins, rows
from elastocal.proof.series import (
    FiniteSeries,
    chebyshev_terms,
    constraint_series,
    nodes,
    rows_series,
    turning_terms,
)
from elastocal.proof.statement import ChainJoints, Statement
from elastocal.proof.trigonometric import factor, points_for, third_derivatives
from tests.proof.statements import LOADS, chance

KINDS = ("ttst", "stt", "tts")


def anywhere(statement: Statement, rng: np.random.Generator, count: int) -> Array:
    """Points of the ranges of what slides and of whole turns of what turns."""
    low, high = statement.root
    x = low + (high - low) * rng.uniform(size=(count, len(low)))
    turned = x + rng.uniform(-np.pi, np.pi, x.shape)
    free = ~statement.joints.slides & (high > low)
    return np.where(free, turned, x)


def with_parallel_axes(statement: Statement) -> Statement:
    """The second joint parallel to the first, and the third against it; sum coordinates."""
    joints = statement.joints
    axis = joints.axis.copy()
    axis[1], axis[2] = axis[0], -axis[0]
    moved = ChainJoints(joints.names, joints.slides, axis, joints.point, joints.lower, joints.upper)
    springs = replace(
        statement.springs, axis=np.array([*statement.springs.axis[:1], *axis, axis[0]])
    )
    mix = np.eye(len(axis))
    mix[1, 0], mix[2, 1] = -1.0, 1.0
    return replace(statement, joints=moved, springs=springs, mix=mix)


@pytest.mark.parametrize("kinds", KINDS)
@pytest.mark.parametrize("load", LOADS)
def test_series_are_what_they_stand_for(kinds: str, load: str) -> None:
    rng = np.random.default_rng(0)
    made = chance(rng, kinds, load)
    x = anywhere(made, rng, 60)
    found = rows_series(made)
    np.testing.assert_allclose(found.at(x), rows(made, x).reshape(60, -1), atol=1e-12)
    assert found.dropped < 1e-12
    each = [one.at(x)[:, 0] for one in constraint_series(made)]
    np.testing.assert_allclose(np.array(each).T, margins(made, x), atol=1e-12)


def test_derivatives_of_series_by_differences() -> None:
    rng = np.random.default_rng(1)
    made, h = chance(rng, "tst", "free"), 1e-5
    series, x = rows_series(made), anywhere(made, rng, 20)
    for i, j, k in combinations_with_replacement(range(3), 3):
        lower, orders = [0, 0, 0], [0, 0, 0]
        for variable in (j, k):
            lower[variable] += 1
        for variable in (i, j, k):
            orders[variable] += 1
        step = h * np.eye(3)[series.variables[i]]
        slope = (series.at(x + step, lower) - series.at(x - step, lower)) / (2.0 * h)
        np.testing.assert_allclose(series.at(x, orders), slope, atol=1e-7)


def test_sum_coordinates_have_degree_two() -> None:
    """Without them a variable of parallel axes would have degree 4."""
    rng = np.random.default_rng(2)
    made = with_parallel_axes(chance(rng, "tttt"))
    assert rows_series(made).degrees == (2, 2, 2, 2)
    x = anywhere(made, rng, 20)
    np.testing.assert_allclose(rows_series(made).at(x), rows(made, x).reshape(20, -1), atol=1e-12)
    # Axes that are not parallel have all of it, and nothing is taken for rounding.
    mixed = replace(chance(rng, "tttt"), mix=made.mix)
    series = rows_series(mixed)
    assert sorted(series.degrees) == [2, 2, 4, 4]
    np.testing.assert_allclose(series.at(x), rows(mixed, x).reshape(20, -1), atol=1e-12)
    directions = [one.degrees for one in constraint_series(made)[:2]]
    assert directions == [(1, 1, 1, 1), (1, 1, 0, 0)]


def norm_of(statement: Statement, series: FiniteSeries, x: Array, orders: list[int]) -> Array:
    """(N,) norms of a derivative: of a free load the largest singular value over its columns."""
    found = series.at(x, orders)
    if statement.directions is None or found.shape[1] == 1:
        return np.linalg.norm(found, axis=1)
    columns = found.reshape(len(x), -1, statement.directions.shape[1])
    return np.linalg.norm(columns, 2, axis=(1, 2))


def highest(statement: Statement, series: FiniteSeries, orders: list[int], seed: int) -> float:
    """The largest norm that climbs find."""
    rng = np.random.default_rng(seed)
    x = anywhere(statement, rng, 250)
    x = np.concatenate([x, *(np.where(statement.joints.slides, end, x) for end in statement.root)])
    values = norm_of(statement, series, x, orders)
    best = float(values.max())
    free = [(None, None)] * x.shape[1]
    ends = [
        tuple(pair) if slides else one
        for pair, slides, one in zip(statement.root.T, statement.joints.slides, free, strict=True)
    ]
    for start in x[np.argsort(-values)[:2]]:
        done = minimize(
            lambda at: -norm_of(statement, series, at[None], orders)[0],
            start,
            bounds=ends,
            method="L-BFGS-B",
            options={"maxiter": 12},
        )
        best = max(best, -float(done.fun))
    return best


@pytest.mark.parametrize(
    ("kinds", "load"), [("tst", "steady"), ("stt", "free"), ("tt", "cone"), ("tts", "plane")]
)
def test_tables_are_above_all_that_climbs_find(kinds: str, load: str) -> None:
    made = chance(np.random.default_rng(3), kinds, load)
    n, k = len(kinds), 0 if made.directions is None else made.directions.shape[1]
    loose = third_derivatives(made, points=[8 if kind == "t" else 4 for kind in kinds])
    tight = third_derivatives(made, 0.2)
    tables = [loose.rows, tight.rows, *tight.constraints]
    series = rows_series(made)
    functions = [series, series, *constraint_series(made)]
    ratios: list[list[float]] = [[] for _ in tables]
    for triple in combinations_with_replacement(range(n), 3):
        for number, (table, function) in enumerate(zip(tables, functions, strict=True)):
            orders = [triple.count(i) for i in function.variables.tolist()]
            found = highest(made, function, orders, seed=number)
            assert {float(table[order]) for order in permutations(triple)} == {float(table[triple])}
            if table[triple] > 1e-6:
                ratios[number].append(found / float(table[triple]))
            else:
                assert found < 1e-6
    assert k in (0, 2, 3)
    for number, seen in enumerate(ratios):
        assert max(seen) <= 1.0
        assert min(seen) > (0.2 if number == 0 else 0.75)
    assert (loose.factor > tight.factor) or kinds == "tt"
    assert (loose.rows >= tight.rows * 0.98).all()


def test_the_factor_is_needed() -> None:
    """Without it the grid misses peaks: polynomials with their peak between grid points."""
    rng = np.random.default_rng(4)
    fine = np.linspace(0.0, 2.0 * np.pi, 721)
    missed = []
    for count in (5, 6, 8):
        for _ in range(300):
            shift = rng.uniform(0.0, 2.0 * np.pi)
            raw = rng.normal(size=5) if count > 5 else np.array([0.5, 2.0, 0, 1.0, 0])
            turned = turning_terms(nodes(5, False, 0, 0) - shift, 2) @ raw
            coefficients = np.linalg.solve(turning_terms(nodes(5, False, 0, 0), 2), turned)
            series = one_variable(coefficients[:, None], slides=False)
            grid = Grids(series, [count], 1).largest([0])
            peak = np.abs(turning_terms(fine, 2) @ coefficients).max()
            missed.append(grid / peak)
            assert grid * factor(series, 0, count) >= peak * (1.0 - 1e-12)
    assert min(missed) < 0.72


def one_variable(coefficients: Array, *, slides: bool) -> FiniteSeries:
    ends = (0.3, 1.7) if slides else (0.0, 0.0)
    low, high = np.array([[ends[0]], [ends[1]]])
    return FiniteSeries(np.array([0]), np.array([slides]), low, high, coefficients, 1.0, 0.0)


def test_the_sharpest_polynomial() -> None:
    """cos 2x shifted by half a step is on N points smaller by just the factor."""
    for count in (8, 16, 24):
        shift = np.pi / count
        coefficients = np.array([0.0, 0, 0, np.cos(2 * shift), np.sin(2 * shift)])
        series = one_variable(coefficients[:, None], slides=False)
        bound = Grids(series, [count], 1).largest([0]) * factor(series, 0, count)
        assert bound == pytest.approx(1.0)


def test_what_slides_by_chebyshev_points() -> None:
    rng = np.random.default_rng(5)
    fine = np.linspace(0.3, 1.7, 1001)
    seen = []
    for count in (3, 4, 7):
        for _ in range(60):
            raw = rng.normal(size=(3, 2))
            series = one_variable(raw, slides=True)
            for order in (0, 1, 2):
                values = chebyshev_terms(fine, 3, 0.3, 1.7, order) @ raw
                peak = np.linalg.norm(values, axis=1).max()
                grid = Grids(series, [count], 1).largest([order])
                seen.append(grid / peak)
                assert grid * factor(series, 0, count, order) >= peak * (1.0 - 1e-12)
    assert min(seen) < 0.9
    # At the end of the range there is no point.
    series = one_variable(np.array([[0.0], [1.0], [0.0]]), slides=True)
    assert Grids(series, [4], 1).largest([0]) == pytest.approx(np.cos(np.pi / 8.0))


def test_several_columns_by_their_operator_norm() -> None:
    """Of Grids with k columns the largest singular value at all points, by brute force."""
    rng = np.random.default_rng(6)
    for k in (2, 3):
        coefficients = rng.normal(size=(5, 3, 4 * k))
        series = FiniteSeries(
            np.arange(2), np.zeros(2, bool), np.zeros(2), np.zeros(2), coefficients, 1.0, 0.0
        )
        for counts in ([5, 4], [12, 9]):
            first, second = np.meshgrid(*(nodes(c, False, 0, 0) for c in counts), indexing="ij")
            x = np.stack([first.ravel(), second.ravel()], axis=1)
            for orders in ([0, 0], [2, 1]):
                values = series.at(x, orders).reshape(len(x), 4, k)
                brute = np.linalg.norm(values, 2, axis=(1, 2)).max()
                found = Grids(series, counts, k).largest(orders)
                assert brute * (1.0 - 1e-12) <= found < 1.02 * brute


def test_held_variables_have_no_third_derivatives() -> None:
    made = chance(np.random.default_rng(7), "ttst", "steady")
    root = made.root.copy()
    root[1, [0, 2]] = root[0, [0, 2]]
    held = replace(made, root=root)
    found, whole = third_derivatives(held, 0.1), third_derivatives(made, 0.1)
    assert not found.rows[0].any()
    assert not found.rows[:, 2].any()
    assert not found.constraints[:, 0].any()
    assert found.points.tolist()[0] == 0
    assert (found.rows <= whole.rows * 1.05).all()
    assert found.rows[1, 1, 3] > 0.0


def test_more_effort_is_tighter_and_costs_more_points() -> None:
    series = rows_series(chance(np.random.default_rng(8), "tttt"))
    counts = [points_for(series, effort) for effort in (1e-4, 0.01, 1.0)]
    assert counts[0] == [8, 8, 8, 8]
    assert np.prod(counts[0]) < np.prod(counts[1]) < np.prod(counts[2])
    assert all(np.ptp(each) <= 1 for each in counts)
