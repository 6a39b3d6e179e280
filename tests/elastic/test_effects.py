"""What gives way in an arm besides its joints: where it is, and what its columns are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.effects import Effects, Size, besides, effects_of, tilt_of
from elastocal.elastic.springs import VirtualJoints, subset
from elastocal.elastic.typical import typical_sizes
from elastocal.errors import InputError
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.posture import Posture
from elastocal.robot.sources import USUAL, from_dh
from tests.elastic.tables import row

KR270 = ec.load_robot("kuka-kr270")
TOOL = Tool("any", np.array([0.4, 0.1, -0.3]), np.array([[0.2, 0.3, 0.1]]), ("M",), rotation=True)
RNG = np.random.default_rng(3)
CASES = ec.LoadCases(RNG.uniform(-2.0, 2.0, (4, 6)), RNG.normal(size=(4, 6)))
ONE = Size(1.0, "one")


def typical(robot: Robot = KR270) -> Effects:
    return effects_of(robot, typical_sizes(robot, np.array(USUAL["kuka-kr270"])))


def rows(effects: Effects) -> np.ndarray:
    arm = ec.ElasticArm(KR270, effects.unknowns.springs, TOOL)
    return effects.unknowns.columns(ec.regressor(arm, CASES))


def twists(body: int, axes: np.ndarray, origin: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What unit turns about axes of a body do: (N, 6, A) to the marker, (N, A) to the load."""
    posture = Posture(KR270, CASES.q)
    turn = np.stack([posture.direction(axis, body).T for axis in axes], axis=2)
    at = posture.point(origin, body).T[:, :, None]
    load, marker = (posture.point(p).T[:, :, None] for p in (TOOL.load_point, TOOL.markers[0]))
    moved = np.concatenate([np.cross(turn, marker - at, axis=1), turn], axis=1)
    force, moment = CASES.wrench[:, :3, None], CASES.wrench[:, 3:, None]
    pushed = np.cross(turn, load - at, axis=1)
    return moved, (pushed * force + turn * moment).sum(axis=1)


def test_a_bearing_is_the_sum_of_its_two_tilts() -> None:
    found = rows(effects_of(KR270, {tilt_of("A5"): ONE}))
    v, y = twists(5, np.eye(3)[:2], np.zeros(3))
    np.testing.assert_allclose(found[:, :, 0], (v * y[:, None]).sum(axis=2), rtol=0, atol=1e-12)


def test_a_long_link_is_a_symmetric_tensor() -> None:
    effects = effects_of(KR270, {tilt_of("A3"): ONE})
    assert effects.unknowns.names == ("tilt A3 x", "tilt A3 y", "tilt A3 xy")
    np.testing.assert_allclose(effects.deviation, [1.0, 1.0, np.sqrt(0.5)])
    np.testing.assert_array_equal(effects.signed, [False, False, True])
    v, y = twists(3, np.eye(3)[:2], np.zeros(3))
    v1, v2, y1, y2 = v[:, :, 0], v[:, :, 1], y[:, :1], y[:, 1:]
    expected = np.stack([v1 * y1, v2 * y2, v1 * y2 + v2 * y1], axis=2)
    np.testing.assert_allclose(rows(effects), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("angle", [0.3, 1.0, 2.5])
def test_nothing_depends_on_which_axes_across_a_joint_are_taken(angle: float) -> None:
    """N T Nᵀ is all that counts of unknowns with the prior T."""
    effects, s = typical(), np.sin(angle)
    springs, turn = effects.unknowns.springs, np.array([[np.cos(angle), -s], [s, np.cos(angle)]])
    tilts = np.array([name.startswith("tilt") for name in springs.names])
    axis = np.array(springs.axis)
    axis[tilts, :2] = axis[tilts, :2] @ turn
    turned = replace(effects.unknowns, springs=replace(springs, axis=axis))
    one, other = (
        n.reshape(-1, len(effects.deviation)) * effects.deviation
        for n in (rows(effects), rows(replace(effects, unknowns=turned)))
    )
    assert np.abs(one - other).max() > 0.1 * np.abs(one).max()
    np.testing.assert_allclose(
        other @ other.T, one @ one.T, rtol=0, atol=1e-9 * (one @ one.T).max()
    )


def test_no_tilt_is_about_the_axis_of_its_own_joint() -> None:
    springs = typical().unknowns.springs
    for name, body, axis, origin in zip(
        springs.names, springs.body, springs.axis, springs.origin, strict=True
    ):
        if name.startswith("tilt"):
            assert body == KR270.joint_names.index(name[5:7]) + 1
            assert axis[2] == 0.0
            np.testing.assert_array_equal(origin[:2], 0.0)


def test_foot_and_first_bearing_are_one_where_they_share_their_axes() -> None:
    effects = typical()
    name, *others = effects.unknowns.names
    assert name == "foot turning and tilt A1"
    assert "tilt A1" not in others
    assert len(effects.unknowns) == 16
    assert len(effects.unknowns.springs) == 20
    foot, first = (rows(effects_of(KR270, {n: ONE})) for n in ("foot turning", "tilt A1"))
    np.testing.assert_allclose(foot, first, rtol=0, atol=1e-12)
    sizes = typical_sizes(KR270, np.array(USUAL["kuka-kr270"]))
    expected = np.hypot(sizes["foot turning"].deviation, sizes["tilt A1"].deviation)
    np.testing.assert_allclose(effects.deviation[:1], expected, rtol=1e-9)


def test_they_stay_apart_where_the_joint_stands_higher() -> None:
    higher = [row("J1", d=0.5), row("J2", alpha=np.pi / 2), row("J3", a=0.8)]
    robot = from_dh("higher", higher, modified=True)
    names = effects_of(robot, {"foot turning": ONE, "tilt J1": ONE}).unknowns.names
    assert names == ("foot turning", "tilt J1")


def test_feet_and_tools_slide_along_three_axes() -> None:
    effects = effects_of(KR270, {"foot sliding": ONE, "tool sliding": ONE})
    springs: VirtualJoints = effects.unknowns.springs
    assert springs.prismatic.all()
    np.testing.assert_array_equal(springs.body, [0, 0, 0, 6, 6, 6])
    posture = Posture(KR270, CASES.q)
    flange = np.stack([posture.direction(axis).T for axis in np.eye(3)], axis=2)
    force = CASES.wrench[:, :3, None]
    expected = flange * (flange * force).sum(axis=1, keepdims=True)
    np.testing.assert_allclose(rows(effects)[:, :3, 3:], expected, rtol=0, atol=1e-12)


def test_a_tensor_of_which_an_axis_is_identified_has_no_coupling() -> None:
    """Half of a tensor could not be told from one that moves against the load."""
    effects = effects_of(KR270, {"tilt A3": ONE})
    whole = effects.unknowns
    assert whole.names == ("tilt A3 x", "tilt A3 y", "tilt A3 xy")
    for axis in ("x", "y"):
        spring = subset(whole.springs, [f"tilt A3 about {axis}"])
        left = besides(KR270, effects, spring).unknowns
        (other,) = {"x", "y"} - {axis}
        assert left.names == (f"tilt A3 {other}",)
        assert left.springs.names == (f"tilt A3 about {other}",)
        np.testing.assert_array_equal(left.make, [[1.0]])
    between = subset(whole.springs, ["tilt A3 about between"])
    assert besides(KR270, effects, between).unknowns.names == whole.names


def test_what_is_zero_is_left_out() -> None:
    assert not len(effects_of(KR270, {"foot turning": Size(0.0, "")}).unknowns)


@pytest.mark.parametrize(
    ("name", "words"), [("foot", "no effect 'foot'"), ("tilt slide", "'slide' slides")]
)
def test_what_cannot_be_is_refused(name: str, words: str) -> None:
    robot = from_dh("any", [row("slide", prismatic=True), row("J2")], modified=True)
    with pytest.raises(InputError, match=words):
        effects_of(robot, {name: ONE})
