"""Loads from one side: when a joint may turn together with the load, and where it is put then."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.constraints import HalfSpace
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, Load
from elastocal.elastic.load_cases import LoadCases
from elastocal.measuring.instrument import Isotropic, LaserTracker
from elastocal.motion.schedule import schedule
from elastocal.planning.one_side import azimuth_range, azimuths, from_one_side
from elastocal.planning.plain_values import simplify
from elastocal.planning.remaining import knowing
from elastocal.robot.chain import Robot, transform
from elastocal.robot.sources import three_link
from elastocal.study.before import Done
from elastocal.study.study import Study
from tests.paper.problems import any_direction, cone, kr270, three_link_study
from tests.paper.published import A0
from tests.test_examples import ROOT

UP = np.array([0.0, 0.0, 1.0])


def drawn(study: Study, count: int = 5, seed: int = 0) -> LoadCases:
    return study.space.load_cases(study.space.sample(count, np.random.default_rng(seed)))


def turned(study: Study, cases: LoadCases) -> tuple[LoadCases, str]:
    return from_one_side(study.space, cases, ())


def directions(axis: np.ndarray, cases: LoadCases) -> np.ndarray:
    """(N, 3) unit vectors of the forces across an axis, by projection."""
    force = cases.wrench[:, :3]
    across = force - np.outer(force @ axis, axis)
    return across / np.linalg.norm(across, axis=1)[:, None]


@pytest.mark.parametrize("force", [any_direction(), cone(30.0)], ids=["any", "cone"])
def test_all_loads_come_from_one_side_and_are_worth_the_same(force: Load) -> None:
    study = kr270(A0, force=force)
    cases = drawn(study)
    found, joint = turned(study, cases)
    assert joint == "A1"
    np.testing.assert_allclose(np.ptp(directions(UP, found), axis=0), 0.0, atol=1e-9)
    assert np.ptp(directions(UP, cases), axis=0).max() > 0.5  # before
    before, after = (study.space.information(at) for at in (cases, found))
    np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-12 * np.abs(before).max())
    np.testing.assert_array_equal(found.q[:, 1:], cases.q[:, 1:])
    sizes = np.linalg.norm(found.wrench[:, :3], axis=1)
    np.testing.assert_allclose(sizes, 2500.0, rtol=1e-12)
    np.testing.assert_allclose(found.wrench[:, 2], cases.wrench[:, 2], atol=1e-9)
    assert azimuth_range(study.robot, found, joint) < 1e-9


def test_the_axis_need_not_be_vertical() -> None:
    """The same arm hung from a wall."""
    robot = three_link()
    rng = np.random.default_rng(3)
    tilt = transform(np.linalg.qr(rng.normal(size=(3, 3)))[0], np.array([0.3, -0.2, 1.0]))
    tilt[:3, :3] *= np.sign(np.linalg.det(tilt[:3, :3]))
    first = replace(robot.joints[0], T_parent_joint=tilt @ robot.joints[0].T_parent_joint)
    hung = Robot("hung", (first, *robot.joints[1:]), robot.T_tip_flange, tools=robot.tools)
    study = replace(three_link_study(4), robot=hung)
    found, joint = turned(study, drawn(study))
    axis = tilt[:3, :3] @ robot.joints[0].T_parent_joint[:3, :3] @ robot.joints[0].axis
    assert joint == "J1"
    np.testing.assert_allclose(np.ptp(directions(axis, found), axis=0), 0.0, atol=1e-9)


WALL = HalfSpace("a wall", np.zeros(3), [1.0, 0.2, 0.0], -3.0)
FLOOR = HalfSpace("a floor", np.zeros(3), [0.0, 0.0, 1.0], -3.0)
ASIDE = LaserTracker(np.array([3.0, 0.4, 1.2]), 5e-6, 1.5e-7, 7.5e-6, 3e-6)
ABOVE = LaserTracker(np.array([0.0, 0.0, 6.0]), 5e-6, 1.5e-7, 7.5e-6, 3e-6)


@pytest.mark.parametrize(
    ("joint", "changed"),
    [
        ("A1", {}),
        ("", {"constraints": (WALL,)}),
        ("A1", {"constraints": (FLOOR,)}),
        ("", {"instrument": ASIDE}),
        ("A1", {"instrument": ABOVE}),
        ("A1", {"instrument": Isotropic(1e-5)}),
        ("A1", {"prior": np.eye(5)}),
    ],
    ids=["nothing", "wall", "floor", "tracker", "tracker above", "noise", "prior"],
)  # fmt: skip
def test_what_breaks_the_symmetry(joint: str, changed: dict[str, object]) -> None:
    study = replace(kr270(A0, force=any_direction()), **changed)  # type: ignore[arg-type]
    cases = drawn(study)
    found, turning = turned(study, cases)
    assert turning == joint
    assert (found is cases) == (not joint)


@pytest.mark.parametrize(
    ("force", "moment", "joint"),
    [
        (FreeDirection(100.0, UP, 0.5), FixedVector(np.zeros(3)), "J1"),
        (FreeDirection(100.0, np.array([0.1, 0.0, 1.0]), 0.5), FixedVector(np.zeros(3)), ""),
        (FixedVector(np.array([100.0, 0.0, 0.0])), FixedVector(np.zeros(3)), ""),
        (FixedVector(100.0 * UP), FreeDirection(20.0, UP), "J1"),
        (FixedVector(100.0 * UP), FreeDirection(20.0, np.array([1.0, 0.0, 0.0]), 0.5), ""),
        (FreeDirection(100.0, UP), FixedVector(20.0 * UP), "J1"),
        (FreeDirection(100.0, UP), FixedVector(np.array([0.0, 20.0, 0.0])), ""),
        (FreeDirection(100.0, UP), FreeDirection(20.0, UP), "J1"),
        (FixedVector(np.zeros(3)), FreeDirection(20.0, UP), "J1"),
    ],
)
def test_which_rules_of_loads_keep_it(force: Load, moment: Load, joint: str) -> None:
    plain = three_link_study(4)
    study = replace(plain, experiments=replace(plain.experiments, force=force, moment=moment))
    cases = drawn(study, 6, 1)
    found, turning = turned(study, cases)
    assert turning == joint
    before, after = (study.space.information(at) for at in (cases, found))
    np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-12 * np.abs(before).max())
    if joint:
        assert azimuth_range(study.robot, found, joint) < 1e-8


def test_a_spring_before_the_joint_breaks_it_as_does_weight_across_it() -> None:
    rail = ec.read_study(ROOT / "examples" / "robots" / "rail-arm" / "study.yaml")
    free = replace(
        rail.experiments, force=FreeDirection(1800.0, UP), moment=FixedVector(np.zeros(3))
    )
    study = replace(rail, experiments=free)
    assert turned(study, drawn(study))[1] == "J1"  # the second joint; its axis does not move
    assert simplify(study.space, drawn(study)).free == ("E1",)
    leaning = replace(study, gravity=np.array([0.0, 3.0, -9.0]))
    assert leaning.arm.sags
    assert turned(leaning, drawn(leaning))[1] == ""
    sprung = replace(study, springs=ec.joint_springs(rail.robot))
    assert turned(sprung, drawn(sprung))[1] == ""


def test_a_load_along_the_axis_leaves_the_joint_at_rest() -> None:
    study = kr270(A0, force=any_direction())
    cases = drawn(study)
    wrench = np.array(cases.wrench)
    wrench[[1, 3]] = [0.0, 0.0, -2500.0, 0.0, 0.0, 0.0]
    found, _ = turned(study, LoadCases(cases.q, wrench))
    np.testing.assert_array_equal(found.q[[1, 3], 0], 0.0)
    np.testing.assert_array_equal(found.wrench[[1, 3]], wrench[[1, 3]])
    azimuth = azimuths(UP, found.wrench)
    assert np.isnan(azimuth).tolist() == [False, True, False, True, False]
    assert np.nanmax(azimuth) - np.nanmin(azimuth) < 1e-9


def test_loads_that_are_the_same_then_are_so_to_the_last_digit() -> None:
    """At one height they are one load: it is put on once."""
    study = kr270(A0, force=any_direction())
    cases = drawn(study)
    azimuth, z = np.linspace(0.0, 5.0, 5), np.full(5, -1500.0)
    wrench = np.column_stack(
        [2000.0 * np.cos(azimuth), 2000.0 * np.sin(azimuth), z, np.zeros((5, 3))]
    )
    once = np.ones(5, dtype=np.int64)
    before = LoadCases(cases.q, wrench)
    found, _ = turned(study, before)
    assert len(np.unique(found.wrench, axis=0)) == 1
    changes = [schedule(at, once, study.pace).changing.sum() for at in (before, found)]
    assert changes[0] == 5 * changes[1] > 0.0


@pytest.mark.parametrize("limits", [(-185.0, 185.0), (-30.0, 30.0), (-10.0, 200.0), (20.0, 100.0),
                                    (-400.0, 400.0), (100.0, 420.0), (-1.0, 1.0)])  # fmt: skip
def test_the_joint_keeps_its_limits_and_is_put_as_near_to_rest_as_can_be(
    limits: tuple[float, float],
) -> None:
    """Against every azimuth in steps of 0.1°: nearer to one side first, then nearer to rest."""
    lower, upper = np.radians(limits)
    rest = float(np.clip(0.0, lower, upper))
    plain = kr270(A0, force=any_direction())
    box = np.array(plain.limits)
    box[:, 0] = lower, upper
    study = replace(plain, limits=box)
    for seed in range(4):
        cases = drawn(study, 3, seed)
        found, joint = turned(study, cases)
        assert joint == "A1"
        assert (found.q[:, 0] >= lower).all()
        assert (found.q[:, 0] <= upper).all()
        spread = azimuth_range(study.robot, found, joint)
        at_zero = cases.q[:, 0] + azimuths(UP, cases.wrench)  # A1 counts the other way round
        side = np.arange(0.0, 2.0 * np.pi, np.radians(0.1))[:, None, None]
        values = at_zero - side + 2.0 * np.pi * np.arange(-3, 4)[:, None]
        beyond = np.maximum(np.maximum(lower - values, values - upper), 0.0).min(axis=1)
        worst = beyond.max(axis=1)
        away = np.where((values >= lower) & (values <= upper), np.abs(values - rest), np.inf)
        away = np.where(beyond > 0.0, np.abs(rest - np.clip(rest, lower, upper)), away.min(axis=1))
        step = np.radians(0.11)
        if worst.min() == 0.0:
            assert spread < 1e-8
            reach = np.abs(found.q[:, 0] - rest).max()
            assert reach <= away[worst == 0.0].max(axis=1).min() + 1e-9
        else:  # as far as the worst load is off on one side, another may be on the other
            assert spread <= 2.0 * worst.min() + step
            assert spread > 0.0
        before, after = (study.space.information(at) for at in (cases, found))
        np.testing.assert_allclose(after, before, rtol=1e-9, atol=1e-12 * np.abs(before).max())


def test_turned_with_its_load_it_is_no_other_configuration_of_one_that_was_measured() -> None:
    study = kr270(A0, force=any_direction())
    cases = drawn(study, 2)
    before = Done("first.csv", "", 2, cases, np.eye(5))
    rest = knowing(study, before)
    elsewhere = np.array(cases.q)
    elsewhere[:, 0] += 1.0
    apart = rest.constraints[len(study.constraints) :]
    assert [c.margin(study.robot, elsewhere)[i] < 0.0 for i, c in enumerate(apart)] == [True, True]
    assert turned(rest, drawn(study, 3, 7))[1] == "A1"
