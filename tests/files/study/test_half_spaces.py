"""Half-spaces of any normal in a study: what they ask, how they are named, what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from elastocal.constraints import HalfSpace, margins_at
from elastocal.drawing.stage import Stage
from elastocal.drawing.surfaces import wall
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError, StudyError
from elastocal.files.study.study_file import parse_study
from elastocal.planning.assessment import assess
from elastocal.robot.posture import Posture
from elastocal.study.study import Study
from elastocal.wording import worded
from tests.arms import central_difference

STUDY = """\
elastocal: 1
robot: kuka-kr270
identify: [A2, A3, A4, A5, A6]
tools:
  calibration: {load_point_mm: [611.5, 0, -460], markers_mm: {M1: [600, 0, 0], M2: [0, 200, 0]}}
test_poses:
  - {tool: calibration, q_deg: [0, -60, 90, 30, 60, 40], force_N: [0, 280, -180]}
experiments: {tool: calibration, force_N: [0, 0, -2500], count: 6}
instrument: {sigma_mm: 0.03}
constraints:
  collision: off
  floor: off
  workspace:
    half_spaces:
      - {name: fence, point_mm: [1500, 200, 0], normal: [-1, 2, 0.5]}
      - {name: "roof {1}", point_mm: [0, 0, 2600], normal: [0.1, 0, -1]}
"""


def study(old: str = "", new: str = "") -> Study:
    return parse_study(STUDY.replace(old, new), Path("study.yaml"))


def test_they_hold_for_every_marker_and_the_load_point() -> None:
    found = study()
    assert [constraint.name for constraint in found.constraints] == [
        f"distance of {point} from {plane} >= 0 mm"
        for point in ("M1", "M2", "load point")
        for plane in ("fence", "roof {1}")
    ]
    q = np.random.default_rng(0).uniform(*found.limits, (20, 6))
    posture = Posture(found.robot, q)
    tool = found.experiments.tool
    planes = (([1.5, 0.2, 0.0], [-1.0, 2.0, 0.5]), ([0.0, 0.0, 2.6], [0.1, 0.0, -1.0]))
    expected = [
        (np.array(normal) / np.linalg.norm(normal)) @ (posture.point(point).T - place).T
        for point in (*tool.markers, tool.load_point)
        for place, normal in planes
    ]
    assert margins_at(found.constraints, posture) == pytest.approx(np.array(expected), abs=1e-12)


def test_their_gradient_is_that_of_differences() -> None:
    found = study()
    q = np.random.default_rng(1).uniform(*found.limits, (5, 6))
    for constraint in found.constraints:
        _, pull = constraint.at(Posture(found.robot, q))
        expected = central_difference(lambda x, c=constraint: c.at(Posture(found.robot, x))[0], q)
        assert pytest.approx(expected, abs=1e-7) == pull(np.ones(5)).T


def test_random_load_cases_keep_them_and_what_breaks_them_is_said_in_mm() -> None:
    found = study()
    x = found.space.sample(500, np.random.default_rng(2))
    assert (margins_at(found.constraints, Posture(found.robot, x)) >= 0.0).all()
    outside = np.array([[0.9, -1.0, 1.2, 0.0, 0.5, 0.0]])
    depth = -margins_at(found.constraints, Posture(found.robot, outside))[:, 0]
    assert depth[0] > 0.1
    cases = LoadCases(outside, np.array([[0.0, 0, -2500, 0, 0, 0]]))
    said = [worded(doubt) for doubt in assess(found, cases, np.array([1])).violations]
    by = f"{1e3 * depth[0]:.0f} mm"
    assert said[0] == f"load case 1 breaks distance of M1 from fence >= 0 mm by {by}"


def test_they_are_drawn_where_they_stand() -> None:
    fence = study().constraints[0]
    assert isinstance(fence, HalfSpace)
    drawn = wall(fence, Stage((), (), (), np.full(3, -3.0), np.full(3, 3.0), 3.0))
    assert drawn is not None
    assert drawn.name == fence.name
    assert drawn.solid.vertices @ fence.normal == pytest.approx(fence.offset)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("normal: [-1, 2, 0.5]", "normal: [0, 0, 0]", "line 15: normal: an axis must not be zero"),
        ('"roof {1}"', "fence", "line 16: half-space 'fence' is there twice"),
        ("normal: [-1, 2, 0.5]", "normal: up", "line 15"),
        ("normal: [-1, 2, 0.5]", "normal: [1, 2]", "line 15"),
        ("point_mm: [1500, 200, 0], ", "", "line 15"),
        ("point_mm: [1500", "point: [1500", "line 15"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(old: str, new: str, words: str) -> None:
    with pytest.raises(StudyError) as error:
        study(old, new)
    assert words in str(error.value)


def test_a_normal_may_be_an_axis_of_the_base() -> None:
    upright = study("normal: [-1, 2, 0.5]", "normal: z").constraints[0]
    assert isinstance(upright, HalfSpace)
    assert (upright.normal.tolist(), upright.offset) == ([0.0, 0.0, 1.0], 0.0)


def test_two_that_leave_nothing_are_refused_by_name() -> None:
    beyond = study("point_mm: [1500, 200, 0]", "point_mm: [-9000, 9000, 0]")
    with pytest.raises(InfeasibleError, match=r"distance of .* from fence >= 0 mm"):
        beyond.space.sample(1, np.random.default_rng(0))
