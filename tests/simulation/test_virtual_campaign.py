"""Virtual campaigns: the truth in them, the noise on them, and the same seed giving the same."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.deflections import loaded_deflection, markers_at
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection
from elastocal.elastic.springs import joint_springs
from elastocal.errors import EquilibriumError, InputError
from elastocal.files.models.model_file import read_model
from elastocal.files.study.study_file import read_study
from elastocal.measuring.instrument import Isotropic, LaserTracker
from elastocal.simulation.virtual_campaign import (
    LoadError,
    Outliers,
    Reality,
    disturbed,
    noise,
    simulate,
)
from elastocal.study.study import Study
from tests.paper.published import TABLE_5

FOLDER = Path(__file__).parents[2] / "examples" / "kr270"


@pytest.fixture(scope="module")
def study() -> Study:
    return read_study(FOLDER / "study.yaml")


@pytest.fixture(scope="module")
def truth(study: Study) -> ComplianceModel:
    return read_model(FOLDER / "truth.json", study.robot)


@pytest.fixture(scope="module")
def cases() -> LoadCases:
    q = np.radians([[0.0, *row] for row in TABLE_5[3]])
    return LoadCases(q, np.tile([0.0, 0, -2500, 0, 0, 0], (3, 1)))


REPEATS = np.array([4, 1, 3])


def exact(study: Study) -> Study:
    """The study with an instrument next to perfect."""
    return replace(study, instrument=Isotropic(1e-15))


def test_without_noise_the_readings_are_the_equilibrium(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    """All springs of the truth bend, also those that the study does not identify."""
    made = simulate(exact(study), truth, cases, REPEATS, np.random.default_rng(0))
    arm = ElasticArm(study.robot, truth.springs, study.experiments.tool)
    expected = loaded_deflection(arm, truth.compliance, cases)
    order = [0, 0, 0, 0, 1, 2, 2, 2]
    np.testing.assert_allclose(made.deflection, expected[order], atol=1e-14)
    np.testing.assert_array_equal(made.cases.q, cases.q[order])
    assert made.names == tuple("12345678")


def test_the_linear_truth_is_the_regressor(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    once, rng = np.ones(3, dtype=int), np.random.default_rng(0)
    made = simulate(exact(study), truth, cases, once, rng, reality=Reality(linear=True))
    rows = deflection(replace(study.arm, springs=truth.springs), truth.compliance, cases)
    np.testing.assert_allclose(made.deflection, rows[:, :3], atol=1e-14)


def test_every_repeat_has_noise_of_its_own(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    made = simulate(study, truth, cases, np.array([4000, 0, 0]), np.random.default_rng(1))
    scatter = np.cov(made.deflection.T)
    # Each entry of the sample covariance is within 4 of its standard deviations, √(2/4000).
    np.testing.assert_allclose(scatter / 0.03e-3**2, np.eye(3), atol=4 * np.sqrt(2 / 4000))
    np.testing.assert_array_equal(
        made.covariance, np.tile(study.sigma**2 * np.eye(3), (4000, 1, 1))
    )


def test_a_tracker_is_noisier_across_its_beam(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    tracker = LaserTracker(np.array([4.0, 1.0, 1.0]), 2e-6, 0.2e-6, 15e-6, 6e-6)
    made = simulate(
        replace(study, instrument=tracker),
        truth,
        cases,
        np.array([4000, 0, 0]),
        np.random.default_rng(2),
    )
    arm = ElasticArm(study.robot, truth.springs, study.experiments.tool)
    beam = markers_at(arm, cases.q[:1], np.zeros((1, 6)))[0] - tracker.position
    along = made.deflection @ beam / np.linalg.norm(beam)
    near, _ = tracker.deviations(np.linalg.norm(beam))
    assert np.std(along) == pytest.approx(np.sqrt(2) * near, rel=4 / np.sqrt(2 * 4000))
    root = np.linalg.cholesky(made.covariance[0])
    white = np.cov(np.linalg.solve(root, made.deflection.T))
    np.testing.assert_allclose(white, np.eye(3), atol=4 * np.sqrt(2 / 4000))


def test_several_markers_are_several_readings(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    tool = replace(
        study.experiments.tool, markers=np.diag([0.3, 0.4, 0.5]), marker_names=("a", "b", "c")
    )
    wide = replace(study, experiments=replace(study.experiments, tool=tool))
    made = simulate(wide, truth, cases, REPEATS, np.random.default_rng(0))
    assert len(made) == 24
    np.testing.assert_array_equal(made.marker[:6], [0, 1, 2, 0, 1, 2])
    np.testing.assert_array_equal(made.case[:6], [0, 0, 0, 1, 1, 1])
    arm = ElasticArm(study.robot, truth.springs, tool)
    expected = loaded_deflection(arm, truth.compliance, cases)[2].reshape(3, 3)
    np.testing.assert_allclose(made.deflection[-3:], expected, atol=6 * 0.03e-3)


def test_load_errors_change_the_load_and_nothing_else(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    """Same noise with and without; what is recorded stays what was ordered."""
    plain = simulate(study, truth, cases, REPEATS, np.random.default_rng(5))
    off = simulate(
        study,
        truth,
        cases,
        REPEATS,
        np.random.default_rng(5),
        reality=Reality(LoadError(0.01, 0.0)),
    )
    np.testing.assert_array_equal(off.cases.wrench, plain.cases.wrench)
    change = off.deflection - plain.deflection
    arm = ElasticArm(study.robot, truth.springs, study.experiments.tool)
    sag = loaded_deflection(arm, truth.compliance, plain.cases)
    share = np.sum(change * sag, axis=1) / np.sum(sag * sag, axis=1)
    assert 1e-4 < np.abs(share).max() < 0.04
    np.testing.assert_allclose(change, share[:, None] * sag, atol=0.02 * np.abs(change).max())


def test_disturbed_wrenches_have_the_spread_that_is_asked_for() -> None:
    wrench = np.tile([0.0, 0.0, -2000.0, 0.0, 30.0, 0.0], (20000, 1))
    made = disturbed(wrench, LoadError(0.01, np.radians(0.5)), np.random.default_rng(0))
    size = np.linalg.norm(made[:, :3], axis=1)
    assert np.std(size / 2000.0) == pytest.approx(0.01, rel=0.03)
    for axis in (0, 1):
        assert np.std(made[:, axis] / size) == pytest.approx(np.radians(0.5), rel=0.03)
    # Force and moment stay at right angles and in proportion.
    np.testing.assert_allclose(np.sum(made[:, :3] * made[:, 3:], axis=1), 0.0, atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(made[:, 3:], axis=1), size * 0.015, rtol=1e-12)


def test_a_moment_does_not_turn_about_the_force() -> None:
    """Two tilts across the force turn it about itself only in second order: σ²/2, not σ."""
    wrench = np.tile([0.0, 0.0, -2000.0, 0.0, 30.0, 0.0], (20000, 1))
    sigma = 0.02
    made = disturbed(wrench, LoadError(0.0, sigma), np.random.default_rng(0))
    aside = made[:, 3] / 30.0
    assert np.std(aside) == pytest.approx(sigma**2 / 2.0, rel=0.05)
    # Only a moment, along an odd direction: it is the moment that tilts, alike both ways.
    alone = np.tile([0.0, 0.0, 0.0, 3.0, 0.0, 4.0], (20000, 1))
    made = disturbed(alone, LoadError(0.0, sigma), np.random.default_rng(1))[:, 3:] / 5.0
    for across in ([0.8, 0.0, -0.6], [0.0, 1.0, 0.0]):
        assert np.std(made @ across) == pytest.approx(sigma, rel=0.03)


def test_a_share_of_the_readings_is_grossly_wrong(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    many = np.array([1000, 0, 0])
    plain = simulate(study, truth, cases, many, np.random.default_rng(5))
    odd = simulate(
        study,
        truth,
        cases,
        many,
        np.random.default_rng(5),
        reality=Reality(outliers=Outliers(0.1, 2e-3)),
    )
    change = np.linalg.norm(odd.deflection - plain.deflection, axis=1)
    wrong = change > 0.0
    np.testing.assert_allclose(change[wrong], 2e-3, rtol=1e-9)
    assert abs(wrong.sum() - 100) < 4 * np.sqrt(90)


def test_the_same_seed_gives_the_same_campaign(
    study: Study, truth: ComplianceModel, cases: LoadCases
) -> None:
    one, two, other = (
        simulate(study, truth, cases, REPEATS, np.random.default_rng(seed)).deflection
        for seed in (7, 7, 8)
    )
    np.testing.assert_array_equal(one, two)
    assert not np.any(one == other)


def test_what_cannot_be_is_refused(study: Study, truth: ComplianceModel, cases: LoadCases) -> None:
    rng = np.random.default_rng(0)
    soft = replace(truth, compliance=1e3 * truth.compliance)
    with pytest.raises(EquilibriumError, match="load case 1 has no stable equilibrium"):
        simulate(study, soft, cases, REPEATS, rng)
    wrong = ComplianceModel(joint_springs(study.robot, ["A3"]), np.array([-1e-7]))
    with pytest.raises(InputError, match="compliance of A3 is negative"):
        simulate(study, wrong, cases, REPEATS, rng)
    for bad in (-0.1, 1.0, np.nan):
        with pytest.raises(InputError, match="load error: size"):
            LoadError(size=bad)
    with pytest.raises(InputError, match="outliers: share"):
        Outliers(1.5, 1e-3)
    with pytest.raises(InputError, match="outliers: size"):
        Outliers(0.5, np.inf)


def test_noise_of_no_experiments_is_empty() -> None:
    covariance = np.tile(np.eye(3), (2, 1, 1, 1))
    assert noise(covariance, np.array([], dtype=int), np.random.default_rng(0)).shape == (0, 1, 3)
