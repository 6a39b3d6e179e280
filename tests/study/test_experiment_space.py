"""The design space of load cases: rows, margins and their joint gradient, sampling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.constraints import HalfSpace, Tilt
from elastocal.design.oracle import restore
from elastocal.elastic.allowed_loads import FreeDirection, InPlane
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError
from elastocal.measuring.instrument import Isotropic
from elastocal.robot.posture import forward_kinematics
from elastocal.study.experiment_space import LoadCaseSpace
from tests.arms import central_difference
from tests.paper.problems import cone, kr270
from tests.paper.published import A0, CALIBRATION_FORCE, SIGMA

GRADIENT = 1e-8


def space_with_everything() -> LoadCaseSpace:
    """KR-270 with its constraints, a force in a cone and a moment in another."""
    moment = FreeDirection(400.0, np.array([1.0, 0.0, 0.0]), np.radians(80.0))
    study = kr270(A0, force=cone(30.0))
    return replace(study, experiments=replace(study.experiments, moment=moment)).space


def test_gradient_of_rows_and_margins_together() -> None:
    space, rng = space_with_everything(), np.random.default_rng(0)
    x = space.sample(5, rng)
    at = space.evaluate(x)
    blocks, margins = rng.normal(size=at.blocks.shape), rng.normal(size=at.margins.shape)
    blocks /= np.abs(at.blocks).max()  # rows are in N·m² over m: bring both parts to one size

    def scalar(y: np.ndarray) -> np.ndarray:
        there = space.evaluate(y)
        return (there.blocks * blocks).sum(axis=(1, 2)) + (there.margins * margins).sum(axis=1)

    expected = central_difference(scalar, x)
    assert at.margins.shape == (5, 3 + 2)  # three constraints, two cones
    assert at.pull(blocks, margins) == pytest.approx(
        expected, abs=GRADIENT * (1.0 + np.abs(expected).max())
    )


def space_with_planes() -> LoadCaseSpace:
    """KR-270 with a force in one plane and a moment in another: two variables each."""
    study = kr270(A0, force=InPlane(2500.0, np.array([0.3, 1.0, -0.2])))
    moment = InPlane(400.0, np.array([0.0, 0.0, 1.0]))
    return replace(study, experiments=replace(study.experiments, moment=moment)).space


def test_gradient_of_rows_with_loads_in_planes() -> None:
    space, rng = space_with_planes(), np.random.default_rng(0)
    x = space.sample(5, rng)
    x[:, 6:] *= rng.uniform(0.5, 1.5, (5, 4))
    at = space.evaluate(x)
    assert at.margins.shape == (5, 3)  # nothing to keep: all directions there are allowed
    blocks = rng.normal(size=at.blocks.shape) / np.abs(at.blocks).max()
    expected = central_difference(lambda y: (space.evaluate(y).blocks * blocks).sum((1, 2)), x)
    assert at.pull(blocks, np.zeros_like(at.margins)) == pytest.approx(
        expected, abs=GRADIENT * (1.0 + np.abs(expected).max())
    )


def test_load_cases_with_loads_in_planes_and_design_points_are_the_same_thing() -> None:
    space = space_with_planes()
    assert space.lower.shape == (10,)
    x = space.sample(20, np.random.default_rng(3))
    x[:, 6:8] *= 1.3
    x[:, 8:] *= 0.7
    cases = space.load_cases(x)
    assert space.points(cases) == pytest.approx(space.canonical(x), abs=1e-12)
    assert np.linalg.norm(cases.wrench[:, :3], axis=1) == pytest.approx(np.full(20, 2500.0))
    assert cases.wrench[:, :3] @ [0.3, 1.0, -0.2] == pytest.approx(np.zeros(20), abs=1e-9)
    assert cases.wrench[:, 5] == pytest.approx(np.zeros(20), abs=1e-10)


@pytest.mark.parametrize("count", [0, 1, 7, 2048, 2050])
def test_a_batch_is_a_loop_over_its_chunks(count: int) -> None:
    """Large batches are evaluated in parts of 2048."""
    space = space_with_everything()
    rng = np.random.default_rng(1)
    x = space.sample(count, rng) if count else np.zeros((0, 12))
    at = space.evaluate(x)
    assert at.blocks.shape == (count, 3, 5)
    assert at.margins.shape == (count, 5)
    pulled = at.pull(at.blocks, at.margins)
    assert pulled.shape == (count, 12)
    for i in {0, count // 2, count - 1} & set(range(count)):
        one = space.evaluate(x[i : i + 1])
        assert one.blocks[0] == pytest.approx(at.blocks[i], rel=1e-12)
        assert one.margins[0] == pytest.approx(at.margins[i], rel=1e-12)
        alone = one.pull(one.blocks, one.margins)[0]
        assert alone == pytest.approx(pulled[i], rel=1e-10, abs=1e-10 * np.abs(alone).max())


def test_the_box_is_that_of_the_joints_and_of_directions() -> None:
    """Two directions of three variables each, of norm 1 within ±2; climbs stay in there."""
    space = space_with_everything()
    np.testing.assert_array_equal(space.lower, np.append(space.limits[0], [-2.0] * 6))
    np.testing.assert_array_equal(space.upper, np.append(space.limits[1], [2.0] * 6))


def test_samples_are_feasible_and_cover_the_joint_ranges() -> None:
    space = kr270(A0).space
    x = space.sample(3000, np.random.default_rng(2))
    assert x.shape == (3000, 6)
    assert (space.evaluate(x).margins >= 0.0).all()
    assert (x >= space.lower).all()
    assert (x <= space.upper).all()
    share = (x - space.lower) / (space.upper - space.lower)
    assert (share.min(axis=0) < 0.02).all()
    assert (share.max(axis=0) > 0.98).all()


def test_load_cases_and_design_points_are_the_same_thing() -> None:
    space = space_with_everything()
    x = space.canonical(space.sample(20, np.random.default_rng(3)))
    cases = space.load_cases(x)
    assert np.linalg.norm(cases.wrench[:, :3], axis=1) == pytest.approx(np.full(20, 2500.0))
    assert np.linalg.norm(cases.wrench[:, 3:], axis=1) == pytest.approx(np.full(20, 400.0))
    assert space.points(cases) == pytest.approx(x, abs=1e-12)
    assert space.canonical(x * 1.0) == pytest.approx(x, abs=1e-15)


def test_the_length_of_the_direction_variables_does_not_matter() -> None:
    space = space_with_everything()
    x = space.sample(5, np.random.default_rng(4))
    longer = x.copy()
    longer[:, 6:] *= 1.7
    assert space.evaluate(longer).blocks == pytest.approx(space.evaluate(x).blocks, rel=1e-12)
    assert space.evaluate(longer).margins == pytest.approx(space.evaluate(x).margins, abs=1e-12)


def test_a_fixed_force_leaves_the_configuration_to_choose() -> None:
    space = kr270(A0).space
    x = space.sample(4, np.random.default_rng(5))
    assert space.lower.shape == space.upper.shape == (6,)
    cases = space.load_cases(x)
    assert cases.q == pytest.approx(x)
    assert cases.wrench == pytest.approx(np.tile(np.append(CALIBRATION_FORCE, [0, 0, 0]), (4, 1)))
    assert space.points(LoadCases(cases.q, cases.wrench)) == pytest.approx(x)


def test_rows_are_in_units_of_the_noise() -> None:
    """Twice the noise, half the rows: a quarter of the information."""
    space = kr270(A0).space
    x = space.sample(4, np.random.default_rng(6))
    noisy = replace(space, instrument=Isotropic(2.0 * SIGMA))
    assert noisy.evaluate(x).blocks == pytest.approx(space.evaluate(x).blocks / 2.0)


def test_a_thin_feasible_set_is_sampled_too() -> None:
    """Where hardly a random point is feasible: a slab 2 mm thin, one point in 2000."""
    space = kr270(A0).space
    point = space.arm.tool.load_point
    slab = (
        HalfSpace("at least 1.5 m", point, [0, 0, 1], 1.5),
        HalfSpace("at most 1.502 m", point, [0, 0, -1], -1.502),
    )
    x = replace(space, constraints=slab).sample(50, np.random.default_rng(8))
    assert x.shape == (50, 6)
    height = forward_kinematics(space.arm.robot, x)[:, 2] @ np.append(point, 1.0)
    assert (height >= 1.5).all()
    assert (height <= 1.502).all()
    assert np.ptp(x, axis=0).min() > 1.0  # and it is not always the same corner


def test_a_set_that_no_random_point_hits_is_sampled_and_stirred() -> None:
    """A slab 20 µm thin, one point in 200 000: random points restored, then moved inward.

    They do not all lie on the two faces, where restoring leaves them.
    """
    space = kr270(A0).space
    point, low, thin = space.arm.tool.load_point, 1.5, 2e-5
    slab = (
        HalfSpace("at least", point, [0, 0, 1], low),
        HalfSpace("at most", point, [0, 0, -1], -low - thin),
    )
    x = replace(space, constraints=slab).sample(400, np.random.default_rng(8))
    assert x.shape == (400, 6)
    height = forward_kinematics(space.arm.robot, x)[:, 2] @ np.append(point, 1.0)
    assert (height >= low).all()
    assert (height <= low + thin).all()
    assert np.ptp(x, axis=0).min() > 1.0
    assert ((x >= space.lower) & (x <= space.upper)).all()
    only = HalfSpace("at least", point, [0, 0, 1], 2.9)  # rarely hit, and thick
    high = replace(space, constraints=(only,)).sample(400, np.random.default_rng(9))
    room = forward_kinematics(space.arm.robot, high)[:, 2] @ np.append(point, 1.0) - 2.9
    assert (room >= 0.0).all()
    assert np.median(room) > 1e-3
    assert len(np.unique(np.round(high, 6), axis=0)) > 200


def in_a_small_box(half_angle_deg: float) -> LoadCaseSpace:
    """KR-270 with its load point in a box of 60 mm and a force in a cone: 1e-5 of random points."""
    space = kr270(A0, force=cone(half_angle_deg)).space
    sides = []
    for axis, middle in enumerate((1.8, 0.0, 1.5)):
        for sign in (1.0, -1.0):
            normal, name = [0.0, 0.0, 0.0], f"{'xyz'[axis]} {'<=' if sign < 0 else '>='}"
            normal[axis] = sign
            point = space.arm.tool.load_point
            sides.append(HalfSpace(name, point, normal, sign * middle - 0.03))
    return replace(space, constraints=(*space.constraints, *sides))


@pytest.mark.parametrize("half_angle_deg", [0.5, 6.0, 60.0])
def test_loads_of_a_thin_set_stay_in_their_cone(half_angle_deg: float) -> None:
    """Moving points about in a thin set turns their loads, too, but never out of the cone."""
    space = in_a_small_box(half_angle_deg)
    x = space.sample(500, np.random.default_rng(3))
    assert (space.evaluate(x).margins >= -1e-12).all()
    wrench = space.load_cases(x).wrench
    angle = np.degrees(np.arccos(-wrench[:, 2] / np.linalg.norm(wrench[:, :3], axis=1)))
    assert angle.max() <= half_angle_deg * (1.0 + 1e-6)
    assert angle.max() > 0.8 * half_angle_deg


def test_points_of_a_thin_set_are_no_copies() -> None:
    """Also where most random points cannot be restored: further ones are drawn instead."""
    space = in_a_small_box(6.0)
    upright = Tilt("tilt", [1.0, 0.0, 0.0], [0.0, 0.0, -1.0], np.radians(2.0))
    space = replace(space, constraints=(*space.constraints[3:], upright))
    drawn = space._draw(1000, np.random.default_rng(5))
    assert space.feasible(restore(space, drawn)).mean() < 0.5
    x = space.sample(900, np.random.default_rng(4))
    assert len(x) == 900
    assert len(np.unique(np.round(x, 7), axis=0)) == 900


def test_where_everything_is_held_there_is_one_point() -> None:
    space = kr270(A0).space
    q = [0.0, -1.2, 1.5, 0.3, -0.5, 0.2]
    held = replace(space, constraints=(), limits=np.array([q, q]))
    assert held.sample(600, np.random.default_rng(0)) == pytest.approx(np.array([q]))


def test_an_impossible_constraint_is_named() -> None:
    """The KR-270 reaches 3.9 m above its base with this tool, not 9."""
    space = kr270(A0).space
    sky = HalfSpace("height of M1 >= 9000 mm", [0.0, 0.0, 0.0], [0, 0, 1], 9.0)
    impossible = replace(space, constraints=(*space.constraints, sky))
    with pytest.raises(InfeasibleError) as error:
        impossible.sample(1, np.random.default_rng(7))
    (doubt,) = error.value.doubts
    assert (doubt.code, doubt.about) == ("no-configuration", ("height of M1 >= 9000 mm",))
    assert 9.0 - 3.95 < doubt.numbers["by"] < 9.0


def test_pulling_a_gradient_leaves_its_arguments_alone() -> None:
    space = kr270(A0).space
    for count in (1, 3):
        at = space.evaluate(space.sample(count, np.random.default_rng(9)))
        blocks, margins = np.ones_like(at.blocks), np.ones_like(at.margins)
        rows = at.blocks.copy()
        at.pull(blocks, margins)
        assert (blocks == 1.0).all()
        assert (margins == 1.0).all()
        assert np.array_equal(at.blocks, rows)
