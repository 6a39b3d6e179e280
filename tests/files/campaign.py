"""A small campaign with two markers, and files that belong to it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastocal.elastic.load_cases import LoadCases
from elastocal.files.study.study_file import parse_study
from elastocal.measuring.measurements import Measurements
from elastocal.study.study import Study

STUDY_TEXT = """\
elastocal: 1
robot: kuka-kr270
identify: [A2, A3, A4, A5, A6]
tools:
  milling: {tcp_mm: [986, 0, 0]}
  plate: {load_point_mm: [611.5, 0, -460], markers_mm: {M1: [611.5, 0, -460], M2: [500, 150, -300]}}
test_poses:
  - {tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}
experiments: {tool: plate, force_N: [0, 0, -2500], count: 3}
instrument: {sigma_mm: 0.03}
constraints: {collision: off, floor: off}
"""
JOINTS = tuple(f"A{i}" for i in range(1, 7))


def study(text: str = STUDY_TEXT) -> Study:
    return parse_study(text, Path("study.yaml"))


def measurements(count: int, rng: np.random.Generator, *, own: int = 0) -> Measurements:
    """A campaign of random numbers with few digits; own: 0 none, 1 u, 3 ux.., 6 full."""
    what = study()
    tool = what.experiments.tool
    q = np.round(rng.uniform(what.limits[0], what.limits[1], (count, 6)), 3)
    wrench = np.zeros((count, 6))
    wrench[:, 2] = -2500.0
    wrench[:, 0] = np.round(rng.normal(0.0, 10.0, count), 2)
    if own == 6:
        wrench[:, 3:] = np.round(rng.normal(0.0, 10.0, (count, 3)), 2)
    case = np.repeat(np.arange(count), 2)
    marker = np.tile([0, 1], count)
    root = 1e-5 * (np.eye(3) + 0.1 * rng.normal(size=(2 * count, 3, 3)))
    full = root @ root.transpose(0, 2, 1)
    variance = np.einsum("rii->ri", full)
    covariance = {
        0: np.broadcast_to(what.sigma**2 * np.eye(3), full.shape),
        1: variance[:, :1, None] * np.eye(3),
        3: variance[:, :, None] * np.eye(3),
        6: full,
    }[own]
    return Measurements(
        tool,
        LoadCases(q, wrench),
        tuple(f"E{i + 1}" for i in range(count)),
        case,
        marker,
        np.round(rng.normal(0.0, 1e-3, (2 * count, 3)), 8),
        covariance,
        own_uncertainty=own > 0,
    )
