"""A pose probe against markers around it: what both say of the compliances, in closed form.

Markers at m_k from a centre, each with noise σ, move by t + φ × m_k with the centre. If they are
balanced, Σ m_k = 0, they tell of t what one marker with noise σ/√K tells, and of φ

    Σ [m_k]ₓᵀ [m_k]ₓ / σ² = Σ (|m_k|² I - m_k m_kᵀ) / σ²
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.elastic.regressor import regressor
from elastocal.errors import InputError
from elastocal.measuring.instrument import (
    Instrument,
    Isotropic,
    LaserTracker,
    PoseProbe,
    tracker_of,
)
from elastocal.planning.assessment import assess
from elastocal.robot.posture import Posture, flange_axes
from elastocal.study.study import Study
from tests.kr270 import kr270_study, published_cases

SIGMA, REACH = 3e-5, 0.2
EQUAL = 1e-12


def measuring(study: Study, around: Array, instrument: Instrument) -> Study:
    """The study with markers at these places around that of its one marker."""
    tool = study.experiments.tool
    points = tool.markers[0] + around
    names = tuple(f"P{i + 1}" for i in range(len(points)))
    tool = replace(tool, markers=points, marker_names=names)
    return replace(study, experiments=replace(study.experiments, tool=tool), instrument=instrument)


def spread(information: Array, other: Array) -> float:
    """Largest difference over the diagonal."""
    scale = np.sqrt(np.einsum("nii->ni", other))
    return float(np.abs((information - other) / (scale[:, :, None] * scale[:, None, :])).max())


def test_six_markers_on_the_axes_are_a_pose_probe() -> None:
    """±d e_i: positions with σ/√6, rotations with σ/(2 d) about every axis."""
    study, cases = kr270_study(), published_cases(4)
    six = REACH * np.vstack([np.eye(3), -np.eye(3)])
    markers = measuring(study, six, Isotropic(SIGMA))
    probe = PoseProbe(Isotropic(SIGMA / np.sqrt(6.0)), SIGMA / (2.0 * REACH))
    pose = measuring(study, np.zeros((1, 3)), probe)
    found, expected = (s.space.information(cases) for s in (pose, markers))
    assert spread(found, expected) < EQUAL
    # ... and planned for they are the same study: rho0 alike.
    plan = (cases, np.array([3, 3, 3, 3]))
    assert assess(pose, *plan).rho0 == pytest.approx(assess(markers, *plan).rho0, rel=EQUAL)
    # Half the noise of the rotation is another probe: the comparison would see it.
    twice = PoseProbe(probe.points, probe.sigma_rotation / 2.0)
    assert spread(replace(pose, instrument=twice).space.information(cases), expected) > 0.1


def test_three_markers_in_a_triangle() -> None:
    """Equilateral, at d: σ/(d √(3/2)) about the axes in its plane, σ/(d √3) about its normal."""
    study, cases = kr270_study(), published_cases(4)
    turns = 2.0 * np.pi / 3.0 * np.arange(3)
    triangle = REACH * np.stack([np.cos(turns), np.sin(turns), 0.0 * turns], axis=1)
    markers = measuring(study, triangle, Isotropic(SIGMA))
    rows = regressor(study.arm, cases, rotation=True)
    flange = flange_axes(Posture(study.robot, cases.q))
    turned = flange.transpose(0, 2, 1) @ rows[:, 3:]  # in the frame of the triangle
    deviation = SIGMA / (REACH * np.sqrt([1.5, 1.5, 3.0]))
    white = np.concatenate(
        [rows[:, :3] * np.sqrt(3.0) / SIGMA, turned / deviation[:, None]], axis=1
    )
    expected = white.transpose(0, 2, 1) @ white
    assert spread(markers.space.information(cases), expected) < EQUAL


def test_markers_close_together_tell_nothing_of_the_rotation() -> None:
    """As d falls the pose probe of six markers loses its rotation, and is one marker."""
    study, cases = kr270_study(), published_cases(4)
    one = measuring(study, np.zeros((1, 3)), Isotropic(SIGMA)).space.information(cases)
    off = []
    for reach in (1e-2, 1e-3, 1e-4):
        probe = PoseProbe(Isotropic(SIGMA), SIGMA / (2.0 * reach))
        pose = measuring(study, np.zeros((1, 3)), probe).space.information(cases)
        off.append(spread(pose, one))
    assert off[0] > 1e-3
    assert off[1:] == pytest.approx([1e-2 * off[0], 1e-4 * off[0]], rel=1e-3)


def test_a_study_asks_its_tool_for_what_its_instrument_measures() -> None:
    study = kr270_study()
    assert not study.experiments.tool.rotation
    pose = replace(study, instrument=PoseProbe(Isotropic(SIGMA), 5e-5))
    assert pose.arm.tool.targets == ("M1", "rotation")
    assert pose.sigma == SIGMA
    back = replace(pose, instrument=Isotropic(SIGMA))
    assert back.arm.tool.targets == ("M1",)
    cases = published_cases(3)
    assert spread(back.space.information(cases), study.space.information(cases)) < EQUAL


def test_the_tracker_behind_a_probe() -> None:
    tracker = LaserTracker(np.array([3.0, 0.4, 1.2]), 5e-6, 1.5e-7, 7.5e-6, 3e-6)
    assert tracker_of(PoseProbe(tracker, 1e-4)) is tracker
    assert tracker_of(tracker) is tracker
    assert tracker_of(PoseProbe(Isotropic(1e-5), 1e-4)) is None


@pytest.mark.parametrize("sigma", [0.0, -1e-5, np.nan, np.inf])
def test_noise_of_a_rotation_is_a_positive_angle(sigma: float) -> None:
    with pytest.raises(InputError, match="sigma_rotation must be a positive angle"):
        PoseProbe(Isotropic(SIGMA), sigma)
    with pytest.raises(InputError, match="measures positions only"):
        PoseProbe(PoseProbe(Isotropic(SIGMA), 1e-4), 1e-4)
