"""Searches that are stopped: what is known so far is polished, and nothing is made of nothing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.design.continuous import continuous_design
from elastocal.design.criterion import Criterion
from elastocal.design.exact import Effort, exact_design, first_plans
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.refinement import Goal, Plans
from elastocal.stopping import Stopped, stop_if_asked, stoppable
from tests.design.polynomial import polynomial

D = MatrixMean(0.0, "D")
GOAL = Goal(polynomial(2), D, np.zeros((3, 3)))
EFFORT = Effort(batch=16, generations=4, patience=9)


def after(asked: int) -> Callable[[], bool]:
    """True from that question on."""
    left = iter(range(asked))
    return lambda: next(left, None) is None


def first() -> Plans:
    rng = np.random.default_rng(0)
    found = first_plans(GOAL, 7, 3, GOAL.space.sample(100, rng), rng)
    assert found is not None
    return found


def test_only_what_is_stoppable_is_stopped() -> None:
    stop_if_asked()
    with stoppable(after(1)):
        stop_if_asked()
        with stoppable(None):
            stop_if_asked()
        with pytest.raises(Stopped):
            stop_if_asked()
    stop_if_asked()


def test_the_first_plans_are_feasible_and_in_order() -> None:
    found = first()
    assert (np.diff(found.value) <= 0.0).all()
    assert found.value[-1] > 0.0
    np.testing.assert_allclose(found.value, GOAL.values(found.x, found.counts))
    assert (found.counts.sum(axis=1) == 7).all()


class Nothing(Criterion):
    """By which no plan is worth anything, as where none is feasible."""

    def value(self, information: Array) -> Array:
        return np.zeros(len(information))

    def gradient(self, information: Array) -> Array:
        return np.zeros_like(information)


def test_there_may_be_no_first_plan() -> None:
    rng = np.random.default_rng(0)
    goal = replace(GOAL, criterion=Nothing())
    assert first_plans(goal, 7, 3, GOAL.space.sample(100, rng), rng) is None


def test_stopped_at_once_the_plans_known_are_polished() -> None:
    known = first()
    found = exact_design(GOAL, 7, 3, np.random.default_rng(1), known=known, stop=lambda: True)
    assert found.stopped
    assert (found.generations, found.searches, found.apart) == (0, 1, 0.0)
    assert found.value >= known.value[0]
    assert found.counts.sum() == 7


@pytest.mark.parametrize("asked", [1, 5, 20, 40])
def test_it_is_never_better_than_the_whole_search(asked: int) -> None:
    told: list[float] = []
    found, whole = (
        exact_design(
            GOAL, 7, 3, np.random.default_rng(1), known=first(), effort=EFFORT, stop=stop,
            progress=lambda share, value: told.append(value),
        )
        for stop in (after(asked), None)
    )  # fmt: skip
    assert (found.stopped, whole.stopped) == (True, False)
    assert found.generations < whole.generations
    assert first().value[0] <= found.value <= whole.value * (1.0 + 1e-9)


def test_without_a_plan_nobody_is_asked() -> None:
    """From nothing: the first generation is made whole, whoever wants it to stop."""
    asked: list[int] = []

    def stop() -> bool:
        asked.append(len(told))
        return True

    told: list[float] = []
    found = exact_design(
        GOAL, 7, 3, np.random.default_rng(1), stop=stop,
        progress=lambda share, value: told.append(value),
    )  # fmt: skip
    assert asked == [1]
    assert (found.stopped, found.generations) == (True, 1)


def test_plans_known_join_the_first_evolution() -> None:
    """The best plan, handed over to a search that finds next to nothing, is kept."""
    best = exact_design(GOAL, 7, 3, np.random.default_rng(1), effort=Effort(batch=32))
    known = Plans(best.x[None], best.counts[None])
    blind = Effort(batch=4, generations=1, islands=1, stages=((1, 1.0),))
    found = exact_design(GOAL, 7, 3, np.random.default_rng(2), known=known, effort=blind)
    assert found.value >= best.value * (1.0 - 1e-12)


def test_a_continuous_design_that_is_stopped_is_none() -> None:
    with pytest.raises(Stopped), stoppable(after(3)):
        continuous_design(polynomial(4), D, np.random.default_rng(0))
