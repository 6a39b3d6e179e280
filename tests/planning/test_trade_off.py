"""Accuracy against time: what the curves say, on the three-link arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.design.exact import Effort
from elastocal.motion.pace import Pace
from elastocal.planning.trade_off import time_trade_off
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
