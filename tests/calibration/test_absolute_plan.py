"""Plans for absolute readings: what they are worth is what a fit to such readings would know."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.calibration.arm_model import State
from elastocal.calibration.calibrate import calibrate
from elastocal.calibration.prediction import predicted
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import StudyError
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.files.study.study_file import read_study
from elastocal.measuring.positions import Positions
from elastocal.planning.assessment import assess
from elastocal.planning.certificate import lower_bound
from elastocal.programs.campaign_program import campaign_program
from elastocal.programs.robot_program import Ask, Measure
from elastocal.study.absolute import arm_model, unknowns_of

STUDY = """\
elastocal: 1
robot:
  name: scara
  convention: classic
  dh:
    - {joint: A1, d_mm: 400, a_mm: 300, mass_kg: 20, limits_deg: [-150, 150]}
    - {joint: A2, a_mm: 250, alpha_deg: 90, mass_kg: 10, limits_deg: [-120, 120]}
    - {joint: A3, d_mm: 100, mass_kg: 4, limits_deg: [-100, 100]}
identify: [base, tool, geometry, A1, A2, A3]
tools:
  balls: {tcp_mm: [150, 0, 60], markers_mm: {T1: [150, 0, 60], T2: [0, 80, 60]}}
payloads:
  weight: {mass_kg: 30, center_mm: [50, 0, 60]}
experiments: {tool: balls, payload: [none, weight], count: 14}
instrument: {sigma_mm: 0.03}
gravity_m_s2: [3.0, 0.0, -9.3]
test_poses:
  - {q_deg: [10, 40, -20], force_N: [0, 60, -100]}
  - {q_deg: [-60, 80, 30]}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "study.yaml"
    path.write_text(STUDY, encoding="utf-8")
    return path


NUISANCE = """\
nuisance: {foot_turning_nrad_per_Nm: 900, foot_sliding_nm_per_N: 300, tilt_nrad_per_Nm: {A2: 800}}
"""
COMPENSATORS = """\
compensators:
  gas: {joint: A2, crank_mm: 150, reach_mm: 500, angle_deg: 20, rest_mm: 300}
"""


@pytest.mark.parametrize("besides", ["", NUISANCE, COMPENSATORS])
def test_a_plan_is_worth_what_a_fit_to_its_readings_would_know(file: Path, besides: str) -> None:
    """The fit keeps all unknowns, also those that do the same, with their priors."""
    text = STUDY.replace("A2, A3]", "A2, A3, compensator]") if "gas" in besides else STUDY
    file.write_text(text + besides, encoding="utf-8")
    study, absolute = read_study(file), read_absolute_study(file)
    rng = np.random.default_rng(2)
    cases = study.space.load_cases(study.space.sample(14, rng))
    worth = assess(study, cases, np.ones(14, dtype=np.int64))

    model = arm_model(absolute)
    hung = np.where(cases.wrench.any(axis=1), 0, -1)
    test = [pose.cases for pose in study.test_poses]
    at = Positions(
        absolute.tool,
        LoadCases(np.vstack([cases.q, *(t.q for t in test if t)]), np.zeros((16, 6))),
        tuple(str(i) for i in range(16)),
        np.repeat(np.arange(16), 2),
        np.tile([0, 1], 16),
        np.zeros((32, 3)),
        np.tile(study.sigma**2 * np.eye(3), (32, 1, 1)),
        np.zeros(32),
        payload=np.append(hung, [-1, -1]),
        payloads=("weight",),
    )
    wrench = np.zeros((16, 6))
    wrench[14:] = np.vstack([t.wrench for t in test if t])
    at = replace(at, cases=LoadCases(at.cases.q, wrench))
    parameters = unknowns_of(absolute, model, at)
    state = State(
        np.eye(4)[None],
        np.asarray(absolute.tool.markers)[None],
        np.eye(3)[None],
        np.zeros(len(model.errors)),
        np.zeros(len(model.compliances)),
        np.array([[30.0, 1.5, 0.0, 1.8]]),
        np.zeros(len(model.compensators)),
    )
    rows = predicted(model, at, parameters, state).rows
    read = rows[:28].reshape(-1, len(parameters)) / study.sigma
    information = read.T @ read + parameters.rows.T @ parameters.rows
    information[parameters.of("base"), parameters.of("base")] += 1e-2  # 10 m
    scale = 1.0 / np.sqrt(np.diagonal(information))
    covariance = np.linalg.inv(information * np.outer(scale, scale)) * np.outer(scale, scale)
    for i, rho in enumerate(worth.rho0_each):
        own = rows[28 + 2 * i]  # the TCP is the first reflector
        assert rho == pytest.approx(np.sqrt(np.trace(own @ covariance @ own.T)), rel=1e-3)


def test_nuisance_and_compensators_make_a_plan_worth_less(file: Path) -> None:
    rho0, rng = [], np.random.default_rng(5)
    x = read_study(file).space.sample(14, rng)
    for besides in ("", NUISANCE, COMPENSATORS):
        text = STUDY.replace("A2, A3]", "A2, A3, compensator]") if "gas" in besides else STUDY
        file.write_text(text + besides, encoding="utf-8")
        study = read_study(file)
        worth = assess(study, study.space.load_cases(x), np.ones(14, dtype=np.int64))
        assert len(worth.standard_error) == len(study.springs)
        rho0.append(worth.rho0)
    assert rho0[1] > 1.01 * rho0[0]
    assert rho0[2] > 1.0001 * rho0[0]


def test_errors_of_load_cases_are_refused(file: Path) -> None:
    file.write_text(f"{STUDY}nuisance: {{friction: 0.1}}\n", encoding="utf-8")
    with pytest.raises(StudyError, match="errors of loads are not for absolute readings"):
        read_study(file)


def test_what_does_the_same_is_left_out_but_for_one(file: Path) -> None:
    study = read_study(file)
    names = study.springs.names
    assert "base x" in names
    assert "zero A1" not in names  # a turn of the base does the same
    assert "zero A2" in names
    assert {"A1", "A2", "A3", "T1 x", "T2 z"} <= set(names)
    assert np.linalg.eigvalsh(study.prior)[0] > 0.0


def test_no_plan_is_better_than_its_bound(file: Path) -> None:
    study, rng = read_study(file), np.random.default_rng(3)
    bound = lower_bound(study, rng)
    best = min(
        assess(study, study.space.load_cases(study.space.sample(14, rng)), np.ones(14, int)).rho0
        for _ in range(40)
    )
    assert bound.loss(14) < best
    # The design measures with the weight and without.
    heavy = bound.design.x[:, -1] if bound.design else np.zeros(0)
    assert set(np.unique(heavy)) == {0.0, 1.0}


def test_programs_measure_every_pose_once_under_what_it_carries(file: Path) -> None:
    study, rng = read_study(file), np.random.default_rng(4)
    x = study.space.sample(6, rng)
    x[:3, -1], x[3:, -1] = 0.0, 1.0
    program = campaign_program(study, study.space.load_cases(x), np.ones(6, dtype=np.int64))
    measured = [step for step in program.steps if isinstance(step, Measure)]
    assert [step.loaded for step in measured] == [False] * 3 + [True] * 3
    asked = [step.text for step in program.steps if isinstance(step, Ask)]
    assert asked == ["Mount the payload of 30 kg on the flange. The robot moves next."]


def test_nothing_to_bend_a_joint_is_said(file: Path) -> None:
    light = STUDY
    for mass in (20, 10, 4):
        light = light.replace(f", mass_kg: {mass}", "")
    light = light.replace("payload: [none, weight], ", "")
    file.write_text(light, encoding="utf-8")
    with pytest.raises(StudyError, match="nothing bends it"):
        read_study(file)


def test_a_fit_needs_no_plan(file: Path) -> None:
    bare = STUDY[: STUDY.index("test_poses")].replace(", count: 14", "")
    file.write_text(bare, encoding="utf-8")
    assert read_absolute_study(file).blocks
    with pytest.raises(StudyError, match="to plan, key 'count' is missing"):
        read_study(file)
    assert calibrate
