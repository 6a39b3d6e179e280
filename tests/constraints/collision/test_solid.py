"""What bounds a solid contains it, however it is turned; which pairs are left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.constraints.collision.chain import robot_solids
from elastocal.constraints.collision.contacts import ignored
from elastocal.constraints.collision.solid import capsule, solids_of
from elastocal.robot.chain import transform
from elastocal.robot.shapes import Shape
from elastocal.robot.sources import kuka_kr270
from tests.arms import random_rotation


def surface(kind: str, size: Array, rng: np.random.Generator) -> Array:
    """Points of a box or a cylinder, in its own frame."""
    if kind == "box":
        return 0.5 * size * (2.0 * np.indices((2, 2, 2)).reshape(3, 8).T - 1.0)
    turn = rng.uniform(0.0, 2.0 * np.pi, 200)
    rim = size[0] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    return np.column_stack([rim, rng.choice([-0.5, 0.5], 200) * size[1]])


@pytest.mark.parametrize(("kind", "size"), [("box", [0.6, 0.1, 0.2]), ("cylinder", [0.1, 0.9])])
@pytest.mark.parametrize("seed", range(3))
def test_the_bounding_capsule_contains_a_solid_that_is_turned(
    kind: str, size: list[float], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    pose = transform(random_rotation(rng), rng.uniform(-1.0, 1.0, 3))
    (solid,) = solids_of(Shape(kind=kind, body=2, size=np.array(size), pose=pose), "link")
    points = surface(kind, np.array(size), rng) @ pose[:3, :3].T + pose[:3, 3]
    start, along = solid.segment[0], solid.segment[1] - solid.segment[0]
    share = np.clip((points - start) @ along / max(along @ along, 1e-300), 0.0, 1.0)
    away = np.linalg.norm(points - start - share[:, None] * along, axis=1)
    assert away.max() <= solid.radius + 1e-9
    assert away.max() > 0.9 * solid.radius  # and not by much


def test_only_the_pair_that_is_named_is_left_out() -> None:
    one, two, three = (
        replace(capsule(name, 1, np.zeros(3), np.ones(3), 0.1), joint=f"J{name}") for name in "abc"
    )
    for rule in (("a", "b"), ("b", "a"), ("Ja", "b")):
        assert ignored(one, two, [rule])
        assert ignored(two, one, [rule])
        assert not ignored(one, three, [rule])
        assert not ignored(three, two, [rule])
    assert not ignored(one, two, [])


def test_a_ball_that_is_thicker_than_the_link_before_it_is_not_covered() -> None:
    """A5 of the KR 270 lies at the end of A4, a ball; A1 is thick and far from both."""
    robot = kuka_kr270()
    for ball, covered in ((0.2, False), (0.04, True)):
        radius = {"A1": 0.5, "A4": 0.05, "A5": ball}
        found = {solid.name: solid for solid in robot_solids(robot, radius)}
        assert found["A5"].covered == covered
