"""Order of execution against brute force, and the hours of a campaign by hand."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, permutations

import numpy as np
import pytest

from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.motion.pace import SLIDING_SPEED, SPEED, Pace, for_robot
from elastocal.motion.schedule import schedule
from elastocal.motion.tour import EXACT, best_order, shortest_tour, travel_times
from elastocal.robot.sources import kuka_kr270
from tests.arms import random_chain

WEIGHT = np.array([0.0, 0.0, -2500.0, 0.0, 0.0, 0.0])


def length(cost: np.ndarray, tour: np.ndarray) -> float:
    legs = [0, *tour, 0]
    return float(sum(cost[i, j] for i, j in pairwise(legs)))


def brute_force(cost: np.ndarray) -> float:
    return min(length(cost, np.array(p)) for p in permutations(range(1, len(cost))))


def pace(**changes: float) -> Pace:
    robot = kuka_kr270()
    return for_robot(Pace(**changes), robot, np.array([robot.lower, robot.upper]))


@pytest.mark.parametrize("count", [0, 1, 2, 3, 5, 7])
@pytest.mark.parametrize("seed", range(3))
def test_few_places_are_ordered_best(count: int, seed: int) -> None:
    """Costs from a to b and from b to a differ: approach points make them so."""
    cost = np.random.default_rng(seed).uniform(0.0, 1.0, (count + 1, count + 1))
    tour = shortest_tour(cost)
    assert sorted(tour) == list(range(1, count + 1))
    if count:
        assert length(cost, tour) == pytest.approx(brute_force(cost))


def test_the_largest_exact_order_is_as_good_as_brute_force() -> None:
    points = np.random.default_rng(7).uniform(-1.0, 1.0, (EXACT, 3))
    cost = travel_times(points, points, np.ones(3))
    assert length(cost, shortest_tour(cost)) == pytest.approx(brute_force(cost))


@pytest.mark.parametrize("seed", range(4))
def test_many_places_in_a_ring_are_found(seed: int) -> None:
    """The best tour of places on a circle is known: once around."""
    count = 24
    angles = np.linspace(0.0, 2.0 * np.pi, count + 1, endpoint=False)
    points = np.column_stack([np.cos(angles), np.sin(angles)])
    shuffled = np.random.default_rng(seed).permutation(np.arange(1, count + 1))
    points = points[np.append(0, shuffled)]
    cost = np.linalg.norm(points[:, None] - points[None], axis=2)
    tour = shortest_tour(cost)
    assert sorted(tour) == list(range(1, count + 1))
    assert length(cost, tour) == pytest.approx((count + 1) * 2.0 * np.sin(np.pi / (count + 1)))


@pytest.mark.parametrize("seed", range(3))
def test_the_search_for_many_is_near_the_exact_order(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nine random places, by dynamic programming and by improvement."""
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (10, 6))
    cost = travel_times(points, points, np.ones(6))
    best = length(cost, shortest_tour(cost))
    monkeypatch.setattr("elastocal.motion.tour.EXACT", 2)
    assert best <= length(cost, shortest_tour(cost)) + 1e-12 <= 1.05 * best + 1e-12


def test_travel_is_timed_by_the_slowest_joint() -> None:
    starts = np.array([[0.0, 0.0], [1.0, 3.0]])
    times = travel_times(starts, np.array([[2.0, 1.0]]), np.array([1.0, 0.25]))
    assert times == pytest.approx(np.array([[4.0], [8.0]]))


def test_load_cases_of_the_same_wrench_come_together() -> None:
    rng = np.random.default_rng(3)
    q = rng.uniform(-1.0, 0.0, (8, 6))
    wrench = np.outer([1.0, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0], WEIGHT)
    order = best_order(LoadCases(q, wrench), pace())
    sizes = wrench[order.sequence, 2]
    assert np.count_nonzero(np.diff(sizes)) == 1
    many = LoadCases(np.tile(q, (3, 1)) + rng.normal(0, 0.1, (24, 6)), np.tile(wrench, (3, 1)))
    sizes = many.wrench[best_order(many, pace()).sequence, 2]
    assert np.count_nonzero(np.diff(sizes)) == 1


def test_the_order_does_not_depend_on_how_it_was() -> None:
    rng = np.random.default_rng(4)
    cases = LoadCases(rng.uniform(-1.0, 0.0, (7, 6)), np.tile(WEIGHT, (7, 1)))
    first = best_order(cases, pace())
    assert np.array_equal(first.sequence, best_order(cases, pace()).sequence)
    mixed = rng.permutation(7)
    again = best_order(LoadCases(cases.q[mixed], cases.wrench), pace())
    assert again.duration == pytest.approx(first.duration)


def test_a_motion_that_is_not_free_is_gone_around() -> None:
    """Three places in a row; the short way between the first two is blocked."""
    q = np.zeros((3, 6))
    q[:, 0] = [0.1, 0.2, 0.3]
    cases = LoadCases(q, np.tile(WEIGHT, (3, 1)))

    def free(starts: np.ndarray, goals: np.ndarray) -> np.ndarray:
        pair = np.sort(np.column_stack([starts[:, 0], goals[:, 0]]), axis=1)
        return ~np.isclose(pair, [0.1, 0.2]).all(axis=1)

    order = best_order(cases, pace(), free=free)
    assert order.blocked == ()
    places = q[order.sequence, 0]
    assert {0.1, 0.2} not in [set(pair) for pair in pairwise(places.tolist())]
    stuck = best_order(cases, pace(), free=lambda s, g: np.abs(g[:, 0] - 0.2) > 1e-9)
    assert len(stuck.blocked) == 1  # nothing leads to the second place: said, not hidden
    assert stuck.duration < 1e6


def test_approach_points_count() -> None:
    """From the approach point on every joint moves the same way."""
    q = np.zeros((1, 6))
    q[0, 0] = 0.5
    arrivals = q - 0.1
    here = pace()
    order = best_order(LoadCases(q, WEIGHT[None]), here, arrivals=arrivals)
    assert order.duration == pytest.approx((0.4 + 0.1 + 0.5) / SPEED)


def test_hours_by_hand() -> None:
    """Two weights, three stops, 10°/s: every number is worked out here."""
    q = np.radians([[90.0, -90, 90, 0, 0, 0], [90.0, -60, 90, 0, 0, 0], [0.0, -60, 90, 0, 0, 0]])
    wrench = np.outer([1.0, 1.0, 2.0], WEIGHT)
    home = np.radians([0.0, -90.0, 90.0, 0.0, 0.0, 0.0])
    known = replace(pace(), home=home, measure=100.0, settle=2.0, change_load=600.0)
    found = schedule(LoadCases(q, wrench), np.array([4, 1, 2]), known)
    assert found.moving == pytest.approx([9.0 + 2.0, 3.0 + 2.0, 9.0 + 2.0])
    assert found.changing == pytest.approx([600.0, 0.0, 600.0])
    assert found.measuring == pytest.approx([400.0, 100.0, 200.0])
    assert found.homing == pytest.approx(3.0)
    assert found.each == pytest.approx([1011.0, 105.0, 811.0])
    assert found.ends == pytest.approx([1011.0, 1116.0, 1927.0])
    assert found.total == pytest.approx(1930.0)
    assert found.hours == pytest.approx(1930.0 / 3600.0)
    assert found.minutes["moving"] == pytest.approx((11.0 + 5.0 + 11.0 + 3.0) / 60.0)
    assert found.minutes["changing loads"] == pytest.approx(20.0)
    for times in (found.moving, found.changing, found.measuring):
        assert not times.flags.writeable
    assert sum(found.minutes.values()) == pytest.approx(60.0 * found.hours, rel=1e-12)


def test_a_load_is_changed_where_it_differs_from_the_last() -> None:
    """1, 2, 2, 1: put on, changed, kept, changed back."""
    wrench = np.outer([1.0, 2.0, 2.0, 1.0], WEIGHT)
    cases = LoadCases(np.tile(pace().home, (4, 1)), wrench)
    found = schedule(cases, np.array([1, 2, 3, 4]), pace(change_load=60.0))
    assert found.changing.tolist() == [60.0, 60.0, 0.0, 60.0]
    assert found.minutes["changing loads"] == pytest.approx(3.0)


def test_speeds_and_home_are_there_for_every_joint() -> None:
    robot = random_chain(np.random.default_rng(0), [True, False])
    limits = np.array([[0.5, -1.0], [2.0, 1.0]])
    full = for_robot(Pace(), robot, limits)
    assert full.speed == pytest.approx([SLIDING_SPEED, SPEED])
    assert full.home == pytest.approx([0.5, 0.0])  # zero, or the limit nearest to it


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (Pace(speed=np.ones(5)), "need 6 numbers"),
        (Pace(speed=np.array([1, 1, 0, 1, 1, 1])), "'A3' must be positive"),
        (Pace(home=np.radians([0, 10, 0, 0, 0, 0])), r"A2 at 10°, outside its limits -140"),
    ],
)
def test_a_wrong_campaign_is_refused(wrong: Pace, says: str) -> None:
    robot = kuka_kr270()
    with pytest.raises(InputError, match=says):
        for_robot(wrong, robot, np.array([robot.lower, robot.upper]))


def test_a_home_at_a_limit_may_be_beyond_it_by_rounding() -> None:
    robot = kuka_kr270()
    limits = np.array([robot.lower, robot.upper])
    for end, outward in ((robot.lower, -1.0), (robot.upper, 1.0)):
        home = np.zeros(6)
        home[1] = end[1] + outward * 1e-10
        assert for_robot(Pace(home=home), robot, limits).home[1] == home[1]
        home[1] = end[1] + outward * 1e-8
        with pytest.raises(InputError, match="home has A2"):
            for_robot(Pace(home=home), robot, limits)


def test_negative_times_are_refused() -> None:
    with pytest.raises(InputError, match="settle must not be negative"):
        Pace(settle=-1.0)
