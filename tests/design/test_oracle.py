"""Climbing and restoring alone: polygons in which everything can be worked out by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from elastocal.arrays import Array, BoolArray
from elastocal.design import dual_bound as bound_file
from elastocal.design.dual_bound import dual_bound
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.oracle import climb, restore, sensitivity
from elastocal.matrices import square_root
from tests.design.polynomial import polynomial

MM = 1e-3
CORNER = (np.array([[-1.0, 0.0], [0.0, -1.0]]), np.array([0.5, 0.4]))  # x <= 0.5, y <= 0.4
SLANTED = (np.array([[-0.6, -0.8], [0.6, -0.8]]), np.array([0.4, 0.4]))  # a roof


class Polygon:
    """Rows f(x) = x in a box with margins a x + b, or with a round wall |x| <= radius."""

    parameters = 2

    def __init__(self, sides: tuple[Array, Array], size: float = 1.0, radius: float = 0.0) -> None:
        self.normals, self.offsets = sides
        self.lower, self.upper = np.full(2, -size), np.full(2, size)
        self.radius = radius

    core = None

    def parts(self, count: int) -> int:
        return 1

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        x = rng.uniform(self.lower, self.upper, (20 * count, 2))
        return x[(self.evaluate(x).margins >= 0.0).all(axis=1)][:count]

    def feasible(self, x: Array) -> BoolArray:
        return np.asarray((self.evaluate(x).margins >= 0.0).all(axis=1))

    def evaluate(self, x: Array, repeats: Array | None = None) -> PolygonEvaluation:
        return PolygonEvaluation(self, x)


class PolygonEvaluation:
    def __init__(self, space: Polygon, x: Array) -> None:
        self.x, self.normals, self.blocks = x, space.normals, x[:, None, :]
        self.margins = x @ space.normals.T + space.offsets
        self.round = space.radius > 0.0
        if self.round:
            wall = space.radius - np.linalg.norm(x, axis=1)
            self.margins = np.column_stack([self.margins, wall])

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        count = len(self.normals)
        result = block_cotangent[:, 0] + margin_cotangent[:, :count] @ self.normals
        if self.round:
            unit = self.x / np.linalg.norm(self.x, axis=1, keepdims=True)
            result = result - margin_cotangent[:, count:] * unit
        return result


@pytest.mark.parametrize("sides", [CORNER, SLANTED], ids=["corner", "roof"])
@pytest.mark.parametrize("depth", [MM, 0.2])
def test_one_broken_margin_is_mended_the_shortest_way(
    sides: tuple[Array, Array], depth: float
) -> None:
    """Straight back along the normal, by the depth and nothing more."""
    space, normal = Polygon(sides), sides[0][0]
    foot = -normal * sides[1][0] + 0.1 * np.array([-normal[1], normal[0]])
    start = np.array([foot - depth * normal])
    assert (space.evaluate(start).margins[0] < 0.0).tolist() == [True, False]
    found = restore(space, start)
    assert (space.evaluate(found).margins >= 0.0).all()
    np.testing.assert_allclose(found[0], foot, atol=1e-8)


@pytest.mark.parametrize("sides", [CORNER, SLANTED], ids=["corner", "roof"])
def test_two_broken_margins_are_mended_together(sides: tuple[Array, Array]) -> None:
    """Beyond both by a millimetre: to the corner where both hold, which is the nearest point."""
    space, corner = Polygon(sides), np.linalg.solve(sides[0], -sides[1])
    start = np.array([np.linalg.solve(sides[0], -sides[1] - MM)])
    found = restore(space, start)
    assert (space.evaluate(found).margins >= 0.0).all()
    assert np.linalg.norm(found[0] - start[0]) <= 1.0001 * np.linalg.norm(corner - start[0])


def test_at_a_bound_one_goes_along_it() -> None:
    """At x = 1 and outside the roof: x is pinned, y alone mends."""
    space = Polygon((np.array([[0.6, -0.8]]), np.array([0.1])))
    found = restore(space, np.array([[1.0, 0.95], [5.0, 0.95], [0.5, 0.9]]))
    np.testing.assert_allclose(found[:2], [[1.0, 0.875]] * 2, atol=1e-8)
    shortest = np.array([0.5, 0.9]) - 0.32 * np.array([-0.6, 0.8])
    np.testing.assert_allclose(found[2], shortest, atol=1e-8)


def test_a_round_wall_is_reached_in_a_few_steps() -> None:
    space = Polygon(CORNER, radius=0.3)
    start = np.array([[0.48, -0.64], [-0.9, -0.9], [0.1, 0.1]])
    found = restore(space, start, iterations=6)
    np.testing.assert_allclose(np.linalg.norm(found[:2], axis=1), 0.3, atol=1e-8)
    np.testing.assert_allclose(found[0], [0.18, -0.24], atol=1e-8)
    np.testing.assert_array_equal(found[2], start[2])


def test_climbs_end_at_the_corners_of_the_polygon() -> None:
    """|x v|² is largest at vertices; starts outside are allowed, results are inside."""
    space = Polygon(CORNER)
    root = np.array([[2.0, 0.0], [0.0, 1.0]])
    starts = np.random.default_rng(0).uniform(-1, 1, (40, 2))
    found, s, origin = climb(space, starts, root @ root.T, ((200, 40),))
    assert (space.evaluate(found).margins >= 0.0).all()
    best = found[s.argmax()]
    np.testing.assert_allclose(best, [-1.0, -1.0], atol=1e-6)
    assert s.max() == pytest.approx(5.0)
    np.testing.assert_allclose(s, np.sum((found @ root) ** 2, axis=1))
    left = starts[origin][:, 0] < -0.2
    np.testing.assert_allclose(found[left][:, 0], -1.0, atol=1e-4)
    np.testing.assert_allclose(found[starts[origin][:, 0] > 0.2][:, 0], 0.5, atol=1e-4)


def test_sensitivity_by_hand() -> None:
    space = Polygon(CORNER)
    x = np.array([[0.3, 0.2], [0.5 + 2e-8, 0.0], [0.5 + 0.5e-8, 0.0]])
    root = square_root(np.array([[5.0, 2.0], [2.0, 8.0]]))
    np.testing.assert_allclose(root @ root.T, [[5.0, 2.0], [2.0, 8.0]])
    expected = 5 * 0.3**2 + 2 * 2 * 0.3 * 0.2 + 8 * 0.2**2
    np.testing.assert_allclose(sensitivity(space, x, root), [expected, -1.0, 1.25], rtol=1e-6)
    assert square_root(np.diag([3.0, 0.0])).shape == (2, 1)


def spied(monkeypatch: pytest.MonkeyPatch, name: str) -> list[Array]:
    """The points that a function of the bound is given, call by call."""
    seen: list[Array] = []
    real: Callable[..., object] = getattr(bound_file, name)

    def spy(space: object, x: Array, *rest: object) -> object:
        seen.append(np.array(x))
        return real(space, x, *rest)

    monkeypatch.setattr(bound_file, name, spy)
    return seen


def test_what_is_known_is_climbed_once_and_what_is_stirred_by_the_ranges(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A box of very unequal ranges; few starts reach the top, so that more are made."""
    space = Polygon(CORNER)
    space.lower, space.upper = np.array([-1.0, -1e-3]), np.array([1.0, 1e-3])
    climbs, stirred = spied(monkeypatch, "climb"), spied(monkeypatch, "restore")
    known = np.array([[0.1, 1e-4], [0.2, 2e-4], [0.3, 3e-4]])
    found = dual_bound(
        space, MatrixMean(0.0, "D"), np.diag([1.0, 2.0]), np.diag([3.0, 0.5]), known,
        np.random.default_rng(0), fresh=5,
    )  # fmt: skip
    assert [len(x) for x in climbs[:2]] == [8, 5]
    np.testing.assert_array_equal(climbs[0][:3], known)
    assert found.starts == sum(len(x) for x in climbs[:-1]) - 3
    assert found.attained >= 12
    gradient = MatrixMean(0.0, "D").gradient(np.diag([1.0, 2.0])[None])[0]
    np.testing.assert_allclose(found.gradient, gradient)
    assert found.offset == pytest.approx(float(np.sum(gradient * np.diag([3.0, 0.5]))))
    assert found.upper == pytest.approx(found.offset + found.largest)
    off = stirred[0] - found.x_found[: len(stirred[0])].mean(axis=0)
    assert np.abs(off[:, 1]).max() < 4e-3
    assert 0.01 < np.median(np.abs(np.abs(stirred[0][:, 0]) - 1.0)) < 0.2


def test_few_starts_that_reach_the_top_are_followed_by_more() -> None:
    """All of a polynomial's starts reach an end or the middle: a third would be enough."""
    design = dual_bound(
        polynomial(1), MatrixMean(0.0, "D"), np.eye(2), np.zeros((2, 2)), np.zeros((0, 1)),
        np.random.default_rng(0), fresh=20,
    )  # fmt: skip
    assert design.starts == 20
    assert design.attained == 20
    assert design.largest == pytest.approx(1.0)
    assert abs(design.x_largest[0]) == pytest.approx(1.0)
