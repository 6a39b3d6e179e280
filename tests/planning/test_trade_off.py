"""Accuracy against time: what the curves say, on the three-link arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.design.exact import Effort
from elastocal.motion.pace import Pace
from elastocal.planning import trade_off as curves
from elastocal.planning.assessment import assess
from elastocal.planning.trade_off import random_plans, time_trade_off, trade_off
from elastocal.report.charts.hours import hours_chart, named
from tests.paper.problems import kr270, three_link_study
from tests.paper.published import A0

LIGHT = Effort(batch=24, generations=2, patience=1, islands=1)


def test_more_hours_buy_accuracy_and_few_configurations_buy_hours() -> None:
    pace = Pace(measure=60.0, settle=0.0, change_load=600.0)
    study = replace(three_link_study(3), pace=pace)
    few, many = time_trade_off(study, configurations=(2, None), counts=(6, 3), effort=LIGHT)
    assert few.configurations == 2
    assert many.configurations is None
    for curve in (few, many):
        assert curve.counts.tolist() == [3, 6]
        assert (np.diff(curve.hours) > 0.0).all()
        assert (np.diff(curve.rho0) < 0.0).all()
    # Every load case has a force of its own here: each costs ten minutes more.
    assert (few.hours <= 2 * 0.25 + 6 / 60.0 + 0.1).all()
    assert (few.rho0 >= many.rho0 * (1.0 - 1e-3)).all()
    assert many.hours[1] >= few.hours[1]
    picture = hours_chart((few, many), (float(many.hours[0]), float(many.rho0[0])))
    assert "this plan" in picture
    assert named(few) in picture
    assert named(many) == "any number of configurations"


def test_what_cannot_be_identified_is_left_out() -> None:
    """Five compliances need two load cases: one configuration will not do, nor one experiment."""
    (curve,) = time_trade_off(kr270(A0), configurations=(1, None), counts=(1, 2), effort=LIGHT)
    assert curve.configurations is None
    assert curve.counts.tolist() == [2]


def test_hours_are_those_of_the_schedule() -> None:
    study = replace(three_link_study(3), pace=Pace(measure=120.0, settle=6.0, change_load=60.0))
    (curve,) = time_trade_off(study, configurations=(None,), counts=(3,), effort=LIGHT)
    at_least = (3 * 120.0 + 60.0 + 6.0) / 3600.0
    assert curve.hours == pytest.approx([at_least], abs=0.2)
    assert curve.hours[0] >= at_least


def test_curves_over_experiments_and_configurations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Never better than the bound, near it, and told how far it is."""
    monkeypatch.setattr(curves, "LIGHT", LIGHT)
    told: list[tuple[str, float]] = []
    study = three_link_study(4)
    found = trade_off(
        study, counts=(1, 2, 8), most_configurations=3, progress=lambda *x: told.append(x)
    )
    assert found.counts.tolist() == [1, 2, 4, 8]
    assert found.configurations.tolist() == [1, 2, 3]
    np.testing.assert_allclose(found.bound * np.sqrt(found.counts), found.bound[0])
    assert (found.rho0 >= found.bound).all()
    assert (found.rho0[1:] <= 1.2 * found.bound[1:]).all()
    assert (found.rho0_configurations >= found.bound[2]).all()
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert shares[:7] == pytest.approx([k / 7 for k in range(7)])
    assert [curve.configurations for curve in found.by_time] == [1, None]
    assert found.by_time[0].counts.tolist() == [2, 4, 8]
    np.testing.assert_array_equal(found.by_time[1].rho0, found.rho0)


def test_random_plans_are_worth_what_an_assessment_says() -> None:
    """Their median against that of as many plans drawn and assessed here."""
    study, rng = three_link_study(5), np.random.default_rng(1)
    found = random_plans(study, 400, seed=3)
    own = []
    for _ in range(200):
        cases = study.space.load_cases(study.space.sample(5, rng))
        own.append(assess(study, cases, np.ones(5, dtype=int)).rho0)
    assert found.shape == (400,)
    assert np.median(found) == pytest.approx(np.median(own), rel=0.15)
    many = random_plans(three_link_study(20_000), 2, seed=3)
    assert many[0] * np.sqrt(4000.0) == pytest.approx(np.median(found), rel=0.3)
    known = replace(study, prior=1e6 * np.eye(3))
    expected = np.sqrt(np.trace(study.test_poses[0].regressor.T @ study.test_poses[0].regressor))
    assert random_plans(known, 3).max() == pytest.approx(1e-3 * expected, rel=1e-3)
