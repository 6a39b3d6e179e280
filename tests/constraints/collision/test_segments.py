"""Closed forms against coal, against arithmetic, and against what a distance means."""

from __future__ import annotations

import coal
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastocal.constraints.collision.segments import between_segments, segment_and_box
from tests.arms import random_rotation, random_transform
from tests.constraints.collision.oracle import distance, solid

COORDINATE = st.integers(-4, 4).map(lambda k: k / 2.0)  # coarse: parallel, touching, crossing
POINT = st.tuples(COORDINATE, COORDINATE, COORDINATE).map(np.array)


def column(point: np.ndarray) -> np.ndarray:
    return np.asarray(point, dtype=float)[:, None]


@given(POINT, POINT, POINT, POINT)
def test_no_two_points_of_the_segments_are_nearer(a, b, c, d) -> None:
    found = between_segments(*map(column, (a, b, c, d)))
    share = np.linspace(0.0, 1.0, 41)[:, None]
    first, second = a + share * (b - a), c + share * (d - c)
    least = np.linalg.norm(first[:, None] - second[None], axis=2).min()
    assert found.distance[0] <= least + 1e-12
    gap = np.linalg.norm(found.first - found.second)
    assert found.distance[0] == pytest.approx(gap, abs=1e-12)
    assert np.linalg.norm(found.normal) == pytest.approx(1.0)
    for point, (start, end) in ((found.first, (a, b)), (found.second, (c, d))):
        off = np.linalg.norm(point[:, 0] - start) + np.linalg.norm(point[:, 0] - end)
        assert off == pytest.approx(np.linalg.norm(end - start), abs=1e-9)


def test_capsules_are_as_far_apart_as_coal_says() -> None:
    rng = np.random.default_rng(0)
    ends = rng.uniform(-1.0, 1.0, (4, 3, 300))
    found = between_segments(*ends)
    for k in range(300):
        a, b, c, d = ends[:, :, k]
        expected = distance(*solid(a, b, 0.2), *solid(c, d, 0.1))
        assert found.distance[k] - 0.3 == pytest.approx(expected, abs=1e-7)


def test_pairs_that_cross_beside_pairs_that_do_not() -> None:
    """In one batch: crossing lines part square to both, the others along their gap."""
    a, b = np.array([[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]).T, np.array([[1.0, 0, 0], [1.0, 0, 0]]).T
    c, d = np.array([[0.0, -1.0, 0.0], [2.0, -1, 3]]).T, np.array([[0.0, 1.0, 0.0], [2, 1, 3.0]]).T
    found = between_segments(a, b, c, d)
    np.testing.assert_allclose(found.distance, [0.0, np.sqrt(10.0)], atol=1e-12)
    np.testing.assert_allclose(np.abs(found.normal[:, 0]), [0.0, 0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(found.normal[:, 1], np.array([-1.0, 0, -3]) / np.sqrt(10.0))


def test_two_balls() -> None:
    a, c = column([1.0, 2.0, 2.0]), column([0.0, 0.0, 0.0])
    found = between_segments(a, a, c, c)
    assert found.distance[0] == pytest.approx(3.0, abs=1e-15)
    assert found.normal[:, 0] == pytest.approx(np.array([1.0, 2.0, 2.0]) / 3.0)


@pytest.mark.parametrize("scale", [0.3, 1.0, 3.0])
def test_capsules_and_boxes_are_as_far_apart_as_coal_says(scale: float) -> None:
    """Small scales: most overlap, and the depth of penetration is compared."""
    rng = np.random.default_rng(1)
    deep = 0
    for _ in range(150):
        half = rng.uniform(0.1, 1.0, 3)
        T = random_transform(rng)
        a, b = T[:3, 3] + scale * rng.uniform(-1.0, 1.0, (2, 3))
        found = segment_and_box(column(a), column(b), T[:3, :3], T[:3, 3], half)
        box = coal.Box(*(2.0 * half))
        expected = distance(*solid(a, b, 0.05), box, coal.Transform3s(T[:3, :3], T[:3, 3]))
        assert found.distance[0] - 0.05 == pytest.approx(expected, abs=2e-6)
        deep += expected < -0.05
    assert deep > 3 if scale < 3.0 else True


@given(POINT, POINT, st.integers(0, 99))
def test_moving_out_by_the_depth_parts_segment_and_box(a, b, seed: int) -> None:
    rng = np.random.default_rng(seed)
    half, rotation = np.array([1.0, 0.5, 0.75]), random_rotation(rng)
    found = segment_and_box(column(a), column(b), rotation, np.zeros(3), half)
    assert np.linalg.norm(found.normal) == pytest.approx(1.0, abs=1e-9)
    out = -found.distance[0] * found.normal
    moved = segment_and_box(column(a) + out, column(b) + out, rotation, np.zeros(3), half)
    assert moved.distance[0] == pytest.approx(0.0, abs=1e-9)
    if found.distance[0] < -1e-6:  # and no shorter way does
        less = segment_and_box(
            column(a) + 0.9 * out, column(b) + 0.9 * out, rotation, np.zeros(3), half
        )
        assert less.distance[0] < 0.0


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [
        ([0, 0, 3], [0, 0, 5], 2.0),  # over a face, on end
        ([-9, 0, 3], [9, 0, 3], 2.0),  # along a face
        ([-5, 5, 0], [5, 5, 0], 3.0),
        ([4, 6, 0], [4, 6, 0], 5.0),  # from an edge: 3, 4, 5
        ([3, 4, 7], [3, 4, 7], np.sqrt(4 + 4 + 36.0)),  # from a corner
        ([0, 0, 0.5], [0, 0, 0.5], -0.5),  # inside, nearest to the top
        ([0.9, 0, -9], [0.9, 0, 9], -0.1),  # right through, near a side
    ],
)
def test_segment_and_box_by_hand(a: list[float], b: list[float], expected: float) -> None:
    half = np.array([1.0, 2.0, 1.0])
    found = segment_and_box(column(a), column(b), np.eye(3), np.zeros(3), half)
    assert found.distance[0] == pytest.approx(expected, abs=1e-12)
