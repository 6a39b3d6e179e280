"""Which joints carry the long links of arms that people know."""

from __future__ import annotations

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.long_links import link_lengths, long_links
from elastocal.robot.chain import Robot
from elastocal.robot.sources import from_dh
from tests.elastic.tables import row

RIGHT = np.pi / 2


def arm(*rows: tuple[float, float, float]) -> Robot:
    """Rows a, alpha, d of a classic table."""
    table = [row(f"J{i + 1}", a=a, alpha=alpha, d=d) for i, (a, alpha, d) in enumerate(rows)]
    return from_dh("arm", table, modified=False)


COBOT = arm(
    *((0, RIGHT, 0.128), (-0.612, 0, 0), (-0.572, 0, 0)),
    *((0, RIGHT, 0.164), (0, -RIGHT, 0.116), (0, 0, 0.092)),
)
SEVEN = arm(
    *((0, RIGHT, 0.36), (0, -RIGHT, 0), (0, -RIGHT, 0.42), (0, RIGHT, 0)),
    *((0, RIGHT, 0.4), (0, -RIGHT, 0), (0, 0, 0.126)),
)


def test_upper_arm_and_forearm_of_a_heavy_arm() -> None:
    robot = ec.load_robot("kuka-kr270")
    expected = [0.35, 1.25, np.hypot(0.055, 1.1), 0.0, 0.0, 0.0]
    np.testing.assert_allclose(link_lengths(robot), expected, atol=1e-12)
    assert long_links(robot).tolist() == [False, True, True, False, False, False]


@pytest.mark.parametrize(("robot", "joints"), [(COBOT, [1, 2]), (SEVEN, [1, 3])])
def test_those_of_lighter_arms(robot: Robot, joints: list[int]) -> None:
    assert np.flatnonzero(long_links(robot)).tolist() == joints


def test_a_rail_carries_none() -> None:
    rows = [
        row("rail", prismatic=True),
        row("J1", alpha=RIGHT),
        row("J2", a=0.7),
        row("J3", a=0.6),
    ]
    robot = from_dh("on a rail", rows, modified=True)
    assert long_links(robot).tolist() == [False, True, True, False]


def test_a_single_joint_has_no_link() -> None:
    assert not long_links(from_dh("one", [row("J1")], modified=True)).any()
