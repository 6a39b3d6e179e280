"""Instruments: covariance, and the whitening of rows with its gradient."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.allowed_loads import FixedVector
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import Regressor, regressor
from elastocal.elastic.springs import joint_springs
from elastocal.errors import InputError
from elastocal.measuring.common_errors import CommonErrors
from elastocal.measuring.instrument import (
    PRESETS,
    Instrument,
    Isotropic,
    LaserTracker,
    PoseProbe,
)
from elastocal.planning.assessment import assess
from elastocal.planning.plain_values import simplify
from elastocal.robot.posture import Posture
from elastocal.robot.sources import kuka_kr270
from elastocal.study.experiment_space import LoadCaseEvaluation, LoadCaseSpace
from tests.arms import central_difference, random_chain, random_tool
from tests.paper.problems import cone, kr270
from tests.paper.published import A0, SIGMA

TRACKER = LaserTracker(np.array([3.0, 0.4, 1.2]), 5e-6, 1.5e-7, 7.5e-6, 3e-6)
NEAR = LaserTracker(np.array([1.0, -0.5, 0.7]), 4e-6, 5e-6, 2e-5, 8e-6)
INSTRUMENTS: dict[str, Instrument] = {
    "isotropic": Isotropic(3e-5), "tracker": TRACKER, "tracker among the poses": NEAR,
    "pose probe": PoseProbe(Isotropic(3e-5), 5e-5),
    "pose probe of a tracker": PoseProbe(NEAR, 2e-4),
}  # fmt: skip
COMMON: dict[str, Instrument] = {
    "a common translation": CommonErrors(Isotropic(3e-5), 4e-5),
    "common errors of a tracker": CommonErrors(NEAR, 2e-5, 1e-4),
    "common errors of a pose probe": CommonErrors(PoseProbe(NEAR, 2e-4), 2e-5, 1e-4),
}
GRADIENT = 1e-8


@pytest.mark.parametrize("name", INSTRUMENTS)
def test_whitened_noise_is_of_unit_size(name: str) -> None:
    """W covariance Wᵀ = I, at every marker by itself."""
    instrument, rng = INSTRUMENTS[name], np.random.default_rng(0)
    points = [rng.uniform(-4.0, 4.0, (3, 6)) for _ in range(2)]
    each = instrument.covariances(np.stack(points, axis=1).T)
    targets = 2 if instrument.sigma_rotation is None else 3
    assert each.shape == (6, targets, 3, 3)
    unit = np.tile(np.vstack([np.eye(3)] * targets)[:, :, None], (1, 1, 6))
    white, _ = instrument.whiten(unit, points)
    for k in range(targets):
        covariance = each[:, k]
        assert k == 2 or np.array_equal(covariance, instrument.covariance(points[k].T))
        for i in range(6):
            root = white[3 * k : 3 * k + 3, :, i]
            assert root @ covariance[i] @ root.T == pytest.approx(np.eye(3), abs=1e-12)


@pytest.mark.parametrize("name", COMMON)
def test_whitened_noise_of_a_pose_is_of_unit_size(name: str) -> None:
    """W covariance Wᵀ = I, over all that is read of a pose; common errors written out."""
    instrument, rng = COMMON[name], np.random.default_rng(0)
    assert isinstance(instrument, CommonErrors)
    points = rng.uniform(-2.0, 2.0, (6, 3, 3))
    whole = instrument.pose_covariance(points)
    size = whole.shape[1]
    unit = np.tile(np.eye(size)[:, :, None], (1, 1, 6))
    white, _ = instrument.whiten(unit, list(points.transpose(1, 2, 0)))
    single = instrument.own.covariances(points)
    for i in range(6):
        root = white[:, :, i]
        assert root @ whole[i] @ root.T == pytest.approx(np.eye(size), abs=1e-12)
        columns = np.zeros((size, 6))
        for k in range(3):
            x, y, z = points[i, k] - points[i].mean(axis=0)
            columns[3 * k : 3 * k + 3] = np.hstack(
                [np.eye(3), [[0, z, -y], [-z, 0, x], [y, -x, 0]]]
            )
        columns[9:, 3:] = np.eye(3)[: size - 9]
        sizes = np.repeat([instrument.translation, instrument.rotation], 3)
        blocks = columns @ np.diag(sizes**2) @ columns.T
        for k, one in enumerate(single[i]):
            blocks[3 * k : 3 * k + 3, 3 * k : 3 * k + 3] += one
        np.testing.assert_allclose(whole[i], blocks, atol=1e-20)


@pytest.mark.parametrize("name", [*INSTRUMENTS, *COMMON])
@pytest.mark.parametrize("slides", [[False] * 6, [True, False, False, True, False]])
def test_gradient_of_whitened_rows(name: str, slides: list[bool]) -> None:
    """Through the rows and through the place of the markers, several of them."""
    rng = np.random.default_rng(1)
    robot, tool = random_chain(rng, slides), random_tool(rng, 3)
    tool = replace(tool, rotation={**INSTRUMENTS, **COMMON}[name].sigma_rotation is not None)
    n = len(slides)
    force, moment = (FixedVector(rng.normal(size=3)) for _ in range(2))
    limits = np.tile([[-3.0], [3.0]], n)
    space = LoadCaseSpace(
        ElasticArm(robot, joint_springs(robot), tool),
        force,
        moment,
        (),
        {**INSTRUMENTS, **COMMON}[name],
        limits,
    )
    q = rng.uniform(-2.0, 2.0, (6, n))
    at = space.evaluate(q)
    weights = rng.normal(size=at.blocks.shape) / np.abs(at.blocks).max()

    def scalar(x: np.ndarray) -> np.ndarray:
        return (space.evaluate(x).blocks * weights).sum(axis=(1, 2))

    expected = central_difference(scalar, q)
    assert at.pull(weights, np.zeros((6, 0))) == pytest.approx(
        expected, abs=GRADIENT * (1.0 + np.abs(expected).max())
    )


def test_isotropic_rows_are_those_over_sigma_to_the_last_bit() -> None:
    study, rng = kr270(A0), np.random.default_rng(2)
    x = study.space.sample(50, rng)
    cases = study.space.load_cases(x)
    rows = regressor(study.arm, cases) / SIGMA
    at = LoadCaseEvaluation(study.space, x)
    assert np.array_equal(at.blocks, rows)
    assert np.array_equal(study.space.information(cases), rows.transpose(0, 2, 1) @ rows)
    part = Regressor(study.arm, Posture(study.robot, x), cases.wrench)
    cotangent = rng.normal(size=rows.shape)
    expected = part.pull(np.ascontiguousarray(cotangent.transpose(1, 2, 0)) / SIGMA)[0]
    none = np.zeros_like(at.margins)
    assert np.array_equal(at.pull(cotangent, none), expected.T)


def test_information_of_a_tracker_is_that_of_weighted_least_squares() -> None:
    """Aᵀ Σ⁻¹ A with the covariance solved for, not factored."""
    study = replace(kr270(A0), instrument=TRACKER)
    cases = study.space.load_cases(study.space.sample(20, np.random.default_rng(3)))
    tool = study.experiments.tool
    rows = regressor(replace(study.arm, tool=tool), cases)
    points = Posture(study.robot, cases.q).point(tool.markers[0]).T
    expected = rows.transpose(0, 2, 1) @ np.linalg.solve(TRACKER.covariance(points), rows)
    scale = np.abs(expected).max()
    assert study.space.information(cases) == pytest.approx(expected, abs=1e-11 * scale)


def test_a_tracker_as_good_along_as_across_is_isotropic() -> None:
    ball = LaserTracker(np.array([3.0, 0.0, 1.0]), 1e-5, 0.0, 1e-5, 0.0)
    plain = Isotropic(np.sqrt(2.0) * 1e-5)
    study = kr270(A0)
    cases = study.space.load_cases(study.space.sample(10, np.random.default_rng(4)))
    one = replace(study, instrument=ball).space.information(cases)
    other = replace(study, instrument=plain).space.information(cases)
    assert one == pytest.approx(other, rel=1e-9, abs=1e-12 * np.abs(other).max())
    assert ball.sigma == pytest.approx(plain.sigma)


def test_presets_are_half_of_what_the_maker_permits() -> None:
    """Leica AT500: 10 µm + 0.3 µm/m along, 15 µm + 6 µm/m across, as permissible errors."""
    preset = PRESETS["leica-at500"]
    assert 2e6 * preset.along == pytest.approx(10.0)
    assert 2e6 * preset.along_per_metre == pytest.approx(0.3)
    assert 2e6 * preset.across == pytest.approx(15.0)
    assert 2e6 * preset.across_per_metre == pytest.approx(6.0)
    placed = preset.at(np.array([3.0, 0.0, 1.0]))
    assert placed.deviations(np.array(2.0)) == pytest.approx((5.3e-6, 13.5e-6))


def test_axis_1_is_free_only_where_the_instrument_does_not_see_it() -> None:
    """A hung weight and noise alike everywhere: A1 changes nothing. With a tracker it does."""
    study = kr270(A0)
    x = study.space.sample(6, np.random.default_rng(5))
    cases = study.space.load_cases(x)
    assert simplify(study.space, cases)[1] == ("A1",)
    tracked = replace(study, instrument=TRACKER)
    simple, free, _ = simplify(tracked.space, cases)
    assert free == ()
    assert np.array_equal(simple.q[:, 0], cases.q[:, 0])
    above = LaserTracker(np.array([0.0, 0.0, 6.0]), 5e-6, 1.5e-7, 7.5e-6, 3e-6)
    assert simplify(replace(study, instrument=above).space, cases)[1] == ("A1",)


def test_a_free_force_and_a_tracker_together() -> None:
    study = replace(kr270(A0, force=cone(30.0)), instrument=TRACKER)
    space, rng = study.space, np.random.default_rng(6)
    x = space.sample(4, rng)
    at = space.evaluate(x)
    weights = rng.normal(size=at.blocks.shape) / np.abs(at.blocks).max()
    margins = rng.normal(size=at.margins.shape)

    def scalar(y: np.ndarray) -> np.ndarray:
        there = space.evaluate(y)
        return (there.blocks * weights).sum(axis=(1, 2)) + (there.margins * margins).sum(axis=1)

    expected = central_difference(scalar, x)
    assert at.pull(weights, margins) == pytest.approx(
        expected, abs=GRADIENT * (1.0 + np.abs(expected).max())
    )


def test_a_marker_at_the_tracker_is_no_trap() -> None:
    robot = kuka_kr270()
    tool = robot.tools["calibration"]
    q = np.radians([[10.0, -60.0, 80.0, 20.0, 30.0, 0.0]])
    at = Posture(robot, q).point(tool.markers[0])[:, 0]
    study = replace(kr270(A0), instrument=replace(TRACKER, position=at))
    case = LoadCases(q, np.array([[0.0, 0.0, -2500.0, 0.0, 0.0, 0.0]]))
    assert np.isfinite(assess(study, case, np.array([3])).information).all()
    evaluation = study.space.evaluate(q)
    pulled = evaluation.pull(evaluation.blocks, evaluation.margins)
    assert np.isfinite(pulled).all()


@pytest.mark.parametrize("wrong", [0.0, -1.0, np.nan, np.inf])
def test_noise_must_be_a_positive_length(wrong: float) -> None:
    with pytest.raises(InputError, match="sigma must be a positive length"):
        Isotropic(wrong)
    for name in ("along", "across"):
        with pytest.raises(InputError, match="laser tracker"):
            replace(TRACKER, **{name: wrong})
    for name in ("along_per_metre", "across_per_metre"):
        if wrong == 0.0:
            assert replace(TRACKER, **{name: wrong}).sigma > 0.0
            continue
        with pytest.raises(InputError, match=f"{name} must not be negative"):
            replace(TRACKER, **{name: wrong})


def test_typical_noise_of_a_tracker_by_hand() -> None:
    """At 2 m: 5 and 6 µm along and across, of two readings, over three axes."""
    tracker = LaserTracker(np.zeros(3), 4e-6, 0.5e-6, 2e-6, 2e-6, typical_range=2.0)
    assert tracker.sigma == pytest.approx(1e-6 * np.sqrt(2.0 * (25.0 + 2.0 * 36.0) / 3.0))
    covariance = tracker.covariance(np.array([[0.0, 2.0, 0.0]]))[0]
    np.testing.assert_allclose(covariance, 2e-12 * np.diag([36.0, 25.0, 36.0]))
