"""Compensation with a calibrated robot: geometry and sag at once, to where its drawing would go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.arrays import Array
from elastocal.calibration.arm_model import loaded_arm, stepped
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.calibration.parameters import step_of
from elastocal.calibration.placed import carried_point
from elastocal.compensation.calibrated import compensate_calibrated
from elastocal.elastic.equilibrium import equilibrium
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.elastic.unknowns import each_spring
from elastocal.robot.chain import Robot, moved
from elastocal.robot.shapes import BodyMass
from tests.arms import random_chain
from tests.calibration.random_calibrated import TOOL, calibrated_as

KR270 = ec.load_robot("kuka-kr270")
RNG = np.random.default_rng


def heavy(robot: Robot, rng: np.random.Generator) -> Robot:
    masses = [
        BodyMass(b, rng.uniform(1.0, 20.0), 0.2 * rng.normal(size=3))
        for b in range(1, robot.bodies)
    ]
    return replace(robot, masses=tuple(masses))


def task(rng: np.random.Generator, joints: int, count: int = 6) -> LoadCases:
    q = rng.uniform(-1.0, 1.0, (count, joints))
    return LoadCases(
        q, np.hstack([50.0 * rng.normal(size=(count, 3)), rng.normal(size=(count, 3))])
    )


def flange(robot: Robot, q: Array) -> Array:
    """(4, 4) a plain product."""
    T = np.eye(4)
    for joint, value in zip(robot.joints, q, strict=True):
        T = T @ joint.T_parent_joint @ moved(joint, value)
    return T @ robot.T_tip_flange


def bent(calibrated: CalibratedRobot, q: Array, wrench: Array, payload: int) -> Array:
    """(4, 4) flange of the calibrated robot at rest under its loads, as a plain product."""
    arm = loaded_arm(calibrated.model, calibrated.state, calibrated.robot, payload)
    springs = calibrated.model.compliances.make @ calibrated.state.compliance
    rest = equilibrium(arm, springs, LoadCases(q[None], wrench[None]))
    return flange(arm.chain, arm.bent(q[None], rest.displacement)[0])


@pytest.mark.parametrize(
    "slides",
    [[False] * 6, [True, False, False, True, False, False], [False] * 7, [False, True, False]],
    ids=["6R", "two sliding", "7R", "three joints"],
)
def test_the_loaded_robot_is_where_the_drawing_has_it(slides: list[bool]) -> None:
    rng = RNG(len(slides) + sum(slides))
    calibrated = calibrated_as(rng, heavy(random_chain(rng, slides), rng))
    cases = task(rng, len(slides))
    done = compensate_calibrated(calibrated, cases, payload=0)
    carried = carried_point(calibrated)
    assert done.converged.any()
    for i in np.flatnonzero(done.converged & ~done.damped):
        wanted = flange(calibrated.model.robot, cases.q[i])
        found = bent(calibrated, done.q[i], cases.wrench[i], 0)
        assert (found @ [*carried.point, 1.0])[:3] == pytest.approx(
            (wanted @ [*TOOL.tcp, 1.0])[:3], abs=1e-9
        )
        if len(slides) >= 6:
            assert found[:3, :3] @ carried.rotation == pytest.approx(wanted[:3, :3], abs=1e-9)
        before = bent(calibrated, cases.q[i], cases.wrench[i], 0) @ [*carried.point, 1.0]
        assert done.before[i] == pytest.approx(
            before[:3] - (wanted @ [*TOOL.tcp, 1.0])[:3], abs=1e-9
        )
        told = flange(calibrated.model.robot, done.q[i]) @ [*TOOL.tcp, 1.0]
        assert done.command[i, :3, 3] == pytest.approx(told[:3], abs=1e-12)
    assert np.linalg.norm(done.before[done.converged], axis=1).max() > 1e-4


def test_a_rigid_robot_with_errors() -> None:
    rng = RNG(5)
    whole = calibrated_as(rng, KR270)
    kept = [i for i, block in enumerate(whole.parameters.block) if block != "compliance"]
    model = replace(whole.model, compliances=each_spring(joint_springs(KR270, [])))
    p = whole.parameters
    parameters = replace(
        p,
        names=tuple(p.names[i] for i in kept),
        block=tuple(p.block[i] for i in kept),
        turns=tuple(p.turns[i] for i in kept),
        compliances=0,
        mean=np.zeros(0),
        held=p.held[kept],
    )
    calibrated = replace(
        whole,
        model=model,
        state=replace(whole.state, compliance=np.zeros(0)),
        parameters=parameters,
        covariance=whole.covariance[np.ix_(kept, kept)],
        seen=whole.seen[kept],
        open=np.zeros((0, len(kept))),
    )
    cases = LoadCases(np.array([[0.1, -1.2, 1.3, 0.2, 0.5, 0.3]]), np.zeros((1, 6)))
    done = compensate_calibrated(calibrated, cases)
    assert done.converged.all()
    found = flange(calibrated.robot, done.q[0]) @ [*carried_point(calibrated).point, 1.0]
    wanted = flange(KR270, cases.q[0]) @ [*TOOL.tcp, 1.0]
    assert found == pytest.approx(wanted, abs=1e-9)


def test_what_remains_is_what_robots_like_it_leave() -> None:
    """Drawn from the covariance: where the station sees the reflector, and where it should be."""
    rng = RNG(6)
    calibrated = calibrated_as(rng, KR270)
    u = len(calibrated.parameters)
    sizes = np.where(np.array(calibrated.parameters.block) == "compliance", 3e-8, 1e-4)
    sizes[calibrated.parameters.held] = 0.0
    root = sizes[:, None] * (rng.normal(size=(u, u)) + 3.0 * np.eye(u)) / np.sqrt(u)
    calibrated = replace(calibrated, covariance=root @ root.T)
    cases = LoadCases(
        np.array([[0.1, -1.2, 1.3, 0.2, 0.5, 0.3]]), np.array([[0, 0, -500.0, 0, 0, 0]])
    )
    done = compensate_calibrated(calibrated, cases, payload=0, point="R2")
    base, errors = calibrated.state.base[0], []
    wanted = (base @ done.target[0])[:3, 3]
    for values in rng.normal(size=(400, u)) @ root.T:
        step = step_of(calibrated.parameters, calibrated.state, values)
        one = replace(calibrated, state=stepped(calibrated.state, step))
        T = one.state.base[0] @ bent(one, done.q[0], cases.wrench[0], 0)
        errors.append((T @ [*one.state.markers[0, 1], 1.0])[:3] - wanted)
    found = np.array(errors) @ base[:3, :3]
    assert np.abs(found.mean(axis=0)).max() < 0.2 * done.rho0[0]
    assert np.sqrt((found**2).sum(axis=1).mean()) == pytest.approx(done.rho0[0], rel=0.1)
    spread = found.T @ found / len(found)
    assert np.abs(spread - done.covariance[0]).max() < 0.2 * np.trace(done.covariance[0])
    below = np.linalg.norm(found, axis=1) < done.limit
    assert 0.9 < below.mean() <= 1.0
    noise = np.sqrt(3.0) * calibrated.noise[0].model
    assert done.expected[0] == pytest.approx(np.hypot(done.rho0[0], noise), rel=1e-6)


def test_a_tcp_that_was_not_read_is_said() -> None:
    tool = replace(TOOL, markers=TOOL.markers[:1], marker_names=("R1",))
    calibrated = calibrated_as(RNG(7), KR270, tool=tool)
    cases = LoadCases(np.array([[0.1, -1.2, 1.3, 0.2, 0.5, 0.3]]), np.zeros((1, 6)))
    codes = [note.code for note in compensate_calibrated(calibrated, cases).notes]
    assert "tcp-not-read" in codes
    codes = [note.code for note in compensate_calibrated(calibrated, cases, point="R1").notes]
    assert "tcp-not-read" not in codes


@pytest.mark.parametrize(("size", "said"), [(1e-12, False), (1e4, True)])
def test_a_correction_that_may_be_worse_than_none_is_said(size: float, said: bool) -> None:
    calibrated = calibrated_as(RNG(9), KR270)
    unknown = size * np.eye(len(calibrated.parameters))
    cases = LoadCases(np.array([[0.1, -1.2, 1.3, 0.2, 0.5, 0.3]]), np.zeros((1, 6)))
    done = compensate_calibrated(replace(calibrated, covariance=unknown), cases, point="R1")
    assert ("no-better" in [note.code for note in done.notes]) == said


def test_a_tool_that_is_not_the_one_drawn_is_taken_as_found() -> None:
    """Reflectors a decimetre from their drawing: the arm does not go there to make up for it."""
    calibrated = calibrated_as(RNG(8), KR270)
    state = replace(calibrated.state, markers=calibrated.state.markers + 0.1)
    calibrated = replace(calibrated, state=state)
    cases = LoadCases(np.array([[0.1, -1.2, 1.3, 0.2, 0.5, 0.3]]), np.zeros((1, 6)))
    done = compensate_calibrated(calibrated, cases)
    assert [note.code for note in done.notes] == ["tool-elsewhere"]
    point = carried_point(calibrated).point
    wanted = flange(KR270, cases.q[0]) @ [*point, 1.0]
    found = bent(calibrated, done.q[0], np.zeros(6), -1) @ [*point, 1.0]
    assert found == pytest.approx(wanted, abs=1e-9)
    assert np.linalg.norm(done.before[0]) < 0.02
