"""Known poses: a right model fits, and every mistake of convention is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.errors import Doubt, InputError
from elastocal.robot.chain import Joint, Robot, transform
from elastocal.robot.controller_axes import Coupling, coupling, uncoupled
from elastocal.robot.conventions import Convention, conventions
from elastocal.robot.pose_check import KnownPose, PoseCheck, check_known_poses
from elastocal.robot.posture import Posture
from elastocal.robot.sources import kuka_kr270
from elastocal.wording.poses import explained

ROBOT = kuka_kr270()
POINT = np.array([0.9, 0.2, -0.1])
Q = np.radians([[0, -90, 90, 0, 10, 0], [-30, -60, 110, 40, 50, 20], [25, -100, 80, -60, -40, 99]])


def poses(table: Coupling, q: Array = Q, scale: float = 1.0, shift: float = 0.0) -> list[KnownPose]:
    """What the controller with `table` shows, to a fraction of a millimetre."""
    noise = np.random.default_rng(0).normal(scale=3e-4, size=(len(q), 3))
    places = (Posture(ROBOT, q).point(POINT).T + noise) * scale + [0.0, 0.0, shift]
    return [
        KnownPose(f"p{i}", shown, place, POINT)
        for i, (shown, place) in enumerate(zip(table.to_controller(q), places, strict=True))
    ]


def checked(table: Coupling, assumed: Coupling | None = None) -> PoseCheck:
    return check_known_poses(ROBOT, assumed or uncoupled(ROBOT), poses(table))


def test_the_right_model_fits() -> None:
    table = coupling(ROBOT, signs={"A2": -1}, offsets={"A2": 1.0}, couple={"A3": {"A2": 1.0}})
    found = checked(table, table)
    assert found.fits
    assert found.largest < 2e-3
    assert found.explanations == ()
    assert found.untold == ()


@pytest.mark.parametrize("joint", ROBOT.joint_names)
def test_a_wrong_sign_is_named(joint: str) -> None:
    found = checked(coupling(ROBOT, signs={joint: -1}))
    assert not found.fits
    assert found.explanations == ((Doubt("counts-other-way", (joint,), (), {"sign": -1}),),)
    assert found.left_over < 2e-3


@pytest.mark.parametrize("degrees", [90, -90, 180])
def test_a_zero_elsewhere_is_named(degrees: float) -> None:
    found = checked(coupling(ROBOT, offsets={"A3": np.radians(degrees)}))
    ((mistake,), *_) = found.explanations
    assert (mistake.code, mistake.about) == ("zero-elsewhere", ("A3",))
    assert mistake.numbers["offset"] == pytest.approx(np.radians(degrees))


@pytest.mark.parametrize("factor", [1.0, -1.0])
def test_a_coupled_joint_is_named(factor: float) -> None:
    found = checked(coupling(ROBOT, couple={"A3": {"A2": factor}}))
    assert found.explanations[0] == (coupled(factor),)


def coupled(factor: float) -> Doubt:
    """The mistake that A3 is coupled to A2 by `factor`."""
    return Doubt("coupled", ("A3", "A2"), (), {"factor": factor})


def test_the_mend_that_is_proposed_mends() -> None:
    """Also where something is set already."""
    true = coupling(ROBOT, signs={"A3": -1}, offsets={"A3": 0.4}, couple={"A3": {"A2": 1.0}})
    assumed = coupling(ROBOT, signs={"A3": -1}, offsets={"A3": 0.4})
    assert checked(true, assumed).explanations[0] == (coupled(1.0),)
    assumed = coupling(ROBOT, signs={"A3": -1}, offsets={"A3": 0.4}, couple={"A3": {"A2": 2.0}})
    assert checked(true, assumed).explanations[0] == (coupled(1.0),)
    assumed = coupling(ROBOT, couple={"A3": {"A2": 1.0}})
    assert checked(uncoupled(ROBOT), assumed).explanations[0] == (coupled(0.0),)


def test_two_mistakes_are_named_together() -> None:
    found = checked(coupling(ROBOT, signs={"A1": -1, "A3": -1}))
    assert found.explanations[0] == tuple(
        Doubt("counts-other-way", (joint,), (), {"sign": -1}) for joint in ("A1", "A3")
    )


@pytest.mark.parametrize(
    ("scale", "shift", "code"),
    [(1e-3, 0.0, "in-metres"), (1 / 25.4, 0.0, "in-inches"), (1.0, 0.6, "base-elsewhere")],
)
def test_wrong_units_and_another_base_are_named(scale: float, shift: float, code: str) -> None:
    found = check_known_poses(ROBOT, uncoupled(ROBOT), poses(uncoupled(ROBOT), Q, scale, shift))
    assert [mistake.code for mistake in found.explanations[0]] == [code]
    if shift:
        by = [found.explanations[0][0].numbers[name] for name in "xyz"]
        np.testing.assert_allclose(by, [0.0, 0.0, shift], atol=1e-3)


def test_radians_for_degrees_are_named() -> None:
    given = [replace(p, shown=np.radians(p.shown)) for p in poses(uncoupled(ROBOT))]
    found = check_known_poses(ROBOT, uncoupled(ROBOT), given)
    assert found.explanations[0] == (Doubt("in-radians"),)


def test_what_no_mistake_explains_is_not_explained() -> None:
    """A negative control: a model with wrong lengths."""
    given = poses(uncoupled(ROBOT))
    given[1] = replace(given[1], position=given[1].position + np.array([0.05, -0.08, 0]))
    found = check_known_poses(ROBOT, uncoupled(ROBOT), given)
    assert not found.fits
    assert found.explanations == ()
    assert found.left_over > 5e-3


def test_joints_that_the_poses_do_not_tell_are_listed() -> None:
    flat = np.radians([[0, -90, 90, 0, 0, 0], [0, -60, 90, 0, 0, 0]])
    found = check_known_poses(ROBOT, uncoupled(ROBOT), poses(uncoupled(ROBOT), flat))
    assert found.untold == ("A1", "A4", "A5", "A6")


def test_one_pose_is_too_few() -> None:
    with pytest.raises(InputError, match="at least two poses, found 1"):
        check_known_poses(ROBOT, uncoupled(ROBOT), poses(uncoupled(ROBOT), Q[:1]))
    with pytest.raises(InputError, match="the same joint values"):
        check_known_poses(ROBOT, uncoupled(ROBOT), poses(uncoupled(ROBOT), Q[[0, 0]]))


def slider() -> Robot:
    """Two slides and a turn, as on a gantry."""
    joints = (
        Joint("X", np.eye(4), np.array([1.0, 0.0, 0.0]), True, -1.0, 1.0),
        Joint("Y", np.eye(4), np.array([0.0, 1.0, 0.0]), True, -1.0, 1.0),
        Joint("C", np.eye(4), np.array([0.0, 0.0, 1.0]), False, -3.0, 3.0),
    )
    return Robot("gantry", joints, transform(None, (0.3, 0.0, 0.2)))


@pytest.mark.parametrize("joint", ["X", "Y", "C"])
def test_a_slide_that_counts_the_other_way_is_named(joint: str) -> None:
    """And nothing is said of its zero in degrees, nor of a coupling to it."""
    robot = slider()
    q = np.array([[0.1, 0.3, 0.5], [-0.4, 0.2, 1.4], [0.7, -0.6, -0.8]])
    shown = coupling(robot, signs={joint: -1}).to_controller(q)
    places = Posture(robot, q).point(POINT).T
    given = [
        KnownPose(f"p{i}", s, place, POINT)
        for i, (s, place) in enumerate(zip(shown, places, strict=True))
    ]
    found = check_known_poses(robot, uncoupled(robot), given)
    assert found.explanations == ((Doubt("counts-other-way", (joint,), (), {"sign": -1}),),)
    assert found.left_over < 1e-12
    wrong = Posture(robot, np.where(np.array(robot.joint_names) == joint, -q, q)).point(POINT).T
    np.testing.assert_allclose(found.deviations, wrong - places, atol=1e-14)
    assert found.largest == pytest.approx(np.linalg.norm(wrong - places, axis=1).max())


def test_what_is_told_is_not_called_untold() -> None:
    """The wrist reversed, seen by a TCP off its axis: found, so not said to be beyond telling."""
    found = checked(coupling(ROBOT, signs={"A6": -1}))
    assert found.explanations == ((Doubt("counts-other-way", ("A6",), (), {"sign": -1}),),)
    assert found.untold == ()
    on_axis = np.array([0.3, 0.0, 0.0])
    at_flange = [replace(p, point=on_axis) for p in poses(uncoupled(ROBOT))]
    places = Posture(ROBOT, Q).point(on_axis).T
    at_flange = [replace(p, position=x) for p, x in zip(at_flange, places, strict=True)]
    fitting = check_known_poses(ROBOT, uncoupled(ROBOT), at_flange)
    assert fitting.fits
    assert fitting.untold == ("A6",)
    wrong = check_known_poses(ROBOT, coupling(ROBOT, signs={"A1": -1}), at_flange)
    assert wrong.explanations == ((Doubt("counts-other-way", ("A1",), (), {"sign": 1}),),)
    assert wrong.untold == ()  # asked of a model that fits


@pytest.mark.parametrize("shift", [0.0, 0.67])
def test_all_signs_at_once_with_a_coupling_are_named(shift: float) -> None:
    """As where a DH table meets a controller that counts its own way; the base elsewhere, too."""
    joints = ("A3", "A4", "A5", "A6")
    true = coupling(ROBOT, signs=dict.fromkeys(joints, -1), couple={"A3": {"A2": -1.0}})
    rng = np.random.default_rng(1)
    q = rng.uniform(0.4 * ROBOT.lower, 0.4 * ROBOT.upper, (12, 6))
    found = check_known_poses(ROBOT, uncoupled(ROBOT), poses(true, q, shift=shift))
    first = found.explanations[0]
    assert {d.about for d in first if d.code == "counts-other-way"} == {(j,) for j in joints}
    assert coupled(-1.0) in first
    assert (first[-1].code == "base-elsewhere") == (shift > 0.0)
    assert found.left_over < 2e-3
    assert found.untold == ()
    text = explained(first)
    assert text.count("counts the other way") == 4
    assert text.count(" and ") == 1


def test_every_convention_is_tried_once() -> None:
    assumed = Convention.of(coupling(ROBOT, couple={"A3": {"A2": 1.0}}))
    every = list(conventions(ROBOT, assumed, range(6)))
    assert len(every) == 3 * 2**6
    assert not every[0].mistakes(assumed)
    seen = {(tuple(c.signs), c.mixing[2, 1]) for c in every}
    assert len(seen) == len(every)
    assert {factor for _, factor in seen} == {-1.0, 0.0, 1.0}
