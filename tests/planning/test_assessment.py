"""What a plan is worth: the nearest constraint and what is broken, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.arrays import Array
from elastocal.constraints import room_at
from elastocal.elastic.allowed_loads import FreeDirection, InPlane
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.assessment import assess, hardly_known
from elastocal.robot.posture import Posture
from elastocal.study.study import Study
from elastocal.wording import worded
from tests.paper.problems import three_link_study

DOWN = np.array([0.0, 0.0, -1.0])


def at(degrees: list[list[float]], force: Array) -> LoadCases:
    q = np.radians(degrees)
    return LoadCases(q, np.hstack([np.broadcast_to(force, (len(q), 3)), np.zeros((len(q), 3))]))


def cone() -> Study:
    """Forces up to 2 N within 10° of straight down."""
    study = three_link_study(3)
    force = FreeDirection(2.0, DOWN, half_angle=np.radians(10.0))
    return replace(study, experiments=replace(study.experiments, force=force))


def test_a_force_out_of_the_plane_is_a_violation() -> None:
    study = three_link_study(3)
    force = InPlane(2.0, np.array([0.0, 1.0, 0.0]))
    study = replace(study, experiments=replace(study.experiments, force=force))
    out = np.array([[2.0, 0.0, 0.0], [0.0, 0.1, -1.0]])
    cases = at([[10.0, 60.0, 30.0]] * 2, DOWN)
    wrench = np.hstack([out, np.zeros((2, 3))])
    (doubt,) = assess(study, LoadCases(cases.q, wrench), np.ones(2)).violations
    assert worded(doubt) == "load case 2 has a force out of the plane by 5.711°"


def tilted(degrees: float) -> Array:
    return np.array([np.sin(np.radians(degrees)), 0.0, -np.cos(np.radians(degrees))])


def test_the_nearest_constraint_is_the_one_with_the_least_room() -> None:
    """J2 stands 2° below its upper limit, then J3 3° above its lower one."""
    study = three_link_study(3)
    cases = at([[10.0, 178.0, 30.0], [10.0, 60.0, -177.0]], DOWN)
    near = assess(study, cases, np.array([2, 1])).nearest
    assert [one.name for one in near] == ["J2 <= 180°", "J3 >= -180°"]
    assert [one.unit for one in near] == ["rad", "rad"]
    np.testing.assert_allclose([one.margin for one in near], np.radians([2.0, 3.0]))
    room = room_at(study.joint_limits, Posture(study.robot, cases.q))
    assert room.shape == (6, 2)
    np.testing.assert_allclose(room.min(axis=0), [one.margin for one in near])


def test_a_broken_limit_is_a_violation() -> None:
    broken = assess(three_link_study(3), at([[10.0, 60.0, 30.0], [0, 181.5, 30]], DOWN), np.ones(2))
    assert broken.nearest[1].margin == pytest.approx(np.radians(-1.5))
    (doubt,) = broken.violations
    assert (doubt.code, doubt.about) == ("constraint-broken", ("J2 <= 180°",))
    assert doubt.numbers == {"load_case": 2, "by": pytest.approx(np.radians(1.5))}


@pytest.mark.parametrize(
    ("force", "count"),
    [(tilted(8.0), 0), (2.0 * tilted(8.0), 0), (np.zeros(3), 0), (2.0 * tilted(12.0), 1),
     (2.1 * tilted(8.0), 1), (2.1 * tilted(12.0), 2)],
)  # fmt: skip
def test_a_force_must_be_in_the_cone_and_not_too_large(force: Array, count: int) -> None:
    found = assess(cone(), at([[10.0, 60.0, 30.0]], force), np.ones(1)).violations
    assert len(found) == count, found
    outside = [doubt.numbers for doubt in found if doubt.code == "load-outside-cone"]
    if np.linalg.norm(force) and np.degrees(np.arccos(-force[2] / np.linalg.norm(force))) > 10.0:
        assert outside == [{"load_case": 1, "by": pytest.approx(np.radians(2.0))}]
    else:
        assert not outside


def test_rho0_of_one_pose_is_the_trace_by_hand() -> None:
    """Three load cases measured 2, 3 and 1 times: ρ0² = tr(A0 (Σ m A'A)⁻¹ A0')."""
    from elastocal.elastic.regressor import regressor

    study = three_link_study(6)
    cases = at(
        [[0.0, 60.0, 30.0], [20.0, -40.0, 80.0], [70.0, 10.0, -50.0]], np.array([0.6, 0, 0.8])
    )
    repeats = np.array([2, 3, 1])
    rows = regressor(study.arm, cases)[:, :3]
    total = sum(m * block.T @ block for m, block in zip(repeats, rows, strict=True))
    a0 = study.test_poses[0].regressor
    found = assess(study, cases, repeats)
    assert found.rho0 == pytest.approx(np.sqrt(np.trace(a0 @ np.linalg.inv(total) @ a0.T)))
    np.testing.assert_allclose(found.standard_error, np.sqrt(np.diag(np.linalg.inv(total))))
    np.testing.assert_allclose(found.information, total, atol=1e-14)
    assert found.rho0_each == (pytest.approx(found.rho0),)
    assert found.identifiable
    assert not assess(study, at([[0.0, 60.0, 30.0]], DOWN), np.array([6])).identifiable


def test_compliances_that_are_hardly_known_are_named() -> None:
    robot = ec.load_robot("three-link")
    springs = ec.joint_springs(robot)
    assert not list(hardly_known(springs, np.array([1e-9, 9e-5, np.inf])))
    (doubt,) = hardly_known(springs, np.array([1e-9, 4.23e-4, 3.3e-4]))
    assert (doubt.code, doubt.about, doubt.unit) == ("hardly-known", ("J2", "J3"), "rad/(N·m)")
    assert worded(doubt).startswith(
        "J2, J3: will not be known, with standard errors of 420, 330 µrad/(N·m)"
    )
