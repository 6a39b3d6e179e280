"""The compiled core against NumPy: rows, margins and gradients, climbs and plans.

`LoadCaseEvaluation` and the movers of `design/` say the same in Python; those are held against
Pinocchio and differences where they are tested.
"""

from __future__ import annotations

import pickle
from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.constraints import Constraint, HalfSpace
from elastocal.core.library import levels
from elastocal.cores import several_cores
from elastocal.design.criterion import Criterion
from elastocal.design.lockstep import Batch, Mover, _Search
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.oracle import _Descent, restore
from elastocal.design.power_mean import PowerMean
from elastocal.design.refinement import Goal, _Worth
from elastocal.design.space import DesignSpace
from elastocal.design.test_pose import TestPosePrecision
from elastocal.design.worst_pose import SoftWorstPose
from elastocal.robot.posture import Posture
from elastocal.study.compiled import CompiledSpace
from elastocal.study.experiment_space import LoadCaseEvaluation, LoadCaseSpace
from tests.constraints.test_constraints import CONSTRAINTS
from tests.core.spaces import random_space
from tests.paper.problems import cone, kr270
from tests.paper.published import A0

LEVELS = levels()
pytestmark = pytest.mark.skipif(not LEVELS, reason="the core is not compiled")

ROUNDING = 1e-12  # rows and gradients, of the largest; chains here are up to 10 m long
CLAMPED = 1e-9  # where an arc function is steep
ERRING = 1e-9  # where errors of load cases are up to ten thousand times the noise

shapes = st.tuples(
    st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=9), st.integers(1, 3)
)


def in_core(space: LoadCaseSpace) -> Iterator[CompiledSpace]:
    """The space at every level of instructions."""
    for library in LEVELS.values():
        yield CompiledSpace(library, space)


def close(actual: np.ndarray, expected: np.ndarray, tolerance: float = ROUNDING) -> None:
    """Equal within `tolerance` of the largest entry."""
    assert actual.shape == expected.shape
    size = np.abs(expected).max(initial=0.0)
    assert np.abs(actual - expected).max(initial=0.0) <= tolerance * size


@settings(max_examples=120)
@given(shapes, st.integers(0, 11))
def test_rows_margins_and_gradients_of_any_space(
    shape: tuple[int, list[bool], int], count: int
) -> None:
    space, rng = random_space(*shape), np.random.default_rng(shape[0])
    x = rng.uniform(1.2 * space.lower, 1.2 * space.upper, (count, len(space.lower)))
    repeats = rng.uniform(0.5, 12.0, count) if rng.random() < 0.5 else None
    expected = LoadCaseEvaluation(space, x, repeats)
    rows, margins = (rng.normal(size=a.shape) for a in (expected.blocks, expected.margins))
    exact = ROUNDING if space.errors is None else ERRING
    for core in in_core(space):
        assert not core.foreign
        found = core.evaluate(x, repeats)
        close(found.blocks, expected.blocks, exact)
        np.testing.assert_allclose(found.margins, expected.margins, rtol=0, atol=CLAMPED)
        close(found.pull(rows, 0 * margins), expected.pull(rows, 0 * margins), exact)
        close(found.pull(0 * rows, margins), expected.pull(0 * rows, margins), CLAMPED)
        close(found.pull(rows, margins), expected.pull(rows, margins), CLAMPED)


@pytest.mark.parametrize("name", CONSTRAINTS)
def test_every_kind_of_constraint(name: str) -> None:
    """Of those near solids many of these configurations are inside one."""
    space = replace(kr270(A0).space, constraints=[CONSTRAINTS[name]])
    x = np.random.default_rng(0).uniform(-2.5, 2.5, (1001, 6))
    expected = LoadCaseEvaluation(space, x, None)
    weights = np.random.default_rng(1).normal(size=expected.margins.shape)
    for core in in_core(space):
        assert not core.foreign
        found = core.evaluate(x)
        np.testing.assert_allclose(found.margins, expected.margins, rtol=0, atol=1e-11)
        np.testing.assert_array_equal(core.holds(x), (found.margins >= 0.0).all(axis=1))
        none = np.zeros_like(expected.blocks)
        close(found.pull(none, weights), expected.pull(none, weights), 1e-11)


def test_the_same_to_the_last_digit_at_every_level() -> None:
    """What is computed of a load case does not depend on those beside it."""
    space = random_space(3, [False, True, False, False], 2)
    x = np.random.default_rng(0).uniform(space.lower, space.upper, (23, len(space.lower)))
    found = [core.evaluate(x) for core in in_core(space)]
    for one in found[1:]:
        np.testing.assert_array_equal(one.blocks, found[0].blocks)
        np.testing.assert_array_equal(one.margins, found[0].margins)
    for core in in_core(space):
        alone = np.concatenate([core.evaluate(one[None]).blocks for one in x])
        np.testing.assert_array_equal(alone, found[0].blocks)


class Plain(Constraint):
    """A half-space of a kind that the core does not know."""

    def __init__(self, known: HalfSpace) -> None:
        self.known, self.name, self.unit = known, known.name, "m"

    def at(self, posture: Posture):  # type: ignore[no-untyped-def]
        return self.known.at(posture)


def spaces() -> dict[str, LoadCaseSpace]:
    """Studies with the paper's constraints, with a cone, and with one that only Python knows."""
    fixed, free = kr270(A0).space, kr270(A0, force=cone(30.0)).space
    strange = [Plain(c) if isinstance(c, HalfSpace) else c for c in free.constraints]
    return {"fixed": fixed, "cone": free, "foreign": replace(free, constraints=strange)}


SPACES = spaces()


def moved(mover: Mover, x: np.ndarray, iterations: Sequence[int]) -> Batch:
    """A batch after so many evaluations, settled after each."""
    batch = mover.begin(np.arange(len(x)), x, np.resize([0.3, 1.0, 10.0], len(x)))
    for count in iterations:
        mover.advance(batch, count, settle=True)
    return batch


def check(mover: Mover, reference: Mover, x: np.ndarray) -> None:
    """Few evaluations agree but for rounding, which later grows; many lead to as good ends."""
    found, expected = (moved(one, x, (4, 3)) for one in (mover, reference))
    for name in ("x", "value", "margins", "merit", "gradient", "multipliers", "penalty", "gain"):
        one, other = getattr(found, name), getattr(expected, name)
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-7 * np.abs(other).max())
    np.testing.assert_array_equal(found.fresh, expected.fresh)
    found, expected = (moved(one, x, [10] * 12) for one in (mover, reference))
    assert np.median(found.merit) == pytest.approx(np.median(expected.merit), rel=1e-2, abs=2e-2)
    assert found.merit.min() == pytest.approx(expected.merit.min(), rel=1e-3, abs=1e-3)


def numpy_mover(problem: object, space: DesignSpace, points: int) -> Mover:
    lower, upper = np.tile(space.lower, points), np.tile(space.upper, points)
    return _Search(problem, lower, upper)  # type: ignore[arg-type]


class InNumPy(LoadCaseSpace):
    """The same space, always evaluated by NumPy."""

    core = None


def reference(space: LoadCaseSpace) -> InNumPy:
    return InNumPy(**{field.name: getattr(space, field.name) for field in fields(space)})


@pytest.mark.parametrize("name", SPACES)
def test_climbs(name: str) -> None:
    space, rng = SPACES[name], np.random.default_rng(2)
    x = space.sample(61, rng)
    root = rng.normal(size=(5, 3))
    level = float(((space.evaluate(x).blocks @ root) ** 2).sum(axis=(1, 2)).max())
    plain = reference(space)
    for core in in_core(space):
        check(core.climbing(root, level), numpy_mover(_Descent(plain, root, level), plain, 1), x)


def criteria() -> dict[str, Criterion]:
    """One loss, many, more columns than unknowns, and those that only Python knows."""
    rng = np.random.default_rng(4)
    weights = [a @ a.T for a in rng.normal(size=(3, 5, 3))]
    return {
        "test pose": TestPosePrecision(weights[0]),
        "all alike": TestPosePrecision(np.eye(5)),
        "mean": PowerMean([TestPosePrecision(w) for w in weights], 2.0),
        "worst": SoftWorstPose(rng.normal(size=(4, 3, 5))),
        "D": MatrixMean(0.0),
    }


CRITERIA = criteria()


@pytest.mark.parametrize("name", CRITERIA)
def test_plans_by_every_kind_of_criterion(name: str) -> None:
    check_plans(SPACES["cone"], CRITERIA[name], 3)


@pytest.mark.parametrize("name", SPACES)
def test_plans_in_every_kind_of_space(name: str) -> None:
    check_plans(SPACES[name], CRITERIA["test pose"], 4)


def check_plans(space: LoadCaseSpace, criterion: Criterion, points: int) -> None:
    rng = np.random.default_rng(3)
    x = space.sample(13 * points, rng).reshape(13, -1)
    counts = rng.integers(1, 4, (13, points))
    base = 1e-3 * np.eye(5)
    plain = reference(space)
    problem = _Worth(Goal(plain, criterion, base), counts)
    for core in in_core(space):
        check(core.planning(counts, base, criterion), numpy_mover(problem, plain, points), x)


@settings(max_examples=60)
@given(shapes)
def test_which_points_are_feasible(shape: tuple[int, list[bool], int]) -> None:
    space, rng = random_space(*shape), np.random.default_rng(shape[0])
    x = rng.uniform(space.lower, space.upper, (57, len(space.lower)))
    margins = LoadCaseEvaluation(space, x, None).margins
    clear = (np.abs(margins) > 1e-9).all(axis=1)
    for core in in_core(space):
        np.testing.assert_array_equal(core.holds(x)[clear], (margins >= 0.0).all(axis=1)[clear])


@pytest.mark.parametrize("name", SPACES)
def test_restored_points(name: str) -> None:
    """They differ where steps do not come to rest; as many are feasible, as near as before."""
    space, rng = SPACES[name], np.random.default_rng(6)
    x = rng.uniform(1.1 * space.lower, 1.1 * space.upper, (301, len(space.lower)))
    plain = reference(space)
    expected = restore(plain, x)
    fine = (plain.evaluate(expected).margins >= 0.0).all(axis=1)
    assert fine.mean() > 0.5
    for core in in_core(space):
        found = core.restored(x, 30)
        if core.foreign:
            assert found is None
            continue
        assert found is not None
        same = np.abs(found - expected).max(axis=1) < 1e-6
        assert same[fine].mean() > 0.95
        assert (plain.evaluate(found).margins >= 0.0).all(axis=1).mean() > fine.mean() - 0.03


def test_a_core_goes_to_another_process() -> None:
    space = SPACES["cone"]
    x = space.sample(5, np.random.default_rng(0))
    for core in in_core(space):
        there = pickle.loads(pickle.dumps(core))
        assert there.library is core.library
        np.testing.assert_array_equal(there.evaluate(x).blocks, core.evaluate(x).blocks)


def test_threads_change_nothing() -> None:
    """Each has a part of the batch; what does not divide evenly is somebody's, too."""
    space, rng = SPACES["cone"], np.random.default_rng(5)
    x, counts = space.sample(721, rng), np.ones((211, 3), dtype=np.int64)
    plans = space.sample(633, rng).reshape(211, -1)
    for core in in_core(space):
        climbing = core.climbing(np.eye(5), 1e3)
        planning = core.planning(counts, np.eye(5), CRITERIA["test pose"])
        for mover, starts in ((climbing, x), (planning, plans)):
            alone = moved(mover, starts, (10, 10))
            with several_cores(3):
                together = moved(mover, starts, (10, 10))
            for field in fields(alone):
                np.testing.assert_array_equal(
                    getattr(together, field.name), getattr(alone, field.name)
                )


class Broken(Plain):
    """Fails when it is asked by the core."""

    def at(self, posture: Posture):  # type: ignore[no-untyped-def]
        raise KeyboardInterrupt


def test_what_goes_wrong_in_python_is_raised_where_the_core_was_called() -> None:
    space = SPACES["foreign"]
    strange = [Broken(c.known) if isinstance(c, Plain) else c for c in space.constraints]
    x = space.sample(5, np.random.default_rng(0))
    for core in in_core(replace(space, constraints=strange)):
        with pytest.raises(KeyboardInterrupt):
            core.climbing(np.eye(5), 1.0).begin(np.arange(5), x, np.ones(5))
