"""Campaigns that measure poses keep their promises, and one whose noise is understated does not.

With K campaigns a coverage has the standard deviation √(0.95·0.05/K), 0.5 % here; seeds are fixed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.identification.batch import Design, fit_all
from elastocal.measuring.instrument import Isotropic, LaserTracker, PoseProbe
from elastocal.simulation.monte_carlo import campaigns
from elastocal.simulation.virtual_campaign import (
    Outliers,
    Reality,
    gross_errors,
    lever,
    noise,
    simulate,
    virtual_readings,
)
from elastocal.study.study import Study
from tests.kr270 import kr270_study, kr270_truth, published_cases

SIGMA, TURN, COUNT = 3e-5, 5e-5, 2000
STUDY = replace(kr270_study(), instrument=PoseProbe(Isotropic(SIGMA), TURN))
TRUTH = kr270_truth(STUDY)
TRACKED = replace(
    STUDY,
    instrument=PoseProbe(
        LaserTracker(np.array([4.0, 1.0, 1.0]), 2e-6, 0.2e-6, 15e-6, 6e-6), 2.0 * TURN
    ),
)
CASES, REPEATS = published_cases(4), np.array([3, 3, 3, 3])


@pytest.mark.parametrize("study", [STUDY, TRACKED], ids=["isotropic", "tracker"])
def test_intervals_and_rho0_keep_their_word(study: Study) -> None:
    """A nonlinear truth: 95 % intervals hold 94 to 96 %, the error left is ρ0 within 3 %."""
    found = campaigns(study, TRUTH, {"plan": (CASES, REPEATS)}, COUNT, seed=1).plans[0]
    assert np.abs(found.coverage - 0.95).max() < 0.0121  # 2.5 standard deviations
    assert np.abs(found.coverage.mean() - 0.95) < 0.005
    assert found.rms / found.rho0 == pytest.approx(1.0, abs=0.03)
    assert np.abs(found.bias).max() < 0.1
    assert found.likelihood_ratio()[1] > 0.01


def coverage(promised: PoseProbe, true: PoseProbe) -> Array:
    """Coverage of 95 % intervals where the fit is promised another noise than there is."""
    said, are = (
        virtual_readings(STUDY.arm, probe, TRUTH, CASES, linear=False) for probe in (promised, true)
    )
    case, rng = np.repeat(np.arange(4), REPEATS), np.random.default_rng(3)
    design = Design(
        said.arm, np.arange(1, 6), TRUTH.compliance, CASES, case, said.covariance, linear=False
    )
    many = np.tile(case, COUNT)
    readings = are.deflection[many] + noise(are.covariance, many, rng)
    fitted = fit_all(design, readings.reshape(COUNT, len(case), *readings.shape[1:]))
    error = np.sqrt(np.diagonal(fitted.covariance, axis1=1, axis2=2))
    inside = np.abs(fitted.compliance - TRUTH.compliance[1:]) <= 1.959964 * error
    return np.asarray(inside.mean(axis=0))


def test_noise_of_rotations_that_is_understated_is_found_out() -> None:
    """Twice the promised noise of the rotations: the intervals hold far too little."""
    assert STUDY.instrument.sigma_rotation == TURN
    probe = PoseProbe(Isotropic(SIGMA), TURN)
    assert np.abs(coverage(probe, probe) - 0.95).max() < 0.0121
    wrong = coverage(probe, replace(probe, sigma_rotation=2.0 * TURN))
    assert wrong.min() < 0.8
    assert wrong[1:].max() < 0.9  # A2 is told by positions


def test_a_virtual_pose_campaign_reads_positions_and_rotations() -> None:
    data = simulate(STUDY, TRUTH, CASES, REPEATS, np.random.default_rng(0))
    assert len(data) == 24
    assert data.rotations.tolist() == [False, True] * 12
    np.testing.assert_allclose(data.deviation[data.rotations], TURN)
    np.testing.assert_allclose(data.deviation[~data.rotations], SIGMA)
    # Positions alone of the same load cases are those of the study without the probe.
    alone = replace(STUDY, instrument=Isotropic(SIGMA))
    ideal = virtual_readings(alone.arm, alone.instrument, TRUTH, CASES, linear=False)
    both = virtual_readings(STUDY.arm, STUDY.instrument, TRUTH, CASES, linear=False)
    assert np.array_equal(ideal.deflection, both.deflection[:, :1])


def test_gross_errors_of_rotations_are_as_gross_as_those_of_positions() -> None:
    """As many standard deviations, whatever the units."""
    assert lever(STUDY.instrument) == pytest.approx(0.6)
    assert lever(Isotropic(SIGMA)) is None
    rng = np.random.default_rng(0)
    wrong = gross_errors((50, 2, 3), Outliers(1.0, 1e-3), rng, lever(STUDY.instrument))
    np.testing.assert_allclose(np.linalg.norm(wrong[:, 0], axis=1) / SIGMA, 1e-3 / SIGMA)
    np.testing.assert_allclose(np.linalg.norm(wrong[:, 1], axis=1) / TURN, 1e-3 / SIGMA)
    outlying = Reality(outliers=Outliers(0.3, 1e-3))
    data = simulate(STUDY, TRUTH, CASES, REPEATS, np.random.default_rng(0), reality=outlying)
    quiet = simulate(STUDY, TRUTH, CASES, REPEATS, np.random.default_rng(0))
    off = np.linalg.norm((data.deflection - quiet.deflection) / data.deviation, axis=1)
    assert 0 < (off > 0.0).sum() < 24
    np.testing.assert_allclose(off[off > 0.0], 1e-3 / SIGMA)
