"""Narrow parts of a feasible set are found, and the bound looks there."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.arrays import Array, BoolArray
from elastocal.design.continuous import continuous_design
from elastocal.design.dual_bound import dual_bound
from elastocal.design.matrix_means import MatrixMean
from elastocal.design.narrow_parts import narrow_parts
from tests.design.polynomial import polynomial


class TwoRooms:
    """Rows (1, g(x)) over a rectangle; behind a wall is a closet, one random point in 300.

    g is between ±.5 in the room, with summits of its own there, and .6 in the closet. Random
    points in the wall are pushed out of it on both sides.
    """

    parameters = 2
    lower, upper = np.array([-1.0, -1.0]), np.array([4.0, 1.0])
    wall, closet, depth = 0.6, 3.9, 0.05

    def margins(self, x: Array) -> tuple[Array, Array]:
        """(N, 1) margin and (N, 2) its gradient."""
        room = self.wall - x[:, 0]
        sides = np.stack([x[:, 0] - self.closet, self.depth - x[:, 1], self.depth + x[:, 1]])
        slopes = np.array([[1.0, 0.0], [0.0, -1.0], [0.0, 1.0]])[sides.argmin(axis=0)]
        inside = sides.min(axis=0)
        slopes = np.where((room > inside)[:, None], [-1.0, 0.0], slopes)
        return np.maximum(room, inside)[:, None], slopes

    core = None

    def parts(self, count: int) -> int:
        return 1

    def sample(self, count: int, rng: np.random.Generator) -> Array:
        x = rng.uniform(self.lower, self.upper, (5 * count, 2))
        return x[self.feasible(x)][:count]

    def feasible(self, x: Array) -> BoolArray:
        return np.asarray(self.margins(x)[0][:, 0] >= 0.0)

    def evaluate(self, x: Array, repeats: Array | None = None) -> RoomEvaluation:
        return RoomEvaluation(self, x)


class RoomEvaluation:
    def __init__(self, space: TwoRooms, x: Array) -> None:
        bump = 0.6 * np.exp(-(((x[:, 0] - 4.0) / 0.3) ** 2))
        g = 0.5 * np.sin(np.pi * x[:, 0]) + bump
        self.slope = 0.5 * np.pi * np.cos(np.pi * x[:, 0]) - bump * (x[:, 0] - 4.0) / 0.045
        self.blocks = np.stack([np.ones(len(x)), g], axis=1)[:, None]
        self.margins, self.slopes = space.margins(x)

    def pull(self, block_cotangent: Array, margin_cotangent: Array) -> Array:
        pulled = margin_cotangent * self.slopes
        pulled[:, 0] += block_cotangent[:, 0, 1] * self.slope
        return pulled


ROOM = np.array([[-0.5, 0.0], [0.5, 0.0]])
"""The best design without the closet, g = ±.5; its D is .5, and .55 with the closet."""


def measure(space: TwoRooms, x: Array) -> Array:
    """Information of equal weights on points (S, d)."""
    rows = space.evaluate(x).blocks[:, 0]
    return np.asarray(rows.T @ rows / len(x))


def test_the_small_room_is_found() -> None:
    space = TwoRooms()
    share = (space.sample(20000, np.random.default_rng(0))[:, 0] > 0.6).mean()
    assert share < 0.005
    x = narrow_parts(space, np.random.default_rng(1))
    assert space.feasible(x).all()
    assert np.sum(x[:, 0] >= space.closet) >= 20


def test_where_straight_lines_lead_everywhere_there_is_none() -> None:
    """Nor in a box, which is not even looked at."""
    assert narrow_parts(polynomial(2), np.random.default_rng(0)).shape == (0, 1)
    space = TwoRooms()
    space.wall = 10.0
    assert narrow_parts(space, np.random.default_rng(0)).shape == (0, 2)


def test_a_bound_is_refuted_from_the_small_room() -> None:
    space, d, rng = TwoRooms(), MatrixMean(0.0), np.random.default_rng
    total, base, known = measure(space, ROOM), np.zeros((2, 2)), np.zeros((0, 2))
    narrow = narrow_parts(space, rng(1))
    space.sample = lambda count, rng: rng.uniform(-1.0, [0.6, 1.0], (count, 2))  # type: ignore[method-assign]
    blind = dual_bound(space, d, total, base, known, rng(2))
    seeing = dual_bound(space, d, total, base, known, rng(2), narrow=narrow)
    assert blind.upper == pytest.approx(0.5)
    assert blind.narrow_starts == blind.narrow_attained == 0
    assert seeing.upper > 0.6
    assert seeing.x_largest[0] == pytest.approx(4.0, abs=0.02)
    assert seeing.narrow_starts == len(narrow)
    assert 0 < seeing.narrow_attained <= seeing.narrow_starts
    design = continuous_design(space, d, rng(3))
    assert design.certificate.upper == pytest.approx(0.55, rel=1e-3)


def test_where_narrow_parts_refute_nothing_they_change_nothing() -> None:
    """To the last digit: their random numbers are their own."""
    space, d = TwoRooms(), MatrixMean(0.0)
    total, base = np.eye(2), np.zeros((2, 2))
    known, rng = np.array([[4.0, 0.0], [-0.5, 0.3]]), np.random.default_rng
    once, again = rng(4), rng(4)
    without = dual_bound(space, d, total, base, known, once)
    given = dual_bound(space, d, total, base, known, again, narrow=narrow_parts(space, rng(1)))
    assert without.upper == given.upper
    assert (without.starts, without.attained) == (given.starts, given.attained)
    assert once.random() == again.random()


def test_a_support_that_few_starts_find_is_followed_by_more() -> None:
    """Of two points of the support the closet's is found from one start in 500."""
    space, d = TwoRooms(), MatrixMean(0.0)
    support, known = np.array([[-0.5, 0.0], [4.0, 0.0]]), np.array([[4.0, 0.0]])
    total, base = measure(space, support), np.zeros((2, 2))
    plain = dual_bound(space, d, total, base, known, np.random.default_rng(5))
    asked = dual_bound(space, d, total, base, known, np.random.default_rng(5), support=support)
    assert plain.starts == 600
    assert plain.rarest == plain.attained
    assert asked.starts > 600
    assert asked.rarest < plain.rarest
    assert asked.upper == plain.upper
    refuted = dual_bound(
        space, d, total, base, known, np.random.default_rng(5), support=support, level=0.1
    )
    assert refuted.starts == 600  # enough is known
