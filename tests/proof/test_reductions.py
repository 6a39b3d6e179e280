"""Reductions of statements: the same largest sensitivity in fewer variables, or refused."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.constraints import HalfSpace
from elastocal.elastic.allowed_loads import FixedVector, FreeDirection, InPlane
from elastocal.errors import InputError
from elastocal.proof.dropped import base_joint
from elastocal.proof.posing import posed
from elastocal.proof.reductions import Reduced, reduced
from elastocal.proof.reference import margins, sensitivity, within
from elastocal.proof.roots import into_root, sums, with_root
from elastocal.proof.statement import CarriedSprings, Statement, SteadyLoad
from elastocal.robot.chain import Joint, Robot
from elastocal.robot.posture import Posture
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.study.study import Study
from tests.proof.bounds import bound_by_chance
from tests.proof.statements import chance
from tests.proof.test_posing import example, loaded, robot


def stated(study: Study) -> Statement:
    return posed(study, bound_by_chance(study)).statement


@cache
def plain(name: str) -> Statement:
    return stated(example(name) if name == "three-link/study" else robot(name))


@cache
def done(name: str) -> Reduced:
    return reduced(plain(name))


def held(found: Statement) -> list[tuple[int, str]]:
    return [(one.variable, one.because) for one in found.held]


def halved(found: Statement) -> list[int]:
    return [one.variable for one in found.halved]


WHAT = {
    "kr270": ([(0, "base")], 2, [1, 2, 3, 4, 5]),
    "cobot-ur10e": ([(0, "base")], 0, [1, 2, 3, 4, 5]),
    "rail-arm": ([(0, "flat"), (1, "base")], 1, [2, 3, 4, 5, 6]),
    "scara-700": ([(2, "flat")], 1, [0, 1, 3]),
    "gantry-5": ([(0, "flat"), (1, "flat")], 1, [2, 3, 4]),
    "arm-7r": ([(0, "base")], 0, [1, 2, 3, 4, 5, 6]),
    "three-link/study": ([(0, "base")], 2, [1, 2]),
}


@pytest.mark.parametrize("name", WHAT)
def test_what_is_found(name: str) -> None:
    found = done(name).statement
    assert (held(found), len(halved(found)), found.active.tolist()) == WHAT[name]
    assert done(name).doubts == ()


def extremes(statement: Statement, count: int) -> Array:
    """Configurations by chance within the limits, and corners of the ranges."""
    rng = np.random.default_rng(0)
    low, high = statement.joints.lower, statement.joints.upper
    inside = low + (high - low) * rng.uniform(size=(count, len(low)))
    corners = np.where(rng.integers(0, 2, inside.shape) > 0, low, high)
    mixed = np.where(rng.integers(0, 2, inside.shape) > 0, inside, corners)
    return np.concatenate([inside, corners, mixed])


@pytest.mark.parametrize("name", WHAT)
def test_every_configuration_has_its_like_in_the_root(name: str) -> None:
    """d and the constraints are the same there, at the limits and at the ends of sums too."""
    before, after = plain(name), done(name).statement
    q = extremes(before, 1000)
    x = into_root(after, q)
    assert (x >= after.root[0]).all()
    assert (x <= after.root[1]).all()
    d = sensitivity(before, q)
    np.testing.assert_allclose(sensitivity(after, x), d, atol=1e-12 * d.max())
    here = np.sort(margins(before, q), axis=1)
    np.testing.assert_allclose(np.sort(margins(after, x), axis=1), here, atol=1e-12)
    room = within(after, x)[:, np.tile(after.limited, 2)]
    assert (room > -1e-12).all()


def test_a_configuration_beyond_the_limits_has_none() -> None:
    after = done("kr270").statement
    beyond = np.zeros((1, 6))
    beyond[0, 1] = 0.1
    with pytest.raises(InputError, match=r"outside of the box that is searched, by 0\.1"):
        into_root(after, beyond)


@pytest.mark.parametrize("name", ["kr270", "three-link/study", "scara-700", "rail-arm"])
def test_symmetries_are_symmetries(name: str) -> None:
    """Each at 1000 points, and more of the root is not left than they say."""
    after = done(name).statement
    whole = replace(
        after, halved=(), root=np.array([-np.pi, np.pi])[:, None] * np.ones(len(after.joints))
    )
    x = np.random.default_rng(1).uniform(*after.root, (1000, len(after.joints)))
    turns = np.linalg.inv(after.mix)
    for half in after.halved:
        image = (half.signs * (x @ after.mix.T) + half.shifts) @ turns.T
        np.testing.assert_allclose(sensitivity(whole, image), sensitivity(whole, x), rtol=1e-11)
        here, there = (np.sort(margins(whole, at), axis=1) for at in (x, image))
        np.testing.assert_allclose(there, here, atol=1e-12)
    # Sums with a halved variable have less of a range, too.
    volumes = [np.prod(np.ptp(one.root, axis=0)[after.active]) for one in (after, whole)]
    assert volumes[0] * 2 ** len(after.halved) <= volumes[1] * (1.0 + 1e-12)


# What spoils a reduction, and what then is not held or halved any more.


def with_spring(made: Statement, axis: Array, *, slides: bool) -> Statement:
    """The statement with a further unknown, a spring between the base and all joints."""
    old, unknowns = made.springs, len(made.unknowns)
    springs = CarriedSprings(
        ("base", *old.names),
        np.append(slides, old.slides),
        np.append(0, old.body),
        np.concatenate([axis[None], old.axis]),
        np.concatenate([np.zeros((1, 3)), old.point]),
    )
    make = np.zeros((len(springs), unknowns + 1))
    make[1:, 1:], make[0, 0] = made.make, 1.0
    row = np.full((1, made.V.shape[1]), 0.1)
    return replace(
        made,
        springs=springs,
        make=make,
        unknowns=("base", *made.unknowns),
        V=np.concatenate([row, made.V]),
        K=np.concatenate([row, made.K]),
        B=np.eye(unknowns + 1),
    )


def foot_spring(study: Study) -> Statement:
    return with_spring(stated(study), np.array([1.0, 0.0, 0.0]), slides=False)


def rail_spring(study: Study) -> Statement:
    """It gives way along the rail, which a weight does not push: only its row says so."""
    return with_spring(stated(study), np.array([1.0, 0.0, 0.0]), slides=True)


def slanted_load(study: Study) -> Statement:
    return stated(loaded(study, force=FixedVector(np.array([300.0, 200.0, -1500.0]))))


def box(study: Study) -> Statement:
    tool = study.experiments.tool
    wall = HalfSpace("x", tool.load_point, [1.0, 0.0, 0.0], 0.5)
    return stated(replace(study, constraints=(*study.constraints, wall)))


def unsymmetric_limits(study: Study) -> Statement:
    limits = study.limits.copy()
    limits[1, 4] *= 0.9
    return stated(replace(study, limits=limits))


def tilted_base(study: Study) -> Statement:
    old: Robot = study.robot
    tilt = np.eye(4)
    tilt[:3, :3] = from_rotation_vectors(np.array([[1e-9, 0.0, 0.0]]))[0]
    first = old.joints[0]
    joints: tuple[Joint, ...] = (
        replace(first, T_parent_joint=tilt @ first.T_parent_joint), *old.joints[1:],
    )  # fmt: skip
    return stated(replace(study, robot=replace(old, joints=joints)))


def marker_off_the_plane(study: Study) -> Statement:
    tool = study.experiments.tool
    moved = tool.markers + np.array([0.0, 1e-9, 0.0])
    return stated(loaded(study, tool=replace(tool, markers=moved)))


SPOILED: dict[str, tuple[str, Callable[[Study], Statement], bool, int]] = {
    # name: robot, spoiler, whether the base is still held, halves that are left
    "foot spring": ("kr270", foot_spring, False, 3),
    "rail spring": ("rail-arm", rail_spring, False, 1),
    "slanted load": ("kr270", slanted_load, False, 1),
    "box": ("kr270", box, False, 2),
    "limits": ("kr270", unsymmetric_limits, True, 1),
    "tilted base": ("kr270", tilted_base, False, 2),
    "marker": ("kr270", marker_off_the_plane, True, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", SPOILED)
def test_what_spoils_a_reduction_is_seen(name: str) -> None:
    which, spoil, base, halves = SPOILED[name]
    before = spoil(robot(which))
    assert base_joint(plain(which)) == (1 if which == "rail-arm" else 0)
    found = reduced(before)
    after = found.statement
    assert (any(b == "base" for _, b in held(after))) == base
    assert len(halved(after)) == halves
    q = extremes(before, 200)
    d = sensitivity(before, q)
    np.testing.assert_allclose(sensitivity(after, into_root(after, q)), d, atol=1e-12 * d.max())


def of_load(force: FreeDirection | InPlane) -> Statement:
    return reduced(stated(loaded(robot("kr270"), force=force))).statement


def test_free_loads_have_symmetries_too() -> None:
    free = of_load(FreeDirection(900.0, np.array([1.0, 0.0, 0.0])))
    assert (held(free), len(halved(free))) == ([(0, "base")], 2)
    hung = of_load(FreeDirection(900.0, np.array([0.0, 0.0, -1.0]), 0.6))
    assert (held(hung), len(halved(hung))) == ([(0, "base")], 2)
    # A cone aslant has one plane of symmetry with the first axis; the wrist knows two ways, too.
    aslant = of_load(FreeDirection(900.0, np.array([1.0, 0.0, -1.0]), 0.6))
    assert held(aslant) == []
    assert {0, 4} & set(halved(aslant))
    level = of_load(InPlane(900.0, np.array([0.0, 0.0, 1.0])))
    assert held(level) == [(0, "base")]
    for after in (aslant, level):
        q = extremes(after, 100)
        before = replace(with_root(replace(after, mix=np.eye(6), halved=()), ()), held=())
        d = sensitivity(before, q)
        np.testing.assert_allclose(sensitivity(after, into_root(after, q)), d, atol=1e-11 * d.max())


def at_one_point(study: Study, local: Array) -> Statement:
    """The KR 270 statement with load and marker at one point of the flange."""
    at = Posture(study.robot, np.zeros((1, 6))).point(local)[:, 0]
    load = SteadyLoad(at, np.array([0.0, 0.0, -2500.0]), np.zeros(3))
    return replace(plain("kr270"), load=load, markers=at[None])


def test_the_last_joint_if_all_lies_on_its_axis() -> None:
    """It is held, unless a constraint minds and few variables are left anyway."""
    on_axis = at_one_point(robot("kr270"), np.array([0.7, 0.0, 0.0]))
    kept = reduced(on_axis)
    assert held(kept.statement) == [(0, "base")]
    assert kept.doubts == ()
    free = reduced(replace(on_axis, constraints=())).statement
    assert held(free) == [(0, "base"), (5, "flat")]
    nearly = at_one_point(robot("kr270"), np.array([0.7, 1e-7, 0.0]))
    assert held(reduced(replace(nearly, constraints=())).statement) == [(0, "base")]


def test_a_constraint_goes_if_else_too_many_variables_were_left() -> None:
    """A wall along the rail would ask for where the arm stands on it."""
    before = box(robot("rail-arm"))
    found = reduced(before)
    assert (0, "flat") in held(found.statement)
    assert found.statement.left_out[-1] == "x"
    assert [doubt.about for doubt in found.doubts] == [("x",)]
    assert len(found.statement.constraints) == len(before.constraints) - 1


def test_a_variable_of_a_sum_that_rows_ignore() -> None:
    """Nothing is asked of A2: d depends on the sum of A2 and A3 alone, over all it can be."""
    before = plain("kr270")
    V = before.V.copy()
    V[0] = 0.0
    alone = replace(before, V=V, constraints=())
    after = reduced(alone).statement
    assert held(after) == [(0, "base"), (1, "flat")]
    assert not after.limited.any()
    whole = with_root(replace(after, halved=()), after.held)
    assert np.ptp(whole.root[:, 2]) == pytest.approx(2.0 * np.pi)  # 410 degrees cut to a turn
    q = extremes(alone, 300)
    d = sensitivity(alone, q)
    np.testing.assert_allclose(sensitivity(after, into_root(after, q)), d, atol=1e-12 * d.max())
    # Over less than a turn the whole of both ranges counts.
    joints = replace(before.joints, upper=before.joints.upper - np.array([0, 0, 2.0, 0, 0, 0]))
    less = reduced(replace(alone, joints=joints)).statement
    ends = joints.lower[1:3].sum(), joints.upper[1:3].sum()
    np.testing.assert_allclose(less.root[:, 2], ends)


def test_sum_coordinates_only_of_axes_that_are_parallel() -> None:
    joints = plain("cobot-ur10e").joints
    assert sums(joints).sum() == 6 - 2
    fixed = replace(joints, upper=np.where(np.arange(6) == 2, joints.lower, joints.upper))
    assert sums(fixed).sum() == 6
    axis = joints.axis.copy()
    axis[2] = from_rotation_vectors(np.array([[0.0, 0.0, 1e-9]]))[0] @ axis[2]
    assert sums(replace(joints, axis=axis)).sum() == 6
    against = replace(joints, axis=joints.axis * np.array([1, 1, -1, 1, 1, 1])[:, None])
    assert sums(against).sum() == 6 + 2


def test_random_arms_keep_their_joints() -> None:
    for seed, kinds in enumerate(("ttt", "sttt")):
        before = chance(np.random.default_rng(seed), kinds, "free")
        after = reduced(before).statement
        assert after.halved == ()
        assert held(after) == ([(0, "flat")] if kinds[0] == "s" and not before.constraints else [])
        np.testing.assert_array_equal(after.root, before.root)
