"""Conventions to try on readings: also where no joint's sign matters."""

from __future__ import annotations

import pytest

from elastocal.robot.controller_axes import uncoupled
from elastocal.robot.conventions import Convention, conventions
from elastocal.robot.sources import kuka_kr270


@pytest.mark.parametrize(("joints", "least"), [([], 1), ([1], 2), ([1, 2], 4)])
def test_the_assumed_one_comes_first(joints: list[int], least: int) -> None:
    robot = kuka_kr270()
    assumed = Convention.of(uncoupled(robot))
    tried = list(conventions(robot, assumed, joints))
    assert len(tried) >= least
    assert len(tried) % 2 ** len(joints) == 0
    assert (tried[0].mixing == assumed.mixing).all()
