"""Where springs besides are, with the arm at zero."""

from __future__ import annotations

import numpy as np

import elastocal as ec
from elastocal.elastic.effects import Size, effects_of
from elastocal.elastic.places import places_of


def test_foot_link_and_tool_of_a_heavy_arm() -> None:
    robot = ec.load_robot("kuka-kr270")
    sizes = {n: Size(1.0, "") for n in ("foot turning", "tilt A3", "tool sliding")}
    foot, x, y, xy, tool, *_ = places_of(robot, effects_of(robot, sizes).unknowns)
    assert (foot.behind, x.behind, tool.behind) == ("", "A3", "A6")
    assert [p.slides for p in (foot, x, tool)] == [False, False, True]
    np.testing.assert_allclose(x.origin, [1.6, 0.0, 0.75], atol=1e-12)
    assert len(foot.axes) == 2
    assert len(xy.axes) == 3
    axis = robot.joints[2].axis
    np.testing.assert_allclose(np.concatenate([x.axes, y.axes, xy.axes]) @ axis, 0.0, atol=1e-12)
