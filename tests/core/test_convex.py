"""Distances of convex solids in the core: against coal, against what any direction shows, against
differences; where solids touch, where one is flat, where axes are parallel.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.constraints import Clearance
from elastocal.constraints.collision.distance import Pairs, nearest
from elastocal.constraints.collision.solid import Solid, plane, solids_of
from elastocal.constraints.collision.support import largest, spanned
from elastocal.core.library import levels
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.springs import joint_springs
from elastocal.measuring.instrument import Isotropic
from elastocal.robot.chain import Joint, Robot, Tool, transform
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape
from elastocal.study.compiled import CompiledSpace
from elastocal.study.experiment_space import LoadCaseSpace
from tests.arms import random_rotation

LEVELS = levels()
pytestmark = pytest.mark.skipif(not LEVELS, reason="the core is not compiled")

FAR = 10.0  # nothing here is farther [m]
CERTAIN = 2e-7  # of the distance of round solids; coal is told to know it to 1e-7 [m]
CENTRED = (np.zeros(3), np.eye(3))


def _free() -> Robot:
    """A body that goes anywhere and turns in any direction."""
    axes = np.eye(3)
    slides = [Joint(f"S{i}", np.eye(4), axes[i], True) for i in range(3)]
    turns = [Joint(f"R{i}", np.eye(4), axes[i], False) for i in range(3)]
    return Robot("free", (*slides, *turns), np.eye(4))


ROBOT = _free()
TOOL = Tool("point", np.array([0.1, 0.0, 0.0]), np.array([[0.1, 0.0, 0.0]]), ("M1",))


def in_core(one: Solid, two: Solid, keep: float = FAR) -> Iterator[CompiledSpace]:
    """The distance of two solids, less what is to be kept, at every level of instructions."""
    space = LoadCaseSpace(
        arm=ElasticArm(ROBOT, joint_springs(ROBOT), TOOL),
        force=FixedVector(np.array([0.0, 0.0, -100.0])),
        moment=FixedVector(np.zeros(3)),
        constraints=[Clearance("it", Pairs((one, two), ((0, 1),)), keep)],
        instrument=Isotropic(3e-5),
        limits=np.array([np.full(6, -3.0), np.full(6, 3.0)]),
    )
    for library in LEVELS.values():
        core = CompiledSpace(library, space)
        assert not core.foreign
        yield core


def measured(core: CompiledSpace, q: Array) -> tuple[Array, Array]:
    """Distances (N,) and their gradients (N, 6)."""
    found = core.evaluate(q)
    slope = found.pull(np.zeros_like(found.blocks), np.ones_like(found.margins))
    return found.margins[:, 0] + FAR, slope


def hull(body: int, corners: Array, pose: Array) -> Solid:
    """The hull of corners."""
    half = np.abs(corners).max(axis=0)
    low = [[0.0, 0.0, -half[2]], [0.0, 0.0, half[2]]] @ pose[:3, :3].T + pose[:3, 3]
    round_it = float(np.linalg.norm(half))
    box = {"boxed": True, "half": half, "box_pose": pose} if body == 0 else {}
    return Solid("x", body, "hull", half, pose, low, round_it, False, vertices=corners, **box)


def solid(rng: np.random.Generator, kind: str, body: int) -> Solid:
    """A solid of that kind; of some the place is the origin and the axes are those of the base."""
    turn = random_rotation(rng) if rng.random() < 0.7 else np.eye(3)
    pose = transform(turn, rng.uniform(-0.2, 0.2, 3) if rng.random() < 0.7 else np.zeros(3))
    corners = rng.uniform(-0.5, 0.5, (int(rng.integers(4, 40)), 3))
    if kind == "flat hull":
        return hull(body, corners * [1.0, 1.0, 0.0], pose)
    if kind == "needle":
        return hull(body, np.linspace(-0.5, 0.5, 5)[:, None] * [1.0, 0.5, 0.2], pose)
    if kind == "hull":
        return hull(body, corners, pose)
    size = {
        "box": rng.uniform(0.05, 0.8, 3),
        "cylinder": rng.uniform(0.05, 0.8, 2),
        "sphere": rng.uniform(0.05, 0.5, 1),
        "capsule": rng.uniform(0.05, 0.6, 2),
    }[kind]
    return solids_of(Shape(kind, size, pose, body, "x"), "x")[0]


def configurations(rng: np.random.Generator) -> Array:
    """Apart, in each other, and one in the middle of the other; some not turned."""
    shift = rng.uniform(-1.0, 1.0, (41, 3)) * rng.choice([0.0, 0.2, 1.0], (41, 1))
    return np.hstack([shift, rng.uniform(-3.0, 3.0, (41, 3)) * rng.choice([0, 1, 1], (41, 1))])


def shown(one: Solid, two: Solid, q: Array, along: Array) -> Array:
    """(N,) how far apart directions (3, N) show two solids: at most their signed distance [m]."""
    posture, case = Posture(ROBOT, q), np.arange(len(q))
    return -largest(posture, one, case, -along) - largest(posture, two, case, along)


ROUND = ("cylinder", "sphere", "capsule")
COAL = ("hull", "box", *ROUND)
EVERY = (*COAL, "flat hull", "needle")  # coal fails on these
MIXED = [(a, b) for a in EVERY for b in EVERY if {a, b} & {"hull", "cylinder", "flat hull"}]


@pytest.mark.parametrize(("first", "second"), MIXED)
def test_distances_are_what_their_directions_show(first: str, second: str) -> None:
    """A direction proves its own distance: no other answer along it could be right."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        one, two, q = solid(rng, first, 6), solid(rng, second, 0), configurations(rng)
        found = [measured(core, q) for core in in_core(one, two)]
        distance, slope = found[0]
        along = slope[:, :3].T  # the body moves as its first three joints do
        np.testing.assert_allclose(np.linalg.norm(along, axis=0), 1.0, rtol=0, atol=1e-9)
        np.testing.assert_allclose(shown(one, two, q, along), distance, rtol=0, atol=CERTAIN)
        for other in found[1:]:
            np.testing.assert_array_equal(other[0], distance)
            np.testing.assert_array_equal(other[1], slope)


@pytest.mark.parametrize(("first", "second"), [(a, b) for a, b in MIXED if a in COAL and b in COAL])
def test_they_are_those_of_coal(first: str, second: str) -> None:
    """In each other coal is off at times: then it says more depth than its direction needs."""
    for seed in range(4):
        rng = np.random.default_rng(seed)
        one, two, q = solid(rng, first, 6), solid(rng, second, 0), configurations(rng)
        expected = nearest(Pairs((one, two), ((0, 1),)), Posture(ROBOT, q), np.inf)
        right = np.abs(shown(one, two, q, expected.normal) - expected.distance) < 1e-6
        assert right.mean() > 0.5
        for core in in_core(one, two):
            distance, _ = measured(core, q)
            np.testing.assert_array_equal(distance < -CERTAIN, expected.distance < -CERTAIN)
            apart = expected.distance > 0.0
            np.testing.assert_allclose(distance[apart], expected.distance[apart], atol=1e-6)
            assert (distance - expected.distance)[right].min(initial=0.0) > -1e-6


@pytest.mark.parametrize(("first", "second"), MIXED)
def test_gradients_against_differences(first: str, second: str) -> None:
    """Where a face meets a face and where two ways out are equally far there is a kink."""
    near, step = [], 1e-6
    for seed in range(4):
        rng = np.random.default_rng(seed)
        one, two = solid(rng, first, 6), solid(rng, second, 0)
        q = np.hstack([rng.uniform(-0.8, 0.8, (41, 3)), rng.uniform(-3.0, 3.0, (41, 3))])
        core = list(in_core(one, two))[-1]
        _, slope = measured(core, q)
        ways = step * np.eye(6)
        expected = [measured(core, q + way)[0] - measured(core, q - way)[0] for way in ways]
        near += list(np.abs(slope - np.transpose(expected) / (2.0 * step)).max(axis=1))
    assert np.quantile(near, 0.97) < 1e-4


@pytest.mark.parametrize(("first", "second"), [p for p in MIXED if p[0] != "needle"])
def test_signs_where_solids_touch(first: str, second: str) -> None:
    """From the middle outward until it is zero; a little less and a little more is told apart."""
    rng = np.random.default_rng(7)
    one, two = solid(rng, first, 6), solid(rng, second, 0)
    way = rng.normal(size=(9, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    way[:3] = np.eye(3)
    turn = np.zeros((9, 3)) if first == "box" else rng.uniform(-3.0, 3.0, (9, 3))
    core = list(in_core(one, two))[-1]

    def at(share: Array) -> tuple[Array, Array]:
        return measured(core, np.hstack([share[:, None] * way, turn]))

    low, high = np.zeros(9), np.full(9, 3.0)
    inside = at(low)[0] < 0.0
    for _ in range(50):
        middle = 0.5 * (low + high)
        less = at(middle)[0] < 0.0
        low, high = np.where(less, middle, low), np.where(less, high, middle)
    for off in (1e-3, 1e-6):
        for sign in (-1.0, 1.0):
            distance, slope = at(low + sign * off)
            expected = sign * off * (slope[:, :3] * way).sum(axis=1)
            near = np.abs(distance - expected) < 0.1 * off + CERTAIN
            assert (near | (off > 1e-5) | ~inside).all()  # farther off all is curved
            assert (np.sign(distance)[inside & (expected != 0.0)] == sign).all()


@pytest.mark.parametrize(("first", "second"), [*MIXED, ("capsule", "box"), ("box", "box")])
def test_what_holds_is_what_has_no_negative_margin(first: str, second: str) -> None:
    """Asked without sizes the answer is the same, for any distance to keep."""
    for seed, keep in enumerate((0.02, 0.0, 0.3, -0.1)):
        rng = np.random.default_rng(seed)
        one, two, q = solid(rng, first, 6), solid(rng, second, 0), configurations(rng)
        for core in in_core(one, two, keep):
            margin = core.known_margins(q)[:, 0]
            clear = np.abs(margin) > CERTAIN
            np.testing.assert_array_equal(core.holds(q)[clear], margin[clear] >= 0.0)


def test_cylinders_by_hand() -> None:
    """Side by side, on top of each other, crossed, and one in the middle of the other."""
    size = np.array([0.3, 1.0])
    one, two = (solids_of(Shape("cylinder", size, np.eye(4), body, "x"), "x")[0] for body in (6, 0))
    quarter = np.pi / 2.0
    q = np.array(
        [
            [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 1.2, 0.0, 0.0, 1.0],
            [0.0, 1.0, 0.0, 0.0, quarter, 0.0],
            [0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.9, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ]
    )
    expected = [0.4, 0.2, 0.4, -0.1, -0.1, -0.6]
    for core in in_core(one, two):
        np.testing.assert_allclose(measured(core, q)[0], expected, rtol=0, atol=1e-4)


@pytest.mark.parametrize("kind", [kind for kind in EVERY if kind not in ("sphere", "capsule")])
def test_over_a_plane_the_lowest_point_counts(kind: str) -> None:
    rng = np.random.default_rng(3)
    one, floor = solid(rng, kind, 6), plane("floor", -0.3)
    q = configurations(rng)
    up = np.repeat([[0.0], [0.0], [1.0]], len(q), axis=1)
    expected = 0.3 - largest(Posture(ROBOT, q), one, np.arange(len(q)), -up)
    for core in in_core(one, floor):
        np.testing.assert_allclose(measured(core, q)[0], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("kind", EVERY)
def test_what_spans_a_solid_reaches_as_far(kind: str) -> None:
    rng = np.random.default_rng(5)
    one, q = solid(rng, kind, 6), configurations(rng)
    along = rng.normal(size=(3, len(q)))
    along /= np.linalg.norm(along, axis=0)
    posture, span = Posture(ROBOT, q), spanned(one)
    frame = posture.bodies[6]
    local = (frame[:3] * along).sum(axis=1)
    expected = (span.points @ local).max(axis=0) + np.linalg.norm(span.spokes @ local, axis=0)
    expected += span.skin + (frame[3] * along).sum(axis=0)
    found = largest(posture, one, np.arange(len(q)), along)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)
