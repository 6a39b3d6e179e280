"""Coupling: there and back, the presets, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastocal.errors import InputError
from elastocal.robot.chain import Joint, Robot, transform
from elastocal.robot.controller_axes import Coupling, coupling, shown_values, uncoupled
from elastocal.robot.posture import forward_kinematics
from elastocal.robot.sources import kuka_kr270, three_link

ROBOT = kuka_kr270()


@given(
    st.lists(st.sampled_from([1, -1]), min_size=6, max_size=6), st.floats(-2, 2), st.floats(-3, 3)
)
def test_there_and_back(signs: list[int], factor: float, offset: float) -> None:
    names = ROBOT.joint_names
    table = coupling(
        ROBOT,
        signs=dict(zip(names, signs, strict=True)),
        offsets={"A2": offset},
        couple={"A3": {"A2": factor}},
    )
    q = np.random.default_rng(0).normal(size=(20, 6))
    assert table.to_model(table.to_controller(q)) == pytest.approx(q, abs=1e-12)


def test_every_part_does_what_it_says() -> None:
    q = np.array([[0.1, -0.2, 0.3, 0.4, 0.5, 0.6]])
    assert uncoupled(ROBOT).is_identity
    assert np.array_equal(uncoupled(ROBOT).to_controller(q), q)
    table = coupling(ROBOT, signs={"A1": -1}, offsets={"A2": 1.0}, couple={"A3": {"A2": 1.0}})
    assert not table.is_identity
    # A3 is coupled to the value of A2 that the controller shows, its offset included.
    assert table.to_controller(q)[0] == pytest.approx([-0.1, 0.8, 1.1, 0.4, 0.5, 0.6])


def arm(third_axis: float) -> Robot:
    """An upright arm whose J2 leans forward; J3 turns with it (1) or against it (-1)."""
    joints = (
        Joint("J1", np.eye(4), np.array([0.0, 0.0, 1.0])),
        Joint("J2", transform(None, (0.3, 0, 0.5)), np.array([0.0, 1.0, 0.0])),
        Joint("J3", transform(None, (0, 0, 1.0)), np.array([0.0, third_axis, 0.0])),
    )
    return Robot("arm", joints, transform(None, (1.0, 0, 0)))


@pytest.mark.parametrize("third_axis", [1.0, -1.0])
def test_on_a_fanuc_j2_alone_leaves_the_forearm_level(third_axis: float) -> None:
    robot = arm(third_axis)
    table = coupling(robot, preset="fanuc")
    shown = np.array([[0.0, 0.0, 0.0], [0.0, 0.7, 0.0], [0.0, 0.7, 0.4]])
    pose = forward_kinematics(robot, table.to_model(shown))
    forearm = pose[:, :3, 0]
    assert forearm[:2] == pytest.approx(np.array([[1, 0, 0], [1, 0, 0]]), abs=1e-12)
    assert forearm[2] == pytest.approx([np.cos(0.4), 0, np.sin(0.4)])  # J3 lifts


def test_what_is_given_replaces_the_preset() -> None:
    table = coupling(arm(1.0), preset="fanuc", signs={"J3": 1}, couple={"J3": {"J2": 1}})
    assert table.matrix[2] == pytest.approx([0, 1, 1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"signs": {"A9": 1}}, "has no joint 'A9'; its joints are A1, A2"),
        ({"signs": {"A1": 2}}, "sign of joint 'A1': expected 1 or -1, found 2"),
        ({"couple": {"A3": {"A8": 1}}}, "has no joint 'A8'"),
        ({"couple": {"A3": {"A3": 1}}}, "'A3' cannot be coupled to itself"),
        ({"couple": {"A3": {"A2": 1}, "A2": {"A3": 1}}}, "the coupling cannot be inverted"),
        ({"offsets": {"A3": np.nan}}, "the coupling has a number that is not finite"),
        ({"preset": "fanux"}, "no controller preset 'fanux'; there are fanuc"),
    ],
)
def test_a_wrong_coupling_is_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        coupling(ROBOT, **arguments)  # type: ignore[arg-type]


def test_joints_of_two_kinds_are_not_coupled() -> None:
    rail = Joint("E1", np.eye(4), np.array([1.0, 0, 0]), True)
    robot = Robot("rail", (rail, *kuka_kr270().joints))
    with pytest.raises(InputError, match="'A1' and 'E1' cannot be coupled: one turns"):
        coupling(robot, couple={"A1": {"E1": 1.0}})


def test_a_preset_says_when_it_does_not_fit() -> None:
    robot = three_link()
    with pytest.raises(InputError, match="'fanuc' needs three turning joints, found 2"):
        coupling(Robot("two", robot.joints[:2]), preset="fanuc")
    crossed = (*robot.joints[:2], Joint("J3", np.eye(4), np.array([1.0, 0, 0])))
    with pytest.raises(InputError, match="parallel axes of 'J2' and 'J3'; theirs are 90° apart"):
        coupling(Robot("crossed", crossed), preset="fanuc")


def test_a_coupling_has_the_shape_of_its_joints() -> None:
    with pytest.raises(InputError, match="2 joints needs a 2x2 matrix and 2 offsets, found 3x3"):
        Coupling(("A", "B"), np.eye(3), np.zeros(2))


def test_what_the_controller_shows_is_said_in_values_of_the_model() -> None:
    assert shown_values(ROBOT, uncoupled(ROBOT)) == {}
    fanuc = shown_values(arm(1.0), coupling(arm(1.0), preset="fanuc"))
    assert fanuc == {"J3": "-J3 - J2"}
    assert shown_values(arm(-1.0), coupling(arm(-1.0), preset="fanuc")) == {"J3": "J3 - J2"}
    table = coupling(
        ROBOT,
        signs={"A1": -1, "A5": -1},
        offsets={"A2": np.radians(90), "A5": -0.5 * np.pi},
        couple={"A3": {"A2": 0.5}, "A6": {"A5": 1.0, "A4": 1.0}},
    )
    assert shown_values(ROBOT, table) == {
        "A1": "-A1",
        "A2": "A2 + 90°",
        "A3": "A3 + 0.5 · A2 + 45°",
        "A5": "-A5 - 90°",
        "A6": "A6 + A4 - A5 - 90°",
    }
