"""Compensators: their moment is the slope of their energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastocal.errors import InputError
from elastocal.robot.compensators import Compensator, turning_joint
from tests.arms import random_chain

lengths = st.floats(0.05, 2.0)


@given(lengths, lengths, st.floats(-3.0, 3.0), st.floats(0.0, 1.0), st.floats(-3.0, 3.0))
def test_the_moment_is_minus_the_slope_of_the_energy(
    crank: float, reach: float, angle: float, rest: float, q: float
) -> None:
    spring = Compensator("C", 0, crank, reach, angle, rest)

    def energy(value: float) -> float:
        """Of a spring of 1 N/m between two points in the plane."""
        standing = reach * np.array([1.0, 0.0])
        turned = -crank * np.array([np.cos(value - angle), np.sin(value - angle)])
        return float(0.5 * (np.linalg.norm(turned - standing) - rest) ** 2)

    step = 1e-6
    if abs(np.cos(0.5 * (q - angle))) < 0.05 and abs(crank - reach) < 0.05:
        return  # both ends meet
    slope = (energy(q + step) - energy(q - step)) / (2.0 * step)
    assert spring.lever(np.array([q]))[0] == pytest.approx(-slope, abs=1e-6)


def test_it_holds_a_joint_that_turns() -> None:
    robot = random_chain(np.random.default_rng(0), [False, True])
    assert turning_joint(robot, robot.joint_names[0]) == 0
    with pytest.raises(InputError, match="slides"):
        turning_joint(robot, robot.joint_names[1])
    with pytest.raises(InputError, match="crank must be a positive length"):
        Compensator("C", 0, -0.1, 1.0)
