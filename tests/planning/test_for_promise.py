"""Plans that are made for their promise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import elastocal as ec
from elastocal.design.exact import ExactDesign
from elastocal.design.refinement import Goal
from elastocal.elastic.case_errors import CaseErrors
from elastocal.planning.for_promise import for_promise, is_for_promise
from elastocal.study.criteria import criterion_of
from elastocal.study.study import Study, with_count
from elastocal.study.two_steps import with_nuisance
from tests.kr270 import kr270_study
from tests.planning.test_promise import ALL, PLAN, REPEATS, two_axes_a_joint


def told(errors: CaseErrors = ALL, configurations: int = 3) -> Study:
    study = with_nuisance(kr270_study(), two_axes_a_joint(errors))
    return with_count(study, 12, configurations)


def moved(study: Study, seed: int = 0) -> ExactDesign:
    """The plan of the other tests, made for its promise."""
    space = study.space
    goal = Goal(space, criterion_of(study), study.prior)
    start = ExactDesign(space.points(PLAN), REPEATS, 0.0)
    return for_promise(study, space, goal, start, seed)


def promised(study: Study, design: ExactDesign) -> float:
    found = ec.assess(study, study.space.load_cases(design.x), design.counts)
    assert not found.violations
    assert found.promise is not None
    return found.promise.rho0


def test_the_same_effort_promises_more() -> None:
    before = ec.assess(told(), PLAN, REPEATS).promise
    assert before is not None
    few, many = (moved(told(configurations=c)) for c in (3, 12))
    assert few.counts.sum() == many.counts.sum() == 12
    assert len(few.counts) <= 3
    assert len(many.counts) > 6
    least, more = promised(told(), few), promised(told(configurations=12), many)
    assert more < least < 0.9 * before.rho0


def test_the_same_seed_makes_the_same_plan() -> None:
    one, same = (moved(told(), 4) for _ in range(2))
    np.testing.assert_array_equal(one.x, same.x)
    np.testing.assert_array_equal(one.counts, same.counts)


def test_without_errors_or_with_another_criterion_plans_are_as_ever() -> None:
    assert is_for_promise(told())
    assert not is_for_promise(told(CaseErrors()))
    assert not is_for_promise(kr270_study())
    assert not is_for_promise(replace(told(), criterion="worst"))


def test_it_ends_when_it_is_asked_to() -> None:
    study = told()
    space = study.space
    start = ExactDesign(space.points(PLAN), REPEATS, 0.0)
    goal = Goal(space, criterion_of(study), study.prior)
    found = for_promise(study, space, goal, start, 0, lambda: True)
    np.testing.assert_array_equal(np.sort(found.counts), np.sort(REPEATS))
