"""What remains along a path, what is expected, and what is doubted, by hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from elastocal.compensation.compensate import Compensation, compensate, mirrored
from elastocal.compensation.remaining import alarms, as_expected, doubts_of_path, rms
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from tests.kr270 import kr270_study, kr270_truth, published_cases


@cache
def path() -> Compensation:
    """Four points; the model is known but for a tenth."""
    study = kr270_study()
    truth = kr270_truth(study)
    model = ComplianceModel(
        truth.springs, truth.compliance, covariance=np.diag((0.1 * truth.compliance) ** 2)
    )
    cases: LoadCases = published_cases(4)
    return compensate(replace(study.arm, springs=model.springs), model, cases)


def test_root_mean_square_leaves_out_what_is_not_known() -> None:
    error = np.array([[3.0, 0.0, 4.0], [np.nan, 0.0, 0.0], [0.0, 1.0, 0.0]])
    assert rms(error) == pytest.approx(np.sqrt(13.0))
    assert rms(np.array([5.0, np.nan, 1.0])) == pytest.approx(np.sqrt(13.0))
    assert np.isnan(rms(np.array([np.nan])))


def test_expected_is_of_the_uncertain_model_and_of_the_rule() -> None:
    after = np.zeros((4, 3))
    after[2] = [0.0, 3e-4, -4e-4]
    done = replace(path(), after=after)
    np.testing.assert_allclose(done.expected[[0, 1, 3]], done.rho0[[0, 1, 3]])
    assert done.expected[2] == pytest.approx(np.hypot(done.rho0[2], 5e-4))


def test_points_as_expected_are_within_twice_the_expected_error() -> None:
    sizes = path().expected * [1.99, 2.01, np.nan, 0.0]
    judged = sizes[:, None] * np.array([0.0, 0.6, 0.8])
    assert as_expected(path(), judged) == (2, 3)


def test_doubts_of_a_path() -> None:
    done = replace(path(), notes=())
    assert doubts_of_path(done) == ()
    one = done.expected[:, None] * np.array([0.0, 0.6, 0.8])
    assert doubts_of_path(done, 1.99 * one) == ()
    (doubt,) = doubts_of_path(done, 2.01 * one)
    assert doubt.code == "more-than-expected"
    assert doubt.numbers["remaining"] == pytest.approx(2.01 * doubt.numbers["expected"])
    near = replace(
        done,
        damped=np.array([True, True, False, True]),
        converged=np.array([True, False, True, True]),
    )
    (doubt,) = doubts_of_path(near)
    assert (doubt.code, doubt.numbers["points"]) == ("points-nearly-singular", 2)


def test_alarms_count_points() -> None:
    assert alarms(path()) == ()
    q = path().q.copy()
    q[1, 0] = 1e3
    broken = replace(path(), q=q, converged=np.array([False, True, True, False]))
    told = [(doubt.code, dict(doubt.numbers)) for doubt in alarms(broken)]
    assert told == [
        ("points-lost", {"points": 2, "all": 4}),
        ("points-beyond-limits", {"points": 1, "all": 4}),
    ]


def test_the_mirrored_correction_goes_to_the_wrong_side() -> None:
    wrong = mirrored(path())
    np.testing.assert_allclose(wrong.q + path().q, 2.0 * path().cases.q)
