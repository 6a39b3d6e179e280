"""Circles that solids are drawn with."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.drawing.solids import circle


@pytest.mark.parametrize("normal", [[0.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.3, -0.4, 1.2]])
def test_a_circle_is_once_around_its_normal_by_the_right_hand_rule(normal: list[float]) -> None:
    points = circle(np.array(normal), 8)
    along = np.array(normal) / np.linalg.norm(normal)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0)
    np.testing.assert_allclose(points @ along, 0.0, atol=1e-15)
    turned = np.cross(points, np.roll(points, -1, axis=0)) @ along
    np.testing.assert_allclose(turned, np.sin(np.pi / 4.0))
