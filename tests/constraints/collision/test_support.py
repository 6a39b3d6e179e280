"""Which points of a solid may be the farthest: never one too few, and not many."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.constraints.collision.support import FIELDS, by_direction


def field_of(along: Array) -> int:
    """The field of a direction, as the words of `by_direction` have it."""
    axis = int(np.abs(along).argmax())
    side = 2 * axis + int(along[axis] < 0.0)
    across = along[[(axis + 1) % 3, (axis + 2) % 3]] / abs(along[axis])
    i, j = np.minimum((across + 1.0) / 2.0 * FIELDS, FIELDS - 1).astype(int)
    return int((side * FIELDS + i) * FIELDS + j)


@pytest.mark.parametrize("kind", ["any", "ball", "box twice", "flat"])
def test_the_farthest_point_is_in_the_field_of_the_direction(kind: str) -> None:
    rng = np.random.default_rng(2)
    points = rng.normal(size=(200, 3))
    if kind == "ball":
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    if kind == "box twice":
        points = np.tile(2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1.0, (2, 1))
    if kind == "flat":
        points[:, 2] = 0.5
    starts, foremost = by_direction(points)
    assert len(starts) == 6 * FIELDS**2 + 1
    assert len(foremost) / (len(starts) - 1) < 10.0  # of 200
    for along in [*rng.normal(size=(2000, 3)), *np.eye(3), *-np.eye(3), np.ones(3)]:
        k = field_of(along)
        few = points[foremost[starts[k] : starts[k + 1]]]
        assert (few @ along).max() == pytest.approx((points @ along).max(), abs=1e-12)
