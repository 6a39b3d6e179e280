"""Subjects for the tests of the live view."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from elastocal.files.study.study_file import parse_study, read_study
from elastocal.viewer.subject import Subject, stops_of
from tests.kr270 import kr270_study, kr270_truth, published_cases

ROBOTS = Path(__file__).parents[2] / "examples" / "robots"

TRACKED = """elastocal: 1
robot: kuka-kr270
identify: [A2, A3, A4, A5, A6]
tools:
  calibration:
    load_point_mm: [611.5, 0, -460]
    markers_mm: {M1: [611.5, 0, -460], M2: [300, 200, 0]}
    marker_axes: {M1: x}
    acceptance_deg: 40
test_poses:
  - {name: <b>, tool: calibration, q_deg: [0, -57, 89, 45, 76, 57], force_N: [0, 280, -180]}
experiments: {tool: calibration, force_N: [0, 0, -2500], count: 12}
instrument:
  tracker: {position_mm: [4500, 0, 1500], preset: leica-at500, line_of_sight: false}
constraints:
  workspace: {min_z_mm: 500}
  obstacles: [{name: table, box_mm: [800, 800, 200], center_mm: [2000, 0, 100]}]
  collision: {self: false}
  floor: off
"""


@cache
def kr270() -> Subject:
    """The three configurations of the paper, with compliances."""
    study = kr270_study()
    stops = stops_of(study, published_cases(3), np.array([4, 4, 4]))
    return Subject(study, stops, kr270_truth(study))


@cache
def tracked() -> Subject:
    """The same robot before a laser tracker, beside a table, without plan and compliances."""
    study = parse_study(TRACKED, Path("tracked.yaml"))
    return Subject(study, stops_of(study))


@cache
def example(name: str) -> Subject:
    """A robot of the examples from its file, without plan and compliances."""
    study = read_study(ROBOTS / name / "study.yaml")
    return Subject(study, stops_of(study))


def rigid(subject: Subject) -> Subject:
    """The same without compliances."""
    return replace(subject, model=None)
