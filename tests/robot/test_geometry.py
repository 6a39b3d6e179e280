"""Geometric errors of robots from tables are what is added to the rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.robot.geometry import geometric_errors, with_errors
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.sources.dh import DHRow, from_dh

Q = np.random.default_rng(0).uniform(-2.0, 2.0, (5, 6))
ROWS = tuple(
    DHRow(name, theta=theta, d=d, a=a, alpha=alpha, sign=sign)
    for name, theta, d, a, alpha, sign in (
        ("J1", 0.0, 0.128, 0.0, 0.5 * np.pi, 1),
        ("J2", -1.1, 0.0, -0.612, 0.0, 1),
        ("J3", 0.3, 0.02, -0.572, 0.0, -1),
        ("J4", 0.0, 0.164, -0.03, -1.2, -1),
        ("J5", 2.0, 0.116, 0.04, -0.5 * np.pi, 1),
        ("J6", 0.0, 0.092, 0.01, 0.4, 1),
    )
)
CASES = [
    (modified, word, row)
    for modified in (False, True)
    for word in ("a", "alpha")
    for row in range(5)
]


@pytest.mark.parametrize(("modified", "word", "row"), CASES)
def test_lengths_and_angles_are_added_to_rows(modified: bool, word: str, row: int) -> None:
    """Of a modified table to those of the next row, where the same common normal stands."""
    robot, size, changed = from_dh("arm", ROWS, modified=modified), 1e-3, list(ROWS)
    there = row + 1 if modified else row
    changed[there] = replace(ROWS[there], **{word: getattr(ROWS[there], word) + size})
    errors = geometric_errors(robot)
    values = size * np.array([name == f"{word} {ROWS[row].name}" for name in errors.names])
    np.testing.assert_allclose(
        forward_kinematics(with_errors(robot, errors, values), Q),
        forward_kinematics(from_dh("arm", changed, modified=modified), Q),
        atol=1e-12,
    )
