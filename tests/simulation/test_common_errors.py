"""Errors that the readings of a pose share: read from a file, planned, simulated, fitted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
from elastocal.files.study.study_file import parse_study
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.search import searched
from elastocal.identification.validation import validate
from elastocal.measuring.common_errors import CommonErrors
from elastocal.measuring.instrument import Isotropic, PoseProbe
from elastocal.robot.posture import Posture
from elastocal.simulation.monte_carlo import campaigns
from elastocal.simulation.virtual_campaign import simulate
from elastocal.study.study import Study
from elastocal.terminal.studies import instrument_phrase
from tests.kr270 import kr270_study, kr270_truth

TEXT = """\
elastocal: 1
robot: kuka-kr270
identify: [A2, A3, A4, A5, A6]
tools:
  milling: {tcp_mm: [986, 0, 0]}
  calibration:
    load_point_mm: [611.5, 0, -460]
    markers_mm: {M1: [611.5, 0, -460], M2: [611.5, 0, 460], M3: [300, 400, 0]}
test_poses:
  - {name: milling, tool: milling, q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2], force_N: [0, 280, -180]}
experiments: {tool: calibration, count: 6, force_N: [0, 0, -2500]}
instrument: {sigma_mm: .02, common_mm: .06, common_mrad: .05}
constraints: {collision: off, floor: off}
"""


@pytest.fixture(scope="module")
def study() -> Study:
    return parse_study(TEXT, Path("common.yaml"))


def cases_of(study: Study) -> LoadCases:
    return study.space.load_cases(study.space.sample(4, np.random.default_rng(2)))


REPEATS = np.array([2, 1, 2, 1])


def test_the_keys_of_the_file(study: Study) -> None:
    instrument = study.instrument
    assert isinstance(instrument, CommonErrors)
    assert isinstance(instrument.own, Isotropic)
    sizes = instrument.own.sigma, instrument.translation, instrument.rotation
    assert sizes == pytest.approx((2e-5, 6e-5, 5e-5))
    assert instrument_phrase(instrument) == (
        "σ = 0.02 mm per coordinate; 0.06 mm and 0.05 mrad common to the readings of a pose"
    )
    probe = TEXT.replace("common_mm: .06,", "measures: pose, sigma_mrad: .1,")
    found = parse_study(probe, Path("common.yaml")).instrument
    assert isinstance(found, CommonErrors)
    assert isinstance(found.own, PoseProbe)
    assert found.translation == 0.0
    assert found.sigma_rotation == pytest.approx(np.hypot(1e-4, 5e-5))


def whole(study: Study, cases: LoadCases) -> np.ndarray:
    """(N, 9, 9) covariance of what is read of each load case, written out."""
    found = []
    for q in cases.q:
        posture = Posture(study.robot, q[None])
        points = np.array([posture.point(m)[:, 0] for m in study.experiments.tool.markers])
        x = points - points.mean(axis=0)
        turned = [[[0, c, -b], [-c, 0, a], [b, -a, 0]] for a, b, c in x]
        columns = np.hstack([6e-5 * np.vstack([np.eye(3)] * 3), 5e-5 * np.vstack(turned)])
        found.append(4e-10 * np.eye(9) + columns @ columns.T)
    return np.array(found)


def test_the_fit_weighs_what_a_pose_shares(study: Study, tmp_path: Path) -> None:
    """Generalised least squares by normal equations; the file brings everything back."""
    truth = kr270_truth(study)
    cases = cases_of(study)
    data = simulate(study, truth, cases, REPEATS, np.random.default_rng(4))
    write_measurements(data, study.robot, tmp_path / "read.csv")
    read = read_measurements(tmp_path / "read.csv", study)
    np.testing.assert_allclose(read.common, data.common, atol=1e-12)
    np.testing.assert_allclose(read.covariance, data.covariance, rtol=1e-6)
    found = identify(study.arm, read, Fit("linear"))
    each = np.repeat(np.arange(4), REPEATS)
    inverse = np.linalg.inv(whole(study, cases))[each]
    rows = regressor(study.arm, cases)[each]
    information = np.einsum("nri,nrs,nsj->ij", rows, inverse, rows)
    values = read.deflection.reshape(6, 9)
    estimate = np.linalg.solve(information, np.einsum("nri,nrs,ns->i", rows, inverse, values))
    np.testing.assert_allclose(found.compliance, estimate, rtol=1e-6)
    np.testing.assert_allclose(found.model.covariance, np.linalg.inv(information), rtol=1e-6)
    left = values - rows @ estimate
    square = np.einsum("nr,nrs,ns->", left, inverse, left)
    assert found.chi_square == pytest.approx(square, rel=1e-6)
    # The plan says the same, and a validation squares errors the same way.
    told = np.einsum("n,nij->ij", REPEATS, study.space.information(cases))
    np.testing.assert_allclose(told, information, rtol=1e-9)
    exact = ComplianceModel(study.springs, found.compliance)
    far = validate(study.arm, exact, read)
    after = far.after.reshape(6, 9)
    square = np.einsum("nr,nrs,ns->", after, inverse, after)
    assert far.chi_square == pytest.approx(square, rel=1e-6)


def test_nothing_else_is_found_where_nothing_is_missing(study: Study) -> None:
    """The search goes through readings that share errors; turned signs are found in them, too."""
    cases = study.space.load_cases(study.space.sample(12, np.random.default_rng(2)))
    once = np.ones(12, dtype=np.int64)
    data = simulate(study, kr270_truth(study), cases, once, np.random.default_rng(4))
    beyond = searched(identify(study.arm, data), study.coupling)
    assert beyond.convention is None
    assert beyond.lacks is not None
    assert not beyond.lacks.missing
    signs = np.array([1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
    wrong = replace(data, cases=LoadCases(cases.q * signs, cases.wrench))
    assert searched(identify(study.arm, wrong), study.coupling).convention is not None


def test_experiments_with_one_unloaded_reading_share_half_of_it(study: Study) -> None:
    """What the unloaded pose had in common is in both deflections."""
    truth, cases = kr270_truth(study), cases_of(study)
    data = simulate(study, truth, cases, REPEATS, np.random.default_rng(4))
    place = data.cases.distinct[data.case] * 3 + data.marker
    shared = replace(data, unloaded_of=place)
    found = identify(study.arm, shared, Fit("linear"))
    rows, total = [], np.zeros((54, 54))
    each = np.repeat(np.arange(4), REPEATS)
    rows = regressor(study.arm, cases)[each].reshape(54, -1)
    one = whole(study, cases)[each]
    for i in range(6):
        for j in range(6):
            half = 1.0 if i == j else 0.5 * (each[i] == each[j])
            total[9 * i : 9 * i + 9, 9 * j : 9 * j + 9] = half * one[i]
    information = rows.T @ np.linalg.solve(total, rows)
    np.testing.assert_allclose(found.model.covariance, np.linalg.inv(information), rtol=1e-6)


def test_many_campaigns_keep_their_word(study: Study) -> None:
    found = campaigns(study, kr270_truth(study), {"plan": (cases_of(study), REPEATS)}, 800, seed=1)
    (one,) = found.plans
    assert np.abs(one.coverage - 0.95).max() < 0.02
    assert one.rms / one.rho0 == pytest.approx(1.0, abs=0.05)
    assert one.likelihood_ratio()[1] > 0.01
    estimated = campaigns(
        study, kr270_truth(study), {"plan": (cases_of(study), REPEATS)}, 800, seed=1,
        how=Fit(sigma="estimated"),
    )  # fmt: skip
    assert np.abs(estimated.plans[0].coverage - 0.95).max() < 0.02
    # One by one they are what the batch says.
    data = simulate(study, kr270_truth(study), cases_of(study), REPEATS, np.random.default_rng(4))
    alone = identify(study.arm, data)
    np.testing.assert_allclose(
        np.diagonal(alone.model.covariance), np.diagonal(one.covariance), rtol=0.05
    )


def test_what_a_pose_shares_hides_nothing_that_turns_the_tool() -> None:
    """One marker: the common translation is noise like any other."""
    plain = kr270_study()
    one = replace(plain, instrument=CommonErrors(Isotropic(3e-5), 4e-5))
    same = replace(plain, instrument=Isotropic(5e-5))
    cases = cases_of(plain)
    np.testing.assert_allclose(
        one.space.information(cases), same.space.information(cases), rtol=1e-9
    )
