"""What plans are made for: the promise, where load cases have errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.design.exact import Effort
from elastocal.elastic.case_errors import CaseErrors
from elastocal.planning.aim import Aim, accuracy, aim_of, is_for_promise
from elastocal.planning.certificate import Bound, lower_bound
from elastocal.planning.evaluation import evaluate
from elastocal.study.study import Study, with_count, with_load_cases
from elastocal.study.two_steps import with_nuisance
from tests.kr270 import kr270_study
from tests.planning.test_promise import ALL, PLAN, REPEATS, two_axes_a_joint

COMMON = replace(ALL, discrepancy_length=2e-5, common_gain=0.003, common_tilt=0.01)
QUICK = Effort(batch=32, generations=3, patience=1, islands=1)


def told(errors: CaseErrors = ALL, configurations: int | None = 3) -> Study:
    study = with_nuisance(kr270_study(), two_axes_a_joint(errors))
    return with_count(study, 12, configurations)


@pytest.fixture(scope="module")
def few() -> Bound:
    """What no plan of three configurations passes."""
    return lower_bound(told(), np.random.default_rng(0))


@pytest.fixture(scope="module")
def many() -> Bound:
    """What no plan of twelve passes."""
    return lower_bound(told(configurations=None), np.random.default_rng(0))


def promised(study: Study, cases: ec.LoadCases, repeats: np.ndarray) -> float:
    found = ec.assess(study, cases, repeats).promise
    assert found is not None
    return found.rho0


def by_aim(aim: Aim, cases: ec.LoadCases, repeats: np.ndarray) -> float:
    return aim.loss(float(aim.criterion.value(aim.total(cases, repeats)[None])[0]))


@pytest.mark.parametrize(
    "errors",
    [ALL, COMMON, replace(COMMON, process_force="exact"), replace(COMMON, process_force="other")],
)
def test_what_is_searched_is_what_is_promised(errors: CaseErrors) -> None:
    """By rows in units of what errs, and by covariances of load cases: two routes."""
    study = told(errors)
    expected = promised(study, PLAN, REPEATS)
    assert by_aim(aim_of(study), PLAN, REPEATS) == pytest.approx(expected, rel=1e-8)


def test_what_was_read_between_two_loads_has_the_errors_of_both() -> None:
    study = told(COMMON)
    twice = ec.LoadCases(PLAN.q, PLAN.wrench, 0.5 * PLAN.wrench)
    expected = promised(study, twice, REPEATS)
    assert by_aim(aim_of(study), twice, REPEATS) == pytest.approx(expected, rel=1e-8)
    assert expected > promised(study, PLAN, REPEATS)


def test_without_errors_or_with_another_criterion_plans_are_as_ever() -> None:
    assert is_for_promise(told())
    assert aim_of(told()).promise
    for study in (told(CaseErrors()), kr270_study(), replace(told(), criterion="worst")):
        assert not is_for_promise(study)
        assert not aim_of(study).promise
        assert aim_of(study).space.errors is None
    assert accuracy(replace(told(), criterion="worst")).promise


def test_a_plan_is_near_the_bound_on_promises(many: Bound) -> None:
    """It is worth what `assess` says of it, and no random plan passes the bound."""
    study = told(configurations=None)
    made = ec.plan(study, effort=QUICK, bound=many)
    proof, worth = made.certificate, made.assessment
    assert proof.promise
    assert worth.promise is not None
    assert worth.promised == worth.promise.rho0
    assert 0.9 < proof.lower_bound / worth.promised <= 1.0
    assert proof.efficiency == pytest.approx((proof.lower_bound / worth.promised) ** 2)
    assert len(made.repeats) > 6
    assert worth.promised < 0.75 * promised(study, PLAN, REPEATS)
    rng = np.random.default_rng(0)
    for _ in range(20):
        cases = study.space.load_cases(study.space.sample(12, rng))
        assert promised(study, cases, np.ones(12, dtype=np.int64)) > proof.lower_bound


def test_few_configurations_have_a_bound_of_their_own(few: Bound, many: Bound) -> None:
    """Readings dealt out unevenly are below it, too; that of many configurations is lower."""
    assert few.uneven >= 1.0
    assert many.uneven == 1.0
    made = ec.plan(told(), effort=QUICK, bound=few)
    assert many.loss(12) < few.loss(12) < made.assessment.promised
    assert len(made.repeats) <= 3
    assert made.repeats.sum() == 12
    assert made.certificate.lower_bound == few.loss(12)


def test_a_plan_is_judged_by_the_bound_for_as_many_configurations(few: Bound, many: Bound) -> None:
    """Against a bound on plans of twelve its own would be too high, and a false claim."""
    study = told()
    claims = {"lower_bound": few.loss(12)}
    found = evaluate(study, PLAN, REPEATS, claims, few, None)
    assert not found.objections
    assert found.certificate.lower_bound == pytest.approx(few.loss(12))
    wider = with_load_cases(study, np.ones(12, dtype=np.int64))
    assert wider.experiments.max_configurations == 12
    refuted = evaluate(wider, PLAN, REPEATS, {"lower_bound": few.loss(12)}, many, None)
    assert [doubt.code for doubt in refuted.objections] == ["claims-bound"]
