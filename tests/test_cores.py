"""Work dealt out to several processes: the same results in the same order, and clear refusals."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable

import numpy as np
import pytest

from elastocal.constraints.cell import CollisionRules, clearances
from elastocal.cores import dealt, several_cores, usable_cores
from elastocal.design.lockstep import Minimum, Trial, minimise
from elastocal.design.oracle import climb
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.errors import InputError
from elastocal.robot.chain import transform
from elastocal.robot.shapes import Shape
from elastocal.study.experiment_space import LoadCaseSpace
from tests.kr270 import kr270_study


def square(number: float) -> tuple[float, int]:
    return number**2, os.getpid()


def refuse(number: float) -> float:
    raise InputError(f"no root of {number}")


def test_results_come_in_order_from_other_processes() -> None:
    numbers = [float(n) for n in range(20)]
    here = list(dealt(square, numbers))
    with several_cores(2):
        there = list(dealt(square, numbers))
    assert [value for value, _ in here] == [value for value, _ in there]
    assert {process for _, process in here} == {os.getpid()}
    assert os.getpid() not in {process for _, process in there}


def test_outside_there_is_one_process_again() -> None:
    with several_cores(2), several_cores(1):
        assert {process for _, process in dealt(square, [1.0, 2.0])} == {os.getpid()}
    assert {process for _, process in dealt(square, [1.0, 2.0])} == {os.getpid()}


@pytest.mark.parametrize("workers", [1, 2])
def test_what_is_refused_there_is_refused_here(workers: int) -> None:
    with several_cores(workers), pytest.raises(InputError, match=r"no root of 3\.0"):
        list(dealt(refuse, [3.0, 3.0]))
    with several_cores(workers):  # and the next work is done
        assert len(list(dealt(square, [1.0, 2.0]))) == 2


def test_without_joblib_there_is_one_core(monkeypatch: pytest.MonkeyPatch) -> None:
    assert usable_cores() >= 1
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert usable_cores() == 1
    with several_cores(1):
        assert len(list(dealt(square, [1.0, 2.0]))) == 2
    with pytest.raises(InputError, match=r"needs joblib: install elastocal\[parallel\]"):
        several_cores(2).__enter__()


def test_no_worker_is_refused() -> None:
    with pytest.raises(InputError, match="workers must be at least 1, found 0"):
        several_cores(0).__enter__()


class InNumPy(LoadCaseSpace):
    """A space that is always evaluated by NumPy."""

    core = None


def narrow_cell(kind: type[LoadCaseSpace]) -> LoadCaseSpace:
    """A KR 270 beside a post: cylinders have no closed form."""
    study = kr270_study()
    tool = study.experiments.tool
    post = Shape("cylinder", np.array([0.2, 3.0]), transform(None, (-1.4, 0.6, 1.5)), 0, "post")
    found = clearances(study.robot, tool, study.limits, [post], CollisionRules())
    space = study.space
    return kind(
        space.arm,
        FixedVector(np.array([0.0, 0.0, -2500.0])),
        space.moment,
        (*space.constraints, *found),
        space.instrument,
        space.limits,
    )


def test_a_search_does_not_depend_on_the_number_of_processes() -> None:
    space = narrow_cell(InNumPy)
    assert [space.parts(n) for n in (1, 191, 192, 10_000)] == [1, 1, 2, 4]
    start = space.sample(200, np.random.default_rng(0))
    found = []
    for workers in (1, 2, 3):
        with several_cores(workers):
            found.append(climb(space, start, np.eye(5), ((12, 200), (12, 20))))
    for other in found[1:]:
        for one, two in zip(found[0], other, strict=True):
            np.testing.assert_array_equal(one, two)


def test_what_is_measured_fast_is_not_divided() -> None:
    assert kr270_study().space.parts(10_000) == 1
    beside = narrow_cell(LoadCaseSpace)
    assert beside.parts(10_000) == (4 if beside.core is None else 1)


def bowls(x: np.ndarray, which: np.ndarray) -> Trial:
    """Minima at the number of each problem, those past 5 behind a wall at 5."""
    away = x - which[:, None]
    wall = 5.0 - x
    return Trial((away**2).sum(axis=1), wall, lambda weights: 2.0 * away + weights)


def minima(parts: Callable[[int], int]) -> Minimum:
    low, high = np.array([-50.0]), np.array([50.0])
    stages = ((40, 9), (60, 4))
    return minimise(
        bowls, np.zeros((11, 1)), low, high, stages=stages, tolerance=1e-14, parts=parts
    )


@pytest.mark.parametrize("number", [2, 3])
def test_a_batch_in_parts_is_the_batch(number: int) -> None:
    whole, divided = minima(lambda count: 1), minima(lambda count: number)
    for one, two in zip(whole, divided, strict=True):
        np.testing.assert_allclose(one, two, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(whole.origin, divided.origin)
    assert 0 < len(whole.origin) < 11
