"""URDFs with other origins, and new ones: read again by us and by Pinocchio, the same flange."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import elastocal as ec
from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.robot.chain import Robot, T_body_joint
from elastocal.robot.geometry import geometric_errors, with_errors
from elastocal.robot.posture import Posture
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.robot.shapes import BodyMass
from elastocal.robot.sinks.urdf import BASE, FLANGE, urdf_of
from elastocal.robot.sinks.urdf_origins import ChangedUrdf, with_origins
from elastocal.robot.sinks.urdf_words import roll_pitch_yaw
from elastocal.robot.sources.mesh_files import MeshFiles
from elastocal.robot.sources.urdf import parse_urdf
from tests.arms import random_chain
from tests.robot.sinks.drawn import drawn, ends_of
from tests.robot.sinks.test_dh import plain_flange, ur10
from tests.robot.sources.oracle import OWN, UrdfOracle
from tests.robot.sources.test_mimic_on_chain import ARM
from tests.robot.sources.test_mimic_on_chain import read as level_arm

NO_MESHES = MeshFiles(Path("/nowhere"), {})


def erring(robot: Robot, rng: np.random.Generator, size: float = 1e-3) -> Robot:
    errors = geometric_errors(robot)
    return with_errors(robot, errors, size * rng.normal(size=len(errors)))


def configurations(robot: Robot, rng: np.random.Generator) -> Array:
    return rng.uniform(-1.5, 1.5, (25, len(robot.joints)))


def flange(robot: Robot, q: Array) -> Array:
    """(4, 4) a plain product where nothing follows."""
    if robot.followers:
        frame = Posture(robot, q[None]).bodies[-1][:, :, 0]
        T = np.eye(4)
        T[:3] = frame.T
        return T
    return plain_flange(robot, q)


def by_us(text: str, base: str | None, tip: str) -> Robot:
    return parse_urdf(text.encode(), "written.urdf", NO_MESHES, base=base, tip=tip)


def compare(text: str, base: str | None, tip: str, robot: Robot, folder: Path) -> None:
    """The written robot, as we and as Pinocchio read it, against the one it was made from."""
    rng = np.random.default_rng(7)
    again = by_us(text, base, tip)
    path = folder / "written.urdf"
    path.write_text(text, "utf-8")
    root = base or re.findall(r'<link name="([^"]*)"', text)[0]
    theirs = UrdfOracle(path, root, tip)
    assert again.joint_names == robot.joint_names
    for q in configurations(robot, rng):
        expected = flange(robot, q)
        assert np.abs(flange(again, q) - expected).max() < 1e-9
        if not robot.followers:
            assert np.abs(theirs.forward(again, q) - expected).max() < 1e-9


def changed(path: Path, robot: Robot) -> ChangedUrdf:
    return with_origins(path.read_bytes(), str(path), drawn(path), robot, **ends_of(path))


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.stem)
def test_robots_of_files_with_errors(path: Path, tmp_path: Path) -> None:
    before = drawn(path)
    robot = erring(before, np.random.default_rng(1))
    found = changed(path, robot)
    base = ends_of(path).get("base") or re.findall(r'<link name="([^"]*)"', found.text)[0]
    compare(found.text, base, found.tip, robot, tmp_path)
    again = by_us(found.text, base, found.tip)
    assert again.name == before.name
    assert [(j.lower, j.upper) for j in again.joints] == [(j.lower, j.upper) for j in before.joints]
    assert sum(m.mass for m in again.masses) == sum(m.mass for m in before.masses)
    assert len(again.collisions) == len(before.collisions)


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.stem)
def test_only_origins_change(path: Path) -> None:
    """But for the numbers of origins, an added link and the first line, text stays text."""
    before = path.read_text("utf-8")
    found = changed(path, erring(drawn(path), np.random.default_rng(2)))
    added = r'  <link name="calibrated_flange"/>\n(  .*\n){5}'
    text = re.sub(added, "", found.text)
    changes = r'\s*(xyz|rpy)="[^"]*"|\s*<origin\s*/>|<\?xml.*\?>\n?'
    before, after = (re.sub(changes, "", t).strip() for t in (before, text))
    assert before == after


@pytest.mark.parametrize("path", OWN, ids=lambda path: path.stem)
def test_nothing_changes_without_errors(path: Path) -> None:
    found = changed(path, drawn(path))
    assert found.changed == ()
    assert path.read_text("utf-8").strip().endswith(found.text.partition("\n")[2].strip())


def test_weights_of_links_stay_on_their_links() -> None:
    """The torques of gravity are those of the robot with errors, but for what hangs on the tip."""
    path = next(p for p in OWN if p.stem == "cobot-ur10e")
    robot = erring(drawn(path), np.random.default_rng(3))
    found = changed(path, robot)
    again = by_us(found.text, None, found.tip)
    for one, other in zip(again.masses, robot.masses, strict=True):
        place = [np.linalg.inv(T_body_joint(r, m.body)) for r, m in ((again, one), (robot, other))]
        assert np.allclose(
            place[0] @ [*one.center, 1.0], place[1] @ [*other.center, 1.0], atol=1e-12
        )


def test_joints_that_follow() -> None:
    before = level_arm()
    robot = erring(before, np.random.default_rng(4))
    found = with_origins(ARM.encode(), "level.urdf", before, robot, tip="tool0")
    again = by_us(found.text, None, found.tip)
    for q in configurations(robot, np.random.default_rng(5)):
        assert np.abs(flange(again, q) - flange(robot, q)).max() < 1e-9
    assert again.followers[0].leader == before.followers[0].leader


def test_comments_quotes_encodings_and_namesakes() -> None:
    """What a text may have besides: none of it is touched, and none is taken for a joint."""
    text = """<?xml version="1.0" encoding="iso-8859-1"?>
<!-- arm of M\u00fcller > <joint name="a"> -->
<robot name='m\u00fcller' xmlns:x="http://nowhere">
  <link name="base"/><link name="l"/><link name="t"/>
  <joint name='a' type="revolute" note="a > b">
    <parent link="base"/><child link="l"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/>
  </joint>
  <joint name="e" type="fixed"><origin x:why="ours > theirs" rpy='0 1.570796327 0'
     /><parent link="l"/><child link="t"/></joint>
  <transmission name="tr"><joint name="a"><origin xyz="9 9 9"/></joint></transmission>
</robot>
"""
    data = text.encode("iso-8859-1")
    before = parse_urdf(data, "m.urdf", NO_MESHES)
    assert before.name == "m\u00fcller"
    robot = erring(before, np.random.default_rng(6))
    extension = ['<elastocal version="1"/>']
    found = with_origins(data, "m.urdf", before, robot, extension=extension)
    assert found.changed == ("e",)
    assert found.text.startswith('<?xml version="1.0" encoding="utf-8"?>\n<!-- arm of M\u00fcller')
    for words in ('x:why="ours > theirs"', '<origin xyz="9 9 9"/>', 'note="a > b"', *extension):
        assert words in found.text
    again = by_us(found.text, None, "t")
    q = np.array([0.3])
    assert np.abs(plain_flange(again, q) - plain_flange(robot, q)).max() < 1e-12


def test_another_urdf_is_refused() -> None:
    path = OWN[0]
    with pytest.raises(InputError, match="is not between"):
        with_origins(path.read_bytes(), str(path), ur10(), ur10(), **ends_of(path))


def test_new_ones(tmp_path: Path) -> None:
    for robot in (
        ec.load_robot("kuka-kr270"),
        ec.load_robot("three-link"),
        ur10(),
        erring(ur10(), np.random.default_rng(8)),
    ):
        compare(urdf_of(robot), None, FLANGE, robot, tmp_path)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**32 - 1), st.lists(st.booleans(), min_size=1, max_size=7))
def test_new_ones_of_any_chain(
    tmp_path_factory: pytest.TempPathFactory, seed: int, slides: list[bool]
) -> None:
    rng = np.random.default_rng(seed)
    robot = random_chain(rng, slides)
    masses = [
        BodyMass(int(b), rng.uniform(0.1, 9.0), rng.normal(size=3))
        for b in rng.integers(0, len(slides) + 1, 5)
    ]
    joints = [replace(j, lower=-2.0, upper=2.0) if j.prismatic else j for j in robot.joints]
    robot = replace(robot, joints=tuple(joints), masses=tuple(masses))
    text = urdf_of(robot)
    compare(text, BASE, FLANGE, robot, tmp_path_factory.mktemp("new"))
    again = by_us(text, BASE, FLANGE)
    for body in range(robot.bodies):
        own = [m for m in robot.masses if m.body == body]
        moment = np.sum([[m.mass, *(m.mass * m.center)] for m in own], axis=0)
        there = [m for m in again.masses if m.body == body]
        assert len(there) == (1 if own else 0)
        for m in there:
            assert np.allclose([m.mass, *(m.mass * m.center)], moment, atol=1e-12)


def test_new_ones_that_follow() -> None:
    robot = level_arm()
    again = by_us(urdf_of(robot), None, FLANGE)
    for q in configurations(robot, np.random.default_rng(9)):
        assert np.abs(flange(again, q) - flange(robot, q)).max() < 1e-12
    assert {f.joint.name for f in again.followers} == {f.joint.name for f in robot.followers}


def test_limits_that_no_urdf_says() -> None:
    robot = random_chain(np.random.default_rng(1), [True])
    with pytest.raises(InputError, match="needs both limits of a joint that slides"):
        urdf_of(robot)


@pytest.mark.parametrize("off", [0.0, 1e-12, 1e-9, 1e-7, 1e-4])
def test_angles_are_exact_also_upright(off: float) -> None:
    rng = np.random.default_rng(10)
    for sign in (-1.0, 1.0):
        for yaw, roll in rng.uniform(-np.pi, np.pi, (50, 2)):
            R = _zyx(yaw, sign * (np.pi / 2.0 - off), roll)
            r, p, y = roll_pitch_yaw(R)
            assert np.abs(_zyx(y, p, r) - R).max() < 1e-14


def _zyx(yaw: float, pitch: float, roll: float) -> Array:
    z, y, x = (
        from_rotation_vectors(np.eye(3)[i : i + 1] * v)[0]
        for i, v in ((2, yaw), (1, pitch), (0, roll))
    )
    return z @ y @ x
