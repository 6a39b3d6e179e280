"""Parts of planning alone: what is kept away from, where measuring is worth most."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError
from elastocal.motion.within_reach import out_of_reach
from elastocal.planning.along_paths import better_along
from elastocal.planning.assessment import assess
from elastocal.planning.certificate import lower_bound
from elastocal.planning.evaluation import _false_covariance
from elastocal.planning.lost import away_from, others_lost, turned_into
from elastocal.planning.plan import _refuse, _roomiest
from elastocal.planning.sensitivity import sensitivity, worth
from elastocal.robot.posture import Posture
from elastocal.robot.sources import three_link
from elastocal.study.test_path import test_path as make_path
from tests.kr270 import kr270_study
from tests.motion.test_within_reach import slider
from tests.paper.problems import three_link_study


def test_what_cannot_be_reached_is_kept_away_from_in_the_joints_that_count() -> None:
    """J1 is free: turning it leads nowhere else. J2 moved by 0.6 is away, by 0.4 it is not."""
    moved = np.array([[3.0, 0.2, 0.3], [0.1, 0.8, 0.3], [0.1, 0.6, 0.3]])
    for again, off in ((0, 0.0), (2, -1.5)):  # four times as far the third time
        away = away_from(np.array([0.1, 0.2, 0.3]), three_link(), ("J1",), again)
        margin, _ = away.at(Posture(three_link(), moved))
        np.testing.assert_allclose(margin, off + np.array([-0.5, 0.1, -0.1]), atol=1e-12)


def test_designs_are_turned_into_the_limits_by_whole_turns() -> None:
    """J1 by one turn; J2 would be beyond the limits then, too, and stays; J3 is inside."""
    study = three_link_study(4)
    x = lower_bound(study, np.random.default_rng(0)).design
    assert x is not None
    q = np.array([[5.9, 3.0, 0.3]])
    given = replace(x, x=np.hstack([q, x.x[:1, 3:]]))
    limits = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    found = turned_into(limits, given, study.robot)
    np.testing.assert_allclose(found.x[0, :3], [5.9 - 2.0 * np.pi, 3.0, 0.3], atol=1e-12)
    np.testing.assert_array_equal(found.x[0, 3:], given.x[0, 3:])
    assert turned_into(6.0 * limits, given, study.robot) is given


def test_what_is_left_out_is_said_where_nothing_is_left() -> None:
    error = InfeasibleError("no room")
    with pytest.raises(InfeasibleError, match=r"^no room$"):
        _refuse(error, ())
    doubts = out_of_reach(slider(((0.0, 0.0), (0.1, 3.0))))
    with pytest.raises(InfeasibleError, match="no room; of the range of X only") as told:
        _refuse(error, doubts)
    assert told.value.doubts == doubts


def test_all_configurations_without_a_way_are_found_together() -> None:
    """A curtain at x = 0: home is before it. One is known; what is before it is not lost."""
    space = slider(((0.0, 0.0), (0.1, 3.0)))
    q = np.array([[0.5, 0.0], [-0.5, 0.5], [0.7, -0.3], [0.8, 0.8]])
    lost = list(others_lost(space, q, q[2], 0))
    np.testing.assert_array_equal(lost, q[[0, 3]])
    around = slider(((0.0, -0.2), (0.1, 1.5)))
    assert not list(others_lost(around, q, q[2], 0))


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


def test_the_load_case_with_the_most_room_is_kept() -> None:
    """Least margins 5, 30 and 20 degrees; the first has more room than the others elsewhere."""
    study = kr270_study()
    q = np.radians([[0.0, -135, 80, 0, 0, 0], [0.0, -110, 80, 0, 90, 0], [0.0, -120, 80, 0, 60, 0]])
    free = replace(study, constraints=())
    order = _roomiest(free, LoadCases(q, np.zeros((3, 6))))
    assert order.tolist() == [1, 2, 0]


def test_a_covariance_of_what_is_not_identified_is_no_claim_that_holds() -> None:
    study = three_link_study(1)
    one = study.space.load_cases(np.array([[0.0, 0.0, 0.0, 0.0, 0.0, 1.0]]))
    worth = assess(study, one, np.ones(1, dtype=int))
    claimed = np.array([[4.0, 1.0, 0.0], [1.0, 9.0, 0.0], [0.0, 0.0, 16.0]])
    (doubt,) = _false_covariance(study, worth, study.fitted.names, claimed)
    assert (doubt.code, doubt.about) == ("claims-error", ("J1",))
    assert doubt.numbers == {"claimed": 2.0, "found": np.inf}


def test_only_paths_are_compared_point_by_point() -> None:
    study = three_link_study(4)
    cases = study.space.load_cases(study.space.sample(20, np.random.default_rng(0)))
    along = make_path(study.arm, cases, 1.0, "way")
    assert along.points == tuple(str(i) for i in range(1, 21))
    both = replace(study, test_poses=(*study.test_poses, along))
    plans = {
        name: assess(
            both, study.space.load_cases(study.space.sample(4, rng)), np.ones(4, dtype=int)
        )
        for name, rng in (("a", np.random.default_rng(1)), ("b", np.random.default_rng(2)))
    }
    shares = better_along(both, plans)
    assert list(shares) == ["way"]
    assert shares["way"]["a"]["b"] + shares["way"]["b"]["a"] == pytest.approx(1.0)
