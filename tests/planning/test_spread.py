"""Load cases that the search put side by side."""

from __future__ import annotations

import numpy as np

import elastocal as ec
from elastocal.design.exact import ExactDesign
from elastocal.planning.aim import aim_of
from elastocal.planning.spread import spread
from tests.planning.test_aim import promised, told
from tests.planning.test_near import beside
from tests.planning.test_promise import PLAN


def test_they_are_moved_to_where_they_tell_more() -> None:
    study = told(configurations=6)
    aim = aim_of(study)
    goal, counts = aim.goal(), np.full(6, 2)
    cases = beside(PLAN, 0.5)
    before = ExactDesign(aim.space.points(cases), counts, 0.0)
    after = spread(aim, aim.space, goal, before, np.random.default_rng(0))
    moved = aim.space.load_cases(after.x)
    assert aim.told is not None
    assert len(set(aim.told.groups(moved)[0].tolist())) > 3
    assert promised(study, moved, after.counts) < 0.9 * promised(study, cases, counts)
    assert not ec.assess(study, moved, after.counts).violations


def test_plans_of_load_cases_far_from_each_other_stay() -> None:
    study = told()
    aim = aim_of(study)
    before = ExactDesign(aim.space.points(PLAN), np.array([2, 7, 3]), 0.0)
    assert spread(aim, aim.space, aim.goal(), before, np.random.default_rng(0)) is before
