"""Design points of the same information are taken together, and only those."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.design.exact import ExactDesign, exact_design
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.refinement import Goal, Plans, refine
from elastocal.design.test_pose import TestPosePrecision
from elastocal.design.twins import ALIKE, merged, twins
from tests.paper.problems import PlanarForceSpace

SPACE = PlanarForceSpace()
POINTS = np.array([[1.2, -1.4, 0.7], [0.3, 0.5, 1.1], [2.0, 0.9, -0.6], [-1.0, 1.8, 2.0]])
ONCE = np.ones(4, dtype=np.int64)
GOAL = Goal(SPACE, MatrixMean(-1.0), np.zeros((3, 3)))


def informations(x: np.ndarray) -> np.ndarray:
    blocks = SPACE.evaluate(x).blocks
    return np.einsum("nri,nrj->nij", blocks, blocks)


def reversed_force(x: np.ndarray) -> np.ndarray:
    """The same points with the force in the opposite sense: the same information."""
    alpha = x[:, 2:]
    return np.hstack([x[:, :2], np.where(alpha > 0.0, alpha - np.pi, alpha + np.pi)])


def design(x: np.ndarray, counts: list[int]) -> ExactDesign:
    repeats = np.array(counts)
    return ExactDesign(x, repeats, float(GOAL.values(x[None], repeats[None])[0]))


def test_points_with_the_force_reversed_are_twins() -> None:
    x = np.concatenate([POINTS, reversed_force(POINTS[[2, 0]])])
    assert twins(informations(x), np.ones(6)) == [[0, 5], [1], [2, 4], [3]]


def test_neither_units_nor_order_of_size_matter() -> None:
    """An unknown seen 1e12 times less than another still tells points apart."""
    each = np.stack([np.diag([1.0, 1e-12]), np.diag([1.0, 2e-12]), np.diag([1.0, 1e-12])])
    assert twins(each, np.ones(3)) == [[0, 2], [1]]
    units = np.diag([1e-9, 1e4])
    assert twins(units @ each @ units, np.ones(3)) == [[0, 2], [1]]


def test_what_no_point_sees_is_no_difference() -> None:
    each = np.stack([np.diag([1.0, 0.0]), np.diag([1.0, 0.0]), np.diag([2.0, 0.0])])
    assert twins(each, np.ones(3)) == [[0, 1], [2]]
    assert twins(np.zeros((2, 2, 2)), np.ones(2)) == [[0, 1]]


@pytest.mark.parametrize(("share", "groups"), [(0.9, 1), (1.1, 2)])
def test_twins_differ_by_no_more_than_is_said(share: float, groups: int) -> None:
    mean = np.diag([4.0, 1.0])
    half = 0.5 * share * ALIKE * np.diag([0.0, 1.0])
    assert len(twins(np.stack([mean + half, mean - half]), np.ones(2))) == groups


def test_one_twin_in_place_of_another_changes_criteria_by_no_more_than_is_said() -> None:
    """The claim beside `ALIKE`, for criteria of degree 1 and twins as different as they may be."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        roots = rng.normal(size=(6, 4, 3))
        each = np.swapaxes(roots, 1, 2) @ roots
        total = each.sum(axis=0)
        moved = rng.normal(size=(3, 3))
        difference = np.linalg.cholesky(total / 6) @ (moved + moved.T)
        difference = difference @ np.linalg.cholesky(total / 6).T
        white = np.linalg.solve(np.linalg.cholesky(total / 6), difference)
        white = np.linalg.solve(np.linalg.cholesky(total / 6), white.T)
        difference *= ALIKE / np.linalg.norm(white)
        for criterion in (MatrixMean(0.0), MatrixMean(-1.0), MatrixMean(-np.inf)):
            before, after = criterion.value(np.stack([total, total + difference]))
            assert abs(after / before - 1.0) <= ALIKE / 6 * (1.0 + 1e-9)


def test_repeats_of_twins_are_added_and_nothing_is_lost() -> None:
    x = np.concatenate([POINTS, reversed_force(POINTS[[1]])])
    before = design(x, [1, 2, 3, 1, 2])
    order = np.array([4, 0, 1, 2, 3])
    after = merged(GOAL, before, order)
    assert after.counts.tolist() == [4, 3, 1, 1]
    np.testing.assert_array_equal(after.x, x[[4, 2, 0, 3]])  # the twin that was to be kept
    assert after.value == pytest.approx(before.value, rel=1e-12)


def test_a_design_without_twins_stays_as_it_is() -> None:
    before = design(POINTS, [2, 1, 1, 1])
    assert merged(GOAL, before, np.arange(4)[::-1]) is before


def test_twins_that_a_search_left_apart_are_refined_into_one() -> None:
    """At an optimum, one of two twins moved a little: together they are worth what they were."""
    goal = Goal(SPACE, TestPosePrecision(np.diag([3.0, 1.0, 2.0])), np.zeros((3, 3)))
    best = exact_design(goal, 4, 2, np.random.default_rng(0))
    x = np.concatenate([best.x, reversed_force(best.x[:1])])
    counts = np.append(best.counts, 1)
    off = x.copy()
    off[0] += 1e-5
    polished = refine(goal, Plans(x[None], counts[None]), stages=((300, 1),), tolerance=1e-13)
    before = ExactDesign(off, counts, float(polished.value[0]))
    after = merged(goal, before, np.arange(len(x)))
    assert len(after.x) == len(best.x)
    assert after.counts.sum() == counts.sum()
    assert after.value >= before.value * (1.0 - 1e-9)
    unrefined = goal.values(off[None, : len(best.x)], after.counts[None])  # what it would be worth
    assert unrefined[0] < before.value * (1.0 - 1e-12)


def test_twins_are_left_where_taking_them_together_would_lose() -> None:
    """What the search says it is worth is not reached by either of them."""
    x = np.concatenate([POINTS, reversed_force(POINTS[[1]])])
    before = design(x, [1, 1, 1, 1, 1])
    better = ExactDesign(before.x, before.counts, 1e6 * before.value)
    assert merged(GOAL, better, np.arange(5)) is better


def test_what_only_rounding_sees_does_not_count_beside_what_is_known() -> None:
    each = np.array([np.diag([1.0, 1e-30]), np.diag([1.0, 3e-30])])
    assert twins(each, np.ones(2)) == [[0], [1]]
    assert twins(each, np.ones(2), np.diag([0.0, 1.0])) == [[0, 1]]
