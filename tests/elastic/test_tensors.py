"""Springs of one place whose axes are dependent: only their sum has a sign."""

from __future__ import annotations

import numpy as np

from elastocal.elastic.springs import VirtualJoints
from elastocal.elastic.tensors import against_the_load, of_tensors

ROOT = np.sqrt(0.5)
AXES = np.array([[1.0, 0, 0], [0, 1, 0], [ROOT, ROOT, 0], [0, 0, 1], [1, 0, 0], [1, 0, 0]])


def springs() -> VirtualJoints:
    """A tensor across an axis, the joint there, a foot elsewhere, and a slide."""
    return VirtualJoints(
        ("x", "y", "between", "joint", "foot", "slide"),
        np.array([1, 1, 1, 1, 1, 1]),
        AXES,
        np.array([[0.0, 0, 1]] * 4 + [[0.0, 0, 2]] * 2),
        np.array([False] * 5 + [True]),
        np.array([-1, -1, -1, 3, -1, -1]),
    )


def test_only_dependent_axes_of_one_place_are_a_tensor() -> None:
    np.testing.assert_array_equal(of_tensors(springs()), [True] * 3 + [False] * 3)


def test_a_tensor_may_have_negative_parts_and_no_negative_sum() -> None:
    """n1 - n12, n2 - n12 and 2 n12 for n1 = 2, n2 = 1: up to n12² = n1 n2."""

    def of(n12: float, *others: float) -> tuple[str, ...]:
        return against_the_load(springs(), np.array([2.0 - n12, 1.0 - n12, 2.0 * n12, *others]))

    assert of(1.0, 1.0, 1.0, 1.0) == ()
    assert of(1.4, 1.0, 1.0, 1.0) == ()  # the second is negative
    assert of(-1.4, 1.0, 1.0, 1.0) == ()
    assert of(1.42, 1.0, 1.0, 1.0) == ("y",)
    assert of(-1.42, 1.0, 1.0, 1.0) == ("between",)
    assert of(0.5, -1.0, 1.0, -1.0) == ("joint", "slide")
