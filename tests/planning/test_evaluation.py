"""Claims of a plan: which are held against it, and how exactly."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from elastocal.elastic.load_cases import LoadCases
from elastocal.files.plans.evaluation_document import evaluation_document
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.evaluation import Evaluation, evaluate
from elastocal.study.criteria import criterion_of
from elastocal.study.study import Study
from elastocal.wording import worded
from tests.paper.problems import three_link_study

REPEATS = np.array([2, 1, 3])


def study(criterion: str = "test-pose") -> Study:
    return replace(three_link_study(6), criterion=criterion)


@cache
def bound(criterion: str) -> Bound:
    return lower_bound(study(criterion), np.random.default_rng(0))


def judged(criterion: str = "test-pose", **claims: Any) -> Evaluation:
    q = np.array([[0.0, 0.4, 0.9], [0.3, -0.6, 1.2], [1.0, 0.2, -1.4]])
    force = np.array([[1.0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0.0]])
    return evaluate(study(criterion), LoadCases(q, force), REPEATS, claims, bound(criterion))


def test_load_cases_that_tell_the_same_are_said_but_no_objection() -> None:
    """The third turned about the first joint with its force, and the second with it reversed."""
    q = np.array([[0.0, 0.4, 0.9], [0.3, -0.6, 1.2], [1.0, 0.2, -1.4]])
    force = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0.6, 0.8]])
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    q = np.vstack([q, q[2] + [np.pi / 2.0, 0.0, 0.0], q[1]])
    force = np.vstack([force, turn @ force[2], -force[1]])
    cases = LoadCases(q, np.hstack([force, np.zeros((5, 3))]))
    found = evaluate(study(), cases, np.array([1, 2, 1, 1, 1]), {}, bound("test-pose"))
    assert found.accepted
    assert [worded(doubt) for doubt in found.remarks] == [
        "load cases 2, 5 tell the same: any one of them, measured 3×, is worth as much",
        "load cases 3, 4 tell the same: any one of them, measured 2×, is worth as much",
    ]
    document = evaluation_document(found, study(), {})
    assert document["accepted"] is True
    assert len(document["remarks"]) == len(document["doubts"]) == 2
    fewer = LoadCases(cases.q[:3], cases.wrench[:3])
    single = evaluate(study(), fewer, np.array([1, 3, 2]), {}, bound("test-pose"))
    assert single.remarks == ()
    assert single.assessment.rho0 == pytest.approx(found.assessment.rho0, rel=1e-12)


def test_a_sound_plan_with_true_claims_is_accepted() -> None:
    worth, proof = judged().assessment, judged().certificate
    errors = dict(zip(study().springs.names, worth.standard_error, strict=True))
    found = judged(
        rho0=worth.rho0, lower_bound=proof.lower_bound, efficiency=proof.efficiency,
        standard_error=errors, experiments=6,
    )  # fmt: skip
    assert found.objections == ()
    assert found.accepted
    assert proof.lower_bound < worth.rho0
    assert proof.efficiency == pytest.approx((proof.lower_bound / worth.rho0) ** 2, rel=1e-6)


@pytest.mark.parametrize(
    ("claim", "share", "count"),
    [("rho0", 1.00009, 0), ("rho0", 1.00011, 1), ("rho0", 0.99989, 1),
     ("lower_bound", 1.000005, 0), ("lower_bound", 1.00001, 1), ("lower_bound", 0.5, 0),
     ("efficiency", 1.00019, 0), ("efficiency", 1.00022, 1), ("efficiency", 0.5, 0)],
)  # fmt: skip
def test_claims_may_be_off_by_so_much(claim: str, share: float, count: int) -> None:
    plain = judged()
    source = plain.assessment if claim == "rho0" else plain.certificate
    assert len(judged(**{claim: share * getattr(source, claim)}).objections) == count


def test_what_is_claimed_and_what_was_found_are_both_said() -> None:
    worth = judged().assessment
    (doubt,) = judged(rho0=0.5 * worth.rho0).objections
    assert doubt.numbers["claimed"] == pytest.approx(0.5 * worth.rho0)
    assert doubt.numbers["found"] == pytest.approx(worth.rho0)
    (doubt,) = judged(standard_error={"J2": 7.0}).objections
    assert doubt.about == ("J2",)
    assert (doubt.numbers["claimed"], doubt.numbers["found"]) == (7.0, worth.standard_error[1])


def test_other_false_claims() -> None:
    error = judged().assessment.standard_error
    assert len(judged(experiments=7).objections) == 1
    assert len(judged(standard_error={"J2": 1.001 * error[1]}).objections) == 1
    assert len(judged(standard_error={"J2": error[1], "J9": 1.0}).objections) == 1


@pytest.mark.parametrize("criterion", ["D", "O2"])
def test_a_bound_in_metres_is_not_held_against_another_criterion(criterion: str) -> None:
    """ρ0 of a plan for D, or for a criterion without a bound, is no claim about its bound."""
    assert (judged(criterion).certificate.kind == "none") == (criterion == "O2")
    assert judged(criterion, lower_bound=1e9).objections == ()
    (doubt,) = judged(criterion, efficiency=1.5).objections
    assert doubt.code == ("claims-efficiency" if criterion == "D" else "claims-no-bound")
    (doubt,) = judged(criterion, certified="A").objections
    assert worded(doubt) == (
        f"its certificate speaks of criterion A, and it was planned for {criterion}"
    )


def test_a_bound_that_the_search_has_not_closed_is_not_called_false() -> None:
    """Up to what a design that is known reaches: 1 % here, of a bound 2 % too low in φ."""
    found = bound("test-pose")
    assert found.design is not None
    dual = found.design.certificate
    loose = replace(dual, largest=1.02 * dual.largest)
    wide = replace(found, design=replace(found.design, certificate=loose))
    q = np.array([[0.0, 0.4, 0.9], [0.3, -0.6, 1.2], [1.0, 0.2, -1.4]])
    cases = LoadCases(q, np.hstack([np.eye(3), np.zeros((3, 3))]))
    for share, count in ((0.9999, 0), (1.0001, 1)):
        claims = {"lower_bound": share * found.loss(6)}
        assert wide.loss(6) < 0.995 * claims["lower_bound"]
        assert len(evaluate(study(), cases, REPEATS, claims, wide).objections) == count


def test_more_than_the_study_asks_for_is_remarked() -> None:
    q = np.array([[0.0, 0.4, 0.9], [0.3, -0.6, 1.2], [1.0, 0.2, -1.4]])
    cases = LoadCases(q, np.hstack([np.eye(3), np.zeros((3, 3))]))
    experiments = study().experiments
    for count, most, words in (
        (6, None, []),
        (7, 3, []),
        (5, 3, ["it has 6 experiments in all, and the study asks for 5"]),
        (6, 2, ["it has 3 configurations, and the study asks for at most 2"]),
    ):
        asked = replace(experiments, count=count, max_configurations=most)
        found = evaluate(study(), cases, REPEATS, {}, bound("test-pose"), asked=asked)
        assert [worded(doubt) for doubt in found.remarks] == words
        assert found.accepted


def test_what_is_not_checked_is_said() -> None:
    found = judged(kind="rigorous proof", unchecked=("schedule", "attained of the certificate"))
    assert [worded(doubt) for doubt in found.remarks] == [
        "its certificate is of a kind that is not known here, 'rigorous proof'; its bound was "
        "compared with one made anew, nothing else of it was checked",
        "not checked, and not used but where a note says so: schedule, attained of the certificate",
    ]
    assert judged(kind="none").remarks == judged(kind="numerical").remarks == ()


def test_without_a_bound_nothing_is_promised() -> None:
    criterion = criterion_of(study("O4"))
    assert Bound(criterion, criterion, None).loss(12) == 0.0
    two, four = bound("test-pose").loss(2), bound("test-pose").loss(8)
    assert two == pytest.approx(2.0 * four)
    assert not bound("test-pose").floored
