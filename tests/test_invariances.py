"""What must not change a plan's worth, and what must change it in a known way.

On random arms where the arm does not matter, on the paper's problems where planning is involved.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.design.exact import Effort
from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import joint_springs
from elastocal.measuring.instrument import Isotropic
from elastocal.planning.assessment import assess
from elastocal.planning.certificate import lower_bound
from elastocal.planning.plan import plan
from elastocal.robot.chain import Robot, transform
from elastocal.study.study import Experiments, Study, TestPose, test_pose
from tests.arms import random_chain, random_rotation, random_tool
from tests.paper.problems import any_direction, cone, kr270
from tests.paper.published import A0, A0_PLUS

reproducible = settings(max_examples=25)
seeds = st.integers(0, 2**32 - 1)
ROUNDING = 1e-9  # information of condition 1e4 or so, inverted
LIGHT = Effort(batch=24, generations=3, patience=1)


def random_study(seed: int) -> tuple[Study, LoadCases]:
    """A random arm of five joints with two markers, two test poses, and eight load cases."""
    rng = np.random.default_rng(seed)
    robot, tool = random_chain(rng, [False, False, True, False, False]), random_tool(rng, 2)
    springs = joint_springs(robot)

    def cases(count: int) -> LoadCases:
        return LoadCases(rng.uniform(-3, 3, (count, 5)), rng.normal(size=(count, 6)))

    poses = tuple(
        test_pose(ElasticArm(robot, springs, tool), cases(1), weight, f"task {weight:g}")
        for weight in (1.0, 2.0)
    )
    limits = np.tile([[-4.0], [4.0]], 5)
    study = Study(
        robot, springs, poses, Experiments(tool, any_direction(), 8), Isotropic(0.1), limits=limits
    )
    return study, cases(8)


def once(cases: LoadCases) -> np.ndarray:
    return np.ones(len(cases), dtype=np.int64)


def rho0(study: Study, cases: LoadCases, repeats: np.ndarray | None = None) -> float:
    return assess(study, cases, once(cases) if repeats is None else repeats).rho0


@reproducible
@given(seeds, st.floats(0.1, 10.0))
def test_rho0_falls_in_proportion_to_the_load(seed: int, factor: float) -> None:
    """Deflections grow with the load, the noise does not: ρ0² goes as 1/F²."""
    study, cases = random_study(seed)
    heavier = LoadCases(cases.q, factor * cases.wrench)
    expected = rho0(study, cases) / factor
    assert rho0(study, heavier) == pytest.approx(expected, rel=ROUNDING)


@reproducible
@given(seeds, st.integers(2, 50))
def test_repeats_divide_rho0_squared_by_their_number(seed: int, times: int) -> None:
    study, cases = random_study(seed)
    expected = rho0(study, cases) ** 2 / times
    assert rho0(study, cases, times * once(cases)) ** 2 == pytest.approx(expected, rel=ROUNDING)


@reproducible
@given(seeds)
def test_a_repeat_is_the_same_load_case_twice(seed: int) -> None:
    study, cases = random_study(seed)
    written_out = LoadCases(
        np.concatenate([cases.q, cases.q[:1]]), np.concatenate([cases.wrench, cases.wrench[:1]])
    )
    repeats = once(cases)
    repeats[0] = 2
    assert rho0(study, cases, repeats) == pytest.approx(rho0(study, written_out), rel=ROUNDING)


@reproducible
@given(seeds)
def test_an_added_experiment_never_raises_rho0(seed: int) -> None:
    """Nor any standard error, whatever the experiment is."""
    study, cases = random_study(seed)
    fewer = LoadCases(cases.q[:-1], cases.wrench[:-1])
    more, less = assess(study, cases, once(cases)), assess(study, fewer, once(fewer))
    assert more.rho0 <= less.rho0 * (1.0 + ROUNDING)
    assert (more.standard_error <= less.standard_error * (1.0 + ROUNDING)).all()


@reproducible
@given(seeds)
def test_turning_the_base_changes_nothing(seed: int) -> None:
    """The same arm bolted down at an angle, loaded by forces that turn with it."""
    study, cases = random_study(seed)
    rotation = random_rotation(np.random.default_rng(seed + 1))
    first = study.robot.joints[0]
    base = transform(rotation, (0.3, -2.0, 1.0))
    moved = replace(first, T_parent_joint=base @ first.T_parent_joint)
    robot = Robot("turned", (moved, *study.robot.joints[1:]), study.robot.T_tip_flange)

    def turn(original: LoadCases) -> LoadCases:
        force, moment = original.wrench[:, :3], original.wrench[:, 3:]
        return LoadCases(original.q, np.hstack([force @ rotation.T, moment @ rotation.T]))

    poses = []
    for pose in study.test_poses:
        assert pose.tool is not None
        assert pose.case is not None
        poses.append(
            test_pose(
                replace(study.arm, robot=robot, tool=pose.tool),
                turn(pose.case),
                pose.weight,
                pose.name,
            )
        )
    springs = joint_springs(robot)
    turned = replace(study, robot=robot, springs=springs, test_poses=tuple(poses))
    before = assess(study, cases, once(cases))
    after = assess(turned, turn(cases), once(cases))
    assert after.rho0 == pytest.approx(before.rho0, rel=ROUNDING)
    assert after.standard_error == pytest.approx(before.standard_error, rel=ROUNDING)


@reproducible
@given(seeds)
def test_the_order_of_the_experiments_does_not_matter(seed: int) -> None:
    study, cases = random_study(seed)
    rng = np.random.default_rng(seed)
    order, repeats = rng.permutation(len(cases)), rng.integers(1, 5, len(cases))
    shuffled = LoadCases(cases.q[order], cases.wrench[order])
    expected = rho0(study, cases, repeats)
    assert rho0(study, shuffled, repeats[order]) == pytest.approx(expected, rel=ROUNDING)


@reproducible
@given(seeds)
def test_the_opposite_load_is_worth_the_same(seed: int) -> None:
    """Deflections change sign, their squares do not."""
    study, cases = random_study(seed)
    opposite = LoadCases(cases.q, -cases.wrench)
    assert rho0(study, opposite) == pytest.approx(rho0(study, cases), rel=ROUNDING)


@reproducible
@given(seeds)
def test_prior_information_counts_as_experiments_done(seed: int) -> None:
    """To know what three experiments tell and to make the other five is to make all eight."""
    study, cases = random_study(seed)
    known, new = (
        LoadCases(cases.q[part], cases.wrench[part]) for part in (slice(0, 3), slice(3, 8))
    )
    prior = assess(study, known, once(known)).information
    informed = replace(study, prior=prior)
    assert rho0(informed, new) == pytest.approx(rho0(study, cases), rel=ROUNDING)
    assert rho0(informed, new) < rho0(study, new)


@reproducible
@given(seeds, st.floats(1e-3, 1e3))
def test_only_the_ratio_of_test_pose_weights_matters(seed: int, factor: float) -> None:
    study, cases = random_study(seed)
    poses = tuple(replace(pose, weight=factor * pose.weight) for pose in study.test_poses)
    scaled = replace(study, test_poses=poses)
    assert rho0(scaled, cases) == pytest.approx(rho0(study, cases), rel=ROUNDING)


@reproducible
@given(seeds)
def test_rho0_of_several_test_poses_is_their_weighted_mean_square(seed: int) -> None:
    study, cases = random_study(seed)
    found = assess(study, cases, once(cases))
    first, second = np.square(found.rho0_each)
    assert found.rho0**2 == pytest.approx((first + 2.0 * second) / 3.0, rel=ROUNDING)
    assert found.criteria["worst"] == pytest.approx(np.sqrt(max(first, second)), rel=ROUNDING)


@reproducible
@given(seeds, st.floats(0.01, 100.0))
def test_rho0_is_proportional_to_the_noise(seed: int, factor: float) -> None:
    study, cases = random_study(seed)
    noisy = replace(study, instrument=Isotropic(factor * study.sigma))
    assert rho0(noisy, cases) == pytest.approx(factor * rho0(study, cases), rel=ROUNDING)


def test_joint_1_and_mirror_images_play_no_part_under_a_vertical_force() -> None:
    """On the KR-270: turning about the vertical, and (q4, q6) -> (-q4, -q6)."""
    study, rng = kr270(A0), np.random.default_rng(0)
    x = study.space.sample(6, rng)
    wrench = study.space.load_cases(x).wrench
    expected = rho0(study, LoadCases(x, wrench))
    turned, mirrored = x.copy(), x.copy()
    turned[:, 0] = rng.uniform(-3, 3, 6)
    mirrored[:, [3, 5]] *= -1.0
    assert rho0(study, LoadCases(turned, wrench)) == pytest.approx(expected, rel=ROUNDING)
    assert rho0(study, LoadCases(mirrored, wrench)) == pytest.approx(expected, rel=ROUNDING)


def test_same_seed_same_plan() -> None:
    first, second = (plan(kr270(A0, 4, 3), seed=5, effort=LIGHT) for _ in range(2))
    assert np.array_equal(first.load_cases.q, second.load_cases.q)
    assert np.array_equal(first.load_cases.wrench, second.load_cases.wrench)
    assert np.array_equal(first.repeats, second.repeats)
    assert first.assessment.rho0 == second.assessment.rho0
    assert first.certificate.lower_bound == second.certificate.lower_bound


def test_planning_twice_the_load_halves_plan_and_bound() -> None:
    study = kr270(A0, 3)
    twice = replace(
        study,
        experiments=replace(study.experiments, force=FixedVector(np.array([0.0, 0.0, -5000.0]))),
    )
    light, heavy = plan(study, effort=LIGHT), plan(twice, effort=LIGHT)
    # Two bounds that are each good to 5e-6, the gap at which the search stops.
    assert heavy.certificate.lower_bound == pytest.approx(
        light.certificate.lower_bound / 2.0, rel=1e-5
    )
    assert heavy.assessment.rho0 == pytest.approx(light.assessment.rho0 / 2.0, rel=1e-2)


def test_the_more_freedom_of_the_force_the_lower_the_bound() -> None:
    """Of the KR-270: vertical force, a cone of 12°, one of 30°; the ends are known values."""
    found = lower_bound(kr270(A0, force=cone(12.0)), np.random.default_rng(0)).design
    assert found is not None
    assert 8.7427 < 1e6 / np.sqrt(found.certificate.upper) < 9.6446


def test_two_equal_test_poses_are_one() -> None:
    study = kr270(A0)
    doubled = replace(study, test_poses=(TestPose("a", A0, 1.0), TestPose("b", A0, 5.0)))
    cases = study.space.load_cases(study.space.sample(6, np.random.default_rng(1)))
    assert rho0(doubled, cases) == pytest.approx(rho0(study, cases), rel=1e-12)
    other = replace(study, test_poses=(TestPose("a", A0), TestPose("b", A0_PLUS)))
    assert rho0(other, cases) < rho0(study, cases)
