"""The parts of the search alone: how many steps they take, when they stop, what they tell."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.design import approximate, continuous
from elastocal.design.approximate import interior_point, optimal_weights
from elastocal.design.breeding import Breeder
from elastocal.design.continuous import ContinuousDesign, continuous_design
from elastocal.design.exact import Effort, exact_design
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.refinement import Goal, Plans, refine
from tests.design.polynomial import polynomial
from tests.design.test_oracle import CORNER, Polygon
from tests.design.test_textbook import SMOOTH, TEXTBOOK

D = MatrixMean(0.0, "D")


def goal(degree: int) -> Goal:
    return Goal(polynomial(degree), D, np.zeros((degree + 1, degree + 1)))


def counted(monkeypatch: pytest.MonkeyPatch, name: str, module: Any = approximate) -> list[int]:
    """One entry for every call of a function of a module."""
    calls: list[int] = []
    real = getattr(module, name)

    def spy(*args: Any, **options: Any) -> Any:
        calls.append(1)
        return real(*args, **options)

    monkeypatch.setattr(module, name, spy)
    return calls


@pytest.mark.parametrize("name", SMOOTH)
def test_the_interior_point_takes_few_steps(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The textbook's points among others: its weights, in at most 20 Newton steps."""
    book = TEXTBOOK[name]
    rng = np.random.default_rng(0)
    x = np.concatenate([np.array(book.points), book.space.sample(9, rng)])
    blocks = book.space.evaluate(x).blocks
    informations = np.einsum("nri,nrj->nij", blocks, blocks)
    base = np.zeros(informations.shape[1:])
    calls = counted(monkeypatch, "bends", type(book.criterion))
    weights = interior_point(book.criterion, informations, base, 1e-6)
    assert len(calls) <= 20
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(weights[: len(book.points)], book.weights, atol=1e-4)


def test_weights_on_many_points_are_found_in_few_sweeps(monkeypatch: pytest.MonkeyPatch) -> None:
    space = polynomial(3)
    blocks = space.evaluate(np.linspace(-1.0, 1.0, 2001)[:, None]).blocks
    informations = np.einsum("nri,nrj->nij", blocks, blocks)
    calls = counted(monkeypatch, "interior_point")
    found = optimal_weights(D, informations, np.zeros((4, 4)), tolerance=1e-6)
    assert len(calls) <= 12
    total = np.einsum("i,ijk->jk", found.weights, informations[found.support])
    rows = blocks[:, 0]
    # Kiefer & Wolfowitz: the largest prediction variance is p at the optimum.
    variance = np.einsum("ni,ij,nj->n", rows, np.linalg.inv(total), rows)
    assert variance.max() == pytest.approx(4.0, rel=2e-6)


def test_a_bound_is_sought_when_the_gap_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    """600 fresh starts cost more than all else: they are made once here, not every round."""
    calls = counted(monkeypatch, "dual_bound", continuous)
    found = continuous_design(polynomial(4), D, np.random.default_rng(0))
    assert found.gap < 1e-5
    assert len(calls) == 1


@pytest.mark.parametrize("seed", range(3))
def test_a_criterion_with_a_kink_is_bounded_where_the_search_ended(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It has two bounds, of its smooth stand-in and its own: both at the design that is returned.

    Its own was taken at an earlier design once, where the gradient is another: 9 % too high.
    """
    totals: list[Array] = []
    real = continuous.dual_bound

    def spy(space: Any, criterion: Any, total: Array, *rest: Any, **options: Any) -> Any:
        totals.append(total)
        return real(space, criterion, total, *rest, **options)

    monkeypatch.setattr(continuous, "dual_bound", spy)
    found = continuous_design(
        polynomial(3),
        MatrixMean(-np.inf).smooth,
        np.random.default_rng(seed),
        certified=MatrixMean(-np.inf),
    )
    assert len(totals) >= 2
    np.testing.assert_array_equal(totals[-1], found.total)
    np.testing.assert_array_equal(totals[-2], found.total)
    assert found.gap < 0.01


def test_the_gap_is_told_as_it_closes() -> None:
    told: list[tuple[str, float]] = []
    continuous_design(
        polynomial(4), D, np.random.default_rng(0), progress=lambda *what: told.append(what)
    )
    assert [what for what, _ in told][:1] == ["feasible load cases"]
    assert {what for what, _ in told[1:]} == {"continuous design", "trying the bound"}
    gaps = [gap for what, gap in told if what == "continuous design"]
    assert 0.0 < gaps[-1] < gaps[0]


def test_plans_of_the_same_value_count_as_one_if_asked() -> None:
    plans = Plans(np.zeros((4, 1, 1)), np.ones((4, 1), dtype=int), np.array([2.0, 3.0, 1.0, 3.0]))
    assert plans.best(3).value.tolist() == [3.0, 3.0, 2.0]
    assert plans.best(3, apart=1e-5).value.tolist() == [3.0, 2.0, 1.0]
    assert plans.best(3, apart=0.4).value.tolist() == [3.0, 1.0]
    both = plans.join(plans.take(np.array([2, 0])))
    assert both.value.tolist() == [2.0, 3.0, 1.0, 3.0, 1.0, 2.0]


def test_plans_are_valued_and_refined_by_hand() -> None:
    """Rows are the points: det of 2 x xᵀ + y yᵀ is 2 (x × y)², largest at opposite corners."""
    space = Polygon(CORNER)
    worth = Goal(space, D, np.zeros((2, 2)))
    x = np.array([[[0.3, 0.2], [-0.2, 0.1]], [[0.3, 0.2], [0.6, 0.1]]])
    counts = np.array([[2, 1], [2, 1]])
    found = worth.values(x, counts)
    cross = 0.3 * 0.1 + 0.2 * 0.2
    np.testing.assert_allclose(found, [np.sqrt(2.0 * cross**2), 0.0], atol=1e-15)
    low = np.array([[[0.3, -0.6], [-0.5, -0.6]]])
    refined = refine(worth, Plans(low, counts[:1]), stages=((200, 1),))
    assert refined.counts.tolist() == [[2, 1]]
    np.testing.assert_allclose(refined.x[0], [[0.5, -1.0], [-1.0, -1.0]], atol=1e-4)
    assert refined.value[0] == pytest.approx(np.sqrt(2.0) * 1.5, rel=1e-4)
    assert (space.evaluate(refined.x[0]).margins >= 0.0).all()


@pytest.fixture(scope="module")
def quadratic() -> ContinuousDesign:
    return continuous_design(polynomial(2), D, np.random.default_rng(0))


@pytest.mark.parametrize(("count", "most"), [(3, 2), (6, 2), (7, 11)])
def test_the_search_stops_where_nothing_is_left_to_gain(
    quadratic: ContinuousDesign, count: int, most: int
) -> None:
    """Weights of a third each: three and six experiments attain the bound, seven do not."""
    told: list[float] = []
    found = exact_design(
        goal(2), count, 3, np.random.default_rng(0), continuous=quadratic,
        effort=Effort(batch=32, islands=2), progress=lambda what, share: told.append(share),
    )  # fmt: skip
    assert found.counts.sum() == count
    attained = found.value / (count * quadratic.certificate.upper)
    if most == 2:
        assert len(told) == 2
        assert attained == pytest.approx(1.0, abs=1e-5)
    else:  # the bound stays out of reach: patience of four on each of two islands
        assert 10 <= len(told) < 2 * most + 2
        assert attained == pytest.approx(np.cbrt(3 * 2 * 2) / (7 / 3), abs=1e-5)


def test_how_far_independent_searches_agree_is_told(quadratic: ContinuousDesign) -> None:
    """Three short evolutions of seven experiments; one that meets the bound needs no other."""
    short = Effort(batch=8, generations=2, islands=3, stages=((3, 1.0),))
    rough = exact_design(goal(2), 7, 3, np.random.default_rng(1), effort=short)
    assert rough.searches == 3
    assert 0.0 < rough.apart < 0.1
    long = Effort(batch=32, islands=2)
    fine = exact_design(goal(2), 7, 3, np.random.default_rng(1), effort=long)
    assert fine.searches == 2
    assert 0.0 <= fine.apart < 1e-4
    once = exact_design(goal(2), 6, 3, np.random.default_rng(0), continuous=quadratic, effort=long)
    assert (once.searches, once.apart) == (1, 0.0)


def test_progress_never_falls_and_stays_below_one(quadratic: ContinuousDesign) -> None:
    told: list[float] = []
    values: list[float] = []

    def tell(share: float, value: float) -> None:
        told.append(share)
        values.append(value)

    found = exact_design(
        goal(2), 7, 3, np.random.default_rng(1), continuous=quadratic,
        effort=Effort(batch=8, generations=4, patience=9, islands=3), progress=tell,
    )  # fmt: skip
    assert all(a <= b for a, b in pairwise(values))
    assert values[-1] == pytest.approx(found.value, rel=1e-6)
    np.testing.assert_allclose(told, [k / 12 for k in range(12)])
    assert all(a <= b for a, b in pairwise(told))
    assert told[-1] <= 1.0


def test_plans_made_afresh_are_the_best_of_many(quadratic: ContinuousDesign) -> None:
    """Fifty random plans for each: nearly all better than nine of ten random ones."""
    space, base = polynomial(2), np.zeros((3, 3))
    goal = Goal(space, D, base)
    rng = np.random.default_rng(0)
    breeder = Breeder(goal, 4, 3, rng, quadratic)
    breeder.draw(space.sample(2000, rng))
    made = breeder.afresh(20)
    assert (made.counts.sum(axis=1) == 4).all()
    x = space.sample(3 * 500, np.random.default_rng(1)).reshape(500, 3, 1)
    usual = goal.values(x, np.tile([2, 1, 1], (500, 1)))
    fresh = goal.values(made.x, made.counts)
    assert np.mean(fresh > np.quantile(usual, 0.9)) > 0.9


def test_one_experiment_needs_no_repeats() -> None:
    """All points distinct and no continuous design: afresh, from random plans alone."""
    found = exact_design(
        goal(1), 2, 2, np.random.default_rng(0), effort=Effort(batch=16, generations=3)
    )
    assert sorted(found.x[:, 0].tolist()) == [pytest.approx(-1.0), pytest.approx(1.0)]
    assert found.counts.tolist() == [1, 1]
    assert found.value == pytest.approx(2.0)
