"""Parts of planning alone: what is kept away from, where measuring is worth most."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.planning.certificate import lower_bound
from elastocal.planning.plan import _away_from
from elastocal.planning.sensitivity import sensitivity, worth
from elastocal.robot.posture import Posture
from elastocal.robot.sources import three_link
from tests.paper.problems import three_link_study


def test_what_cannot_be_reached_is_kept_away_from_in_the_joints_that_count() -> None:
    """J1 is free: turning it leads nowhere else. J2 moved by 0.6 is away, by 0.4 it is not."""
    away = _away_from(np.array([0.1, 0.2, 0.3]), three_link(), ("J1",))
    moved = np.array([[3.0, 0.2, 0.3], [0.1, 0.8, 0.3], [0.1, 0.6, 0.3]])
    margin, _ = away.at(Posture(three_link(), moved))
    np.testing.assert_allclose(margin, [-0.5, 0.1, -0.1], atol=1e-12)


def test_measuring_is_worth_most_at_the_support_of_the_best_design() -> None:
    study = three_link_study(4)
    bound = lower_bound(study, np.random.default_rng(0))
    assert bound.design is not None
    design = bound.design
    support = study.space.load_cases(design.x)
    peak = study.space.load_cases(design.certificate.x_largest[None])
    known = sensitivity(study, support, design.weights, peak)
    assert known is not None
    at_support = worth(study, known, support)
    assert at_support.max() < 1.0 + 1e-5
    assert np.average(at_support, weights=design.weights) == pytest.approx(1.0, abs=1e-5)
    anywhere = study.space.load_cases(study.space.sample(2000, np.random.default_rng(1)))
    assert 0.5 < worth(study, known, anywhere).max() < 1.0 + 1e-5


def test_a_singular_design_has_no_sensitivity() -> None:
    study = three_link_study(1)
    one = study.space.load_cases(np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]))
    assert sensitivity(study, one, np.ones(1), one) is None
    assert sensitivity(replace(study, criterion="O2"), one, np.ones(1), one) is None
