"""Shells hold what they are put around, and never say more distance than there is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from elastocal.constraints.cell import CollisionRules, clearances, default_clearances
from elastocal.constraints.clearance import Clearance
from elastocal.constraints.collision.chain import robot_solids, solids_at_hand
from elastocal.constraints.collision.distance import Pairs, nearest
from elastocal.constraints.collision.shell import MOST, box_shell, enclosing
from elastocal.constraints.collision.solid import around, enclosed, solids_of
from elastocal.robot.chain import Robot, Tool, transform
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import kuka_kr270
from tests.arms import random_rotation
from tests.constraints.test_default import upright

ROD = Tool("rod", np.array([0.0, 0.0, 0.1]), np.array([[0.0, 0.0, 0.1]]), ("M",))


def cloud(seed: int, count: int, sides: tuple[float, ...], round_: bool) -> np.ndarray:
    """Points of a hull: round or not, flat or long, turned any way."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(count, 3))
    if round_:
        points /= np.linalg.norm(points, axis=1)[:, None]
    return points * sides @ random_rotation(rng).T + rng.uniform(-1.0, 1.0, 3)


@settings(deadline=None, max_examples=60)
@given(
    st.integers(0, 10**6),
    st.integers(5, 300),
    st.tuples(*[st.sampled_from([1e-4, 0.01, 0.1, 1.0, 3.0])] * 3),
    st.booleans(),
)
def test_a_shell_holds_every_point(
    seed: int, count: int, sides: tuple[float, ...], round_: bool
) -> None:
    points = cloud(seed, count, sides, round_)
    faces, corners = enclosing(points)
    assert 6 <= len(faces) <= MOST
    assert len(corners) <= 2 * MOST
    assert np.linalg.norm(faces[:, :3], axis=1) == pytest.approx(1.0, abs=1e-12)
    assert (points @ faces[:, :3].T - faces[:, 3]).max() < 1e-9
    planes = ConvexHull(corners, qhull_options="QJ").equations
    assert (points @ planes[:, :3].T + planes[:, 3]).max() < 1e-5
    # Every face touches the hull, and the corners are where the faces meet.
    assert np.abs((points @ faces[:, :3].T).max(axis=0) - faces[:, 3]).max() < 1e-9
    assert (corners @ faces[:, :3].T - faces[:, 3]).max() < 1e-6


def test_few_faces_are_near_a_round_hull_and_those_of_a_block_are_its_own() -> None:
    ball = cloud(0, 2000, (1.0, 1.0, 1.0), True)
    faces, corners = enclosing(ball)
    assert len(faces) == MOST
    assert ConvexHull(corners).volume < 1.35 * ConvexHull(ball).volume
    block = box_shell(0, np.eye(4), np.array([0.5, 0.2, 0.1])).corners
    faces, corners = enclosing(block)
    assert len(faces) == 6
    assert np.sort(corners, axis=0) == pytest.approx(np.sort(block, axis=0), abs=1e-8)


def test_a_box_turned_in_its_mesh_gets_its_own_faces() -> None:
    turned = box_shell(
        0,
        transform(random_rotation(np.random.default_rng(2)), np.zeros(3)),
        np.array([0.5, 0.2, 0.1]),
    )
    faces, corners = enclosing(turned.corners)
    for normal in turned.faces[:, :3]:
        assert (faces[:, :3] @ normal).max() > 1.0 - 1e-9
    assert ConvexHull(corners).volume < 1.02 * 0.08


def bracket(folder: Path, name: str, length: float) -> Path:
    """An L-shaped link: along x from its joint, with an arm up at the end."""
    outline = np.array([[0.0, -0.1], [length, -0.1], [length, 0.5], [length - 0.15, 0.5]])
    outline = np.vstack([outline, [[length - 0.15, 0.1], [0.0, 0.1]]])
    points = [[x, y, z] for y in (-0.08, 0.08) for x, z in outline]
    sides = [[i, (i + 1) % 6, 6 + i] for i in range(6)]
    sides += [[(i + 1) % 6, 6 + (i + 1) % 6, 6 + i] for i in range(6)]
    caps = [[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]]
    faces = [*sides, *caps, *([6 + a, 6 + c, 6 + b] for a, b, c in caps)]
    mesh = trimesh.Trimesh(points, faces, process=False)
    mesh.export(folder / f"{name}.stl")
    return folder / f"{name}.stl"


@pytest.fixture
def arm(tmp_path: Path) -> Robot:
    """Two L-shaped links on a post, all meshes."""
    trimesh.creation.box((0.5, 0.4, 0.3), transform(None, (0, 0, 0.15))).export(tmp_path / "b.stl")
    trimesh.creation.cylinder(0.15, 0.4, transform=transform(None, (0, 0, 0.45))).export(
        tmp_path / "post.stl"
    )
    shapes = (
        Shape("mesh", np.ones(3), np.eye(4), 0, "foot", tmp_path / "b.stl"),
        Shape("mesh", np.ones(3), np.eye(4), 1, "post", tmp_path / "post.stl"),
        Shape("mesh", np.ones(3), np.eye(4), 2, "upper", bracket(tmp_path, "upper", 0.8)),
        Shape("mesh", np.ones(3), np.eye(4), 3, "fore", bracket(tmp_path, "fore", 0.9)),
    )
    return replace(upright(), collisions=shapes)


def in_all(robot: Robot, count: int = 400) -> Posture:
    rng = np.random.default_rng(4)
    return Posture(robot, rng.uniform(robot.lower, robot.upper, (count, len(robot.joints))))


def test_shells_are_between_capsules_and_hulls(arm: Robot) -> None:
    """Never farther apart than coal says of the hulls, never nearer than the capsules."""
    posture = in_all(arm)
    hulls = robot_solids(arm)
    closer = []
    for i, j in ((2, 0), (3, 0), (3, 1), (3, 2)):
        gaps = [
            nearest(Pairs((put(hulls[i]), put(hulls[j])), ((0, 1),)), posture, np.inf).distance
            for put in (around, enclosed, lambda solid: solid)
        ]
        assert (gaps[1] >= gaps[0] - 1e-9).all()
        assert (gaps[1] <= gaps[2] + 1e-6).all()
        closer.append((gaps[2] - gaps[1]).max() / max((gaps[2] - gaps[0]).max(), 1e-3))
    assert max(closer) < 0.9
    # Where a face and a corner are nearest, they are as far apart as coal says.
    assert np.abs(gaps[2] - gaps[1]).min() < 1e-6


def share(constraints: tuple[Clearance, ...], posture: Posture) -> float:
    return float(np.mean(np.all([c.at(posture)[0] >= 0.0 for c in constraints], axis=0)))


def test_more_is_feasible_and_the_names_are_the_same(arm: Robot) -> None:
    posture, limits = in_all(arm), np.array([arm.lower, arm.upper])
    rules = CollisionRules(floor=0.0, as_capsules=True)
    capsules = clearances(arm, ROD, limits, (), rules)
    hulls = clearances(arm, ROD, limits, (), CollisionRules(floor=0.0))
    usual = default_clearances(arm, ROD)
    least, found, most = (share(c, posture) for c in (capsules, usual, hulls))
    assert least + 0.5 * (most - least) < found <= most
    names = [{s.name for c in kind for s in c.pairs.solids} for kind in (usual, hulls)]
    assert names[0] == names[1] == {"foot", "post", "upper", "fore", "tool", "floor"}
    told = [{(u.first, u.second) for u in c.unwatched} for kind in (usual, hulls) for c in kind]
    assert told[:2] == told[2:]
    assert all(c.pairs.closed for c in usual)  # no package is needed to measure them


def test_the_floor_is_as_far_as_the_lowest_corner(arm: Robot) -> None:
    posture = in_all(arm)
    floor, _ = default_clearances(arm, ROD)
    hulls = clearances(
        arm, ROD, np.array([arm.lower, arm.upper]), (), CollisionRules(itself=False, floor=0.0)
    )[0]
    found, exact = floor.room(posture), hulls.room(posture)
    assert (found <= exact + 1e-6).all()
    assert (exact - found).max() < 0.01


def test_what_has_no_shapes_has_no_faces() -> None:
    """The example and its plan are as they were: capsules along the chain."""
    robot = kuka_kr270()
    for clearance in default_clearances(robot, robot.tools["calibration"]):
        assert not clearance.pairs.faced.any()


@pytest.mark.parametrize(("kind", "size"), [("sphere", [0.1]), ("capsule", [0.1, 0.3])])
def test_round_solids_are_their_own_capsule(kind: str, size: list[float]) -> None:
    (solid,) = solids_of(Shape(kind, np.array(size), np.eye(4), 2, "link"), "link")
    assert len(enclosed(solid).faces) == 0


def test_a_sheet_counts_as_a_box(tmp_path: Path) -> None:
    flat = np.array([[0.0, 0.0, 0.0], [0.7, 0.0, 0.0], [0.7, 0.3, 0.0], [0.0, 0.3, 0.0]])
    trimesh.Trimesh(flat, [[0, 1, 2], [0, 2, 3]]).export(tmp_path / "sheet.stl")
    shape = Shape("mesh", np.ones(3), np.eye(4), 2, "sheet", tmp_path / "sheet.stl")
    robot = replace(upright(), collisions=(shape,))
    (sheet,), *_ = solids_at_hand(robot)
    assert len(sheet.faces) == 6
    assert np.ptp(sheet.corners, axis=0) == pytest.approx([0.701, 0.301, 0.001], abs=1e-6)
