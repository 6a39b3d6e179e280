"""Load cases that differ in nothing but the margins of a joint."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import elastocal as ec
from elastocal.files.study.study_file import parse_study
from elastocal.planning.symmetry import same_worth

ONE_JOINT = """\
elastocal: 1
robot: {convention: modified, dh: [{joint: J1, limits_deg: [-170, 170]}]}
identify: [J1]
tools: {tip: {tcp_mm: [800, 0, 0], load_point_mm: [800, 0, 0], markers_mm: {M: [800, 0, 0]}}}
test_poses: [{name: a, tool: tip, q_deg: [10], force_N: [0, 100, 0]}]
experiments: {tool: tip, max_force_N: 200, direction: free, count: 3}
instrument: {sigma_mm: .02}
"""


def test_an_arm_that_cannot_touch_itself_has_as_much_room_turned() -> None:
    """Its clearance leaves infinite room; the control is the same load, not turned."""
    space = parse_study(ONE_JOINT, Path("study.yaml")).space
    turn = np.radians(90.0)
    at = ec.LoadCases(np.zeros((1, 1)), np.array([[0.0, 200, 0, 0, 0, 0]]))
    turned = ec.LoadCases(np.full((1, 1), turn), np.array([[-200.0, 0, 0, 0, 0, 0]]))
    assert same_worth(space, at, turned, 0)
    assert not same_worth(space, at, ec.LoadCases(turned.q, at.wrench), 0)
