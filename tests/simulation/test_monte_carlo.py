"""Estimates of many campaigns: the same as `identify`, scattered as the theory says.

Bounds on statistics: seeds are fixed, so these tests do not flicker; their bounds are what chance
allows a correct program. With K campaigns a mean in units of its standard error has the standard
deviation 1/√K, a standard deviation 1/√(2K), a coverage √(0.95·0.05/K).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.neighbourhood import deflection_series
from elastocal.elastic.springs import joint_springs, subset
from elastocal.errors import IdentifiabilityError, InputError
from elastocal.fitting.least_squares import one_of
from elastocal.identification.batch import Design, fit_all
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.measuring.instrument import LaserTracker, PoseProbe
from elastocal.robot.shapes import BodyMass
from elastocal.simulation.campaigns import Campaigns, MonteCarlo
from elastocal.simulation.monte_carlo import CHUNK, campaigns
from elastocal.simulation.remaining_error import errors_left, judge
from elastocal.simulation.virtual_campaign import LoadError, Outliers, Reality, simulate
from elastocal.study.study import Study
from tests.arms import random_chain
from tests.campaigns import measured
from tests.kr270 import kr270_study, kr270_truth, published_cases, published_plans
from tests.paper.page import shows, tables

STUDY = kr270_study()
TRUTH = kr270_truth(STUDY)
PLANS = published_plans()
FITS = [Fit(m, s) for m in ("linear", "equilibrium") for s in ("known", "estimated")]  # type: ignore[arg-type]


def odd_study() -> Study:
    """Several markers, a tracker that does not see all points alike, links with weight."""
    tool = replace(
        STUDY.experiments.tool,
        markers=np.array([[0.6, 0.1, -0.4], [0.5, -0.2, 0.1]]),
        marker_names=("a", "b"),
    )
    robot = replace(
        STUDY.robot,
        masses=(BodyMass(2, 300.0, np.array([0.5, 0.0, 0.1])), BodyMass(4, 150.0, np.zeros(3))),
    )
    return replace(
        STUDY,
        robot=robot,
        experiments=replace(STUDY.experiments, tool=tool),
        instrument=LaserTracker(np.array([4.0, 1.0, 1.0]), 2e-6, 0.2e-6, 15e-6, 6e-6),
        gravity=np.array([0.0, 0.0, -9.81]),
    )


def odd_poses() -> Study:
    """The same with the rotation of the flange."""
    return replace(odd_study(), instrument=PoseProbe(odd_study().instrument, 8e-5))


@pytest.mark.parametrize("how", FITS, ids=lambda how: f"{how.model}, {how.sigma}")
@pytest.mark.parametrize(
    "study", [STUDY, odd_study(), odd_poses()], ids=["plain", "odd", "odd poses"]
)
@pytest.mark.parametrize("near", [True, False], ids=["near the truth", "from nothing"])
def test_the_batch_is_the_same_estimator_as_identify(study: Study, how: Fit, near: bool) -> None:
    """Estimate, covariance, chi-square: campaign by campaign to 1e-10."""
    cases, repeats = published_cases(4), np.array([3, 1, 5, 2])
    rng = np.random.default_rng(3)
    made = [simulate(study, TRUTH, cases, repeats, rng) for _ in range(4)]
    readings = np.array([m.deflection.reshape(len(m.cases), -1, 3) for m in made])
    case = np.repeat(np.arange(4), repeats)
    covariance = made[0].covariance.reshape(len(case), -1, 3, 3)[
        np.unique(case, return_index=True)[1]
    ]
    arm = replace(study.arm, springs=TRUTH.springs)
    design = Design(arm, np.arange(1, 6), TRUTH.compliance, cases, case, covariance, how.linear)
    if near and not how.linear:
        about = deflection_series(arm, TRUTH.compliance, cases, design.free)
        design = replace(design, near=about)
    found = fit_all(design, readings)
    for i, measurements in enumerate(made):
        one = identify(study.arm, measurements, how, known=TRUTH)
        np.testing.assert_allclose(found.compliance[i], one.compliance, rtol=1e-10)
        np.testing.assert_allclose(found.chi_square[i], one.chi_square, rtol=1e-9)
        variance = found.chi_square[i] / design.dof if how.sigma == "estimated" else 1.0
        error = np.sqrt(variance * np.diagonal(one_of(found.covariance, i)))
        np.testing.assert_allclose(error, one.standard_error, rtol=1e-8)
        assert design.dof == one.dof


def known_only(names: list[str]) -> ComplianceModel:
    return replace(
        TRUTH,
        springs=subset(TRUTH.springs, names),
        compliance=TRUTH.of(names),
        covariance=np.zeros((len(names), len(names))),
    )


def test_campaigns_far_from_the_truth_are_fitted_all_the_same() -> None:
    """Where the series is not exact, each is fitted on its own: next to others that need not be."""
    cases, repeats = published_cases(4), np.array([2, 1, 1, 1])
    rng = np.random.default_rng(4)
    far = replace(TRUTH, compliance=TRUTH.compliance * [1, 40, 1, 40, 1, 1])
    made = [simulate(STUDY, truth, cases, repeats, rng) for truth in (TRUTH, far, TRUTH, far)]
    readings = np.array([m.deflection.reshape(len(m.cases), -1, 3) for m in made])
    arm, free = replace(STUDY.arm, springs=TRUTH.springs), np.arange(1, 6)
    near = deflection_series(arm, TRUTH.compliance, cases, free)
    covariance = made[0].covariance.reshape(5, -1, 3, 3)[1:]
    case = np.repeat(np.arange(4), repeats)
    design = Design(arm, free, TRUTH.compliance, cases, case, covariance, False, near=near)
    found = fit_all(design, readings)
    for i, measurements in enumerate(made):
        one = identify(STUDY.arm, measurements, known=TRUTH)
        np.testing.assert_allclose(found.compliance[i], one.compliance, rtol=1e-9)
        error = np.sqrt(np.diagonal(one_of(found.covariance, i)))
        np.testing.assert_allclose(error, one.standard_error, rtol=1e-7)


def test_the_judge_is_the_position_after_compensation() -> None:
    """Compensated as a controller would: the commanded configuration is moved until the modelled
    arm under load is at the target; then the true arm is loaded there."""
    pose = STUDY.test_poses[0]
    estimate = TRUTH.compliance[1:] * np.array([1.02, 0.97, 1.01, 0.99, 1.03])
    left = errors_left(judge(STUDY.arm, TRUTH, pose, linear=False), estimate[None])[0]
    assert pose.tool is not None
    assert pose.case is not None
    tool = pose.tool.at_tcp
    arm = ec.ElasticArm(STUDY.robot, TRUTH.springs, tool)
    model = np.concatenate([TRUTH.compliance[:1], estimate])

    def loaded(q: np.ndarray, compliance: np.ndarray) -> np.ndarray:
        cases = ec.LoadCases(q[None], pose.case.wrench)
        still = ec.forward_kinematics(arm.robot, q[None])[0]
        return (
            still[:3, :3] @ tool.tcp
            + still[:3, 3]
            + ec.loaded_deflection(arm, compliance, cases)[0]
        )

    q0 = pose.case.q[0]
    target = loaded(q0, 0.0 * model)
    q = q0.copy()
    for _ in range(20):
        jacobian = ec.jacobian(arm.robot, q[None], tool.tcp)[0, :3]
        q -= np.linalg.pinv(jacobian) @ (loaded(q, model) - target)
    assert np.linalg.norm(loaded(q, model) - target) < 1e-12
    after = np.linalg.norm(loaded(q, TRUTH.compliance) - target)
    assert left == pytest.approx(after, rel=0.01)
    assert np.linalg.norm(loaded(q0, TRUTH.compliance) - target) > 20 * after


def test_a_pose_is_judged_by_its_load_case_where_it_has_one() -> None:
    pose = STUDY.test_poses[0]
    assert judge(STUDY.arm, TRUTH, pose, linear=False).arm is not None
    assert judge(STUDY.arm, TRUTH, pose, linear=True).arm is None
    for less in (replace(pose, case=None), replace(pose, tool=None)):
        bare = judge(STUDY.arm, TRUTH, less, linear=False)
        assert bare.arm is None
        estimate = TRUTH.compliance[None, 1:] * [[1.5, 1, 1, 1, 1], [1, 1, 1, 1, 3.0]]
        off = (estimate - TRUTH.compliance[1:]) @ pose.regressor.T
        np.testing.assert_allclose(errors_left(bare, estimate), np.linalg.norm(off, axis=1))


def test_poses_of_unequal_weight() -> None:
    """Weights 1 and 3 are a quarter and three quarters of every mean square."""
    pose = STUDY.test_poses[0]
    other = replace(pose, name="far", regressor=2.0 * pose.regressor, weight=3.0, case=None)
    two = replace(STUDY, test_poses=(pose, other))
    one = campaigns(
        two, TRUTH, {"a": PLANS["4 configurations"]}, 20, reality=Reality(linear=True)
    ).plans[0]
    np.testing.assert_allclose(one.weight, [0.25, 0.75])
    np.testing.assert_allclose(one.error[:, 1], 2.0 * one.error[:, 0])
    np.testing.assert_allclose(one.total, np.sqrt(0.25 + 0.75 * 4.0) * one.error[:, 0])
    assert one.rms == pytest.approx(np.sqrt(3.25 * np.mean(one.error[:, 0] ** 2)))
    assert one.rho0 == pytest.approx(np.sqrt(3.25) * one.rho0_each[0])


def test_columns_of_very_different_size() -> None:
    """Lengths in micrometres: compliances of turning springs a million times as large as others."""
    robot = random_chain(np.random.default_rng(5), [False, True, False])
    tool = ec.Tool("t", np.full(3, 0.2), np.array([[0.3, 0.1, 0.2], [0, 0.4, 0.1]]), ("a", "b"))
    arm = ec.ElasticArm(robot, joint_springs(robot), tool)
    rng = np.random.default_rng(6)
    cases = ec.LoadCases(rng.uniform(-1, 1, (5, 3)), rng.normal(size=(5, 6)))
    truth = np.array([1e-3, 1e-9, 2e-3])
    for linear in (True, False):
        made = [measured(arm, cases, truth, rng=rng, linear=linear, promised=1e-9, noise=1e-9)
                for _ in range(3)]  # fmt: skip
        readings = np.array([m.deflection.reshape(5, 2, 3) for m in made])
        covariance = made[0].covariance.reshape(5, 2, 3, 3)
        design = Design(arm, np.arange(3), np.zeros(3), cases, np.arange(5), covariance, linear)
        batch = fit_all(design, readings)
        how = Fit(model="linear" if linear else "equilibrium")
        single = [identify(arm, m, how) for m in made]
        expected = np.array([one.compliance for one in single])
        error = np.array([one.standard_error for one in single])
        assert np.abs((batch.compliance - expected) / error).max() < 1e-6
        if linear:
            np.testing.assert_allclose(batch.compliance[:, ::2], expected[:, ::2], rtol=1e-12)


def test_readings_in_another_unit_cannot_be_fitted() -> None:
    """Millimetres taken for metres: no campaign of the batch comes to rest, and it is said."""
    arm, cases = STUDY.arm, published_cases(4)
    read = measured(arm, cases, TRUTH.compliance[1:]).deflection.reshape(1, 4, 1, 3)
    covariance = np.tile(1e-10 * np.eye(3), (4, 1, 1, 1))
    design = Design(arm, np.arange(5), np.zeros(5), cases, np.arange(4), covariance, False)
    np.testing.assert_allclose(fit_all(design, read).compliance[0], TRUTH.compliance[1:], rtol=1e-9)
    with pytest.raises(InputError, match="a virtual campaign cannot be fitted"):
        fit_all(design, 1e3 * read)


def test_a_load_case_that_is_never_measured_changes_nothing() -> None:
    cases, repeats = next(iter(PLANS.values()))
    more = LoadCases(np.vstack([cases.q, cases.q[:1]]), np.vstack([cases.wrench, cases.wrench[:1]]))
    both = {"plain": (cases, repeats)}, {"plain": (more, np.append(repeats, 0))}
    plain, idle = (campaigns(STUDY, TRUTH, plan, 20, seed=3).plans[0] for plan in both)
    np.testing.assert_array_equal(plain.estimate, idle.estimate)


def check_statistics(found: Campaigns) -> None:
    """Everything that is claimed of a correct estimator, within what chance allows."""
    count, p = found.estimate.shape
    # 4.5 standard deviations: one of 500 correct programs with 50 numbers each would fail.
    assert np.abs(found.bias).max() < max(0.05, 4.5 / np.sqrt(count))
    assert np.abs(found.spread - 1.0).max() < 4.5 / np.sqrt(2 * count)
    assert (np.abs(found.coverage - 0.95) < 0.015).all()
    assert found.rms == pytest.approx(found.rho0, rel=0.03)
    statistic, chance = found.likelihood_ratio()
    assert chance > 1e-3, f"covariance: {statistic:.1f} at {p * (p + 1) // 2} degrees of freedom"


def check_page(found: MonteCarlo, row: str) -> None:
    """The page shows the extremes over all plans: to the digit, since seeds are fixed."""
    cover, bias, spread, rms = tables()["Do the intervals hold?: truth; fit; σ"][row]
    covered = 100.0 * np.array([one.coverage for one in found.plans])
    scatter = np.array([one.spread for one in found.plans])
    kept = np.array([one.rms / one.rho0 for one in found.plans])
    assert shows(cover, covered.min(), covered.max()), row
    assert shows(bias, np.max([np.abs(one.bias).max() for one in found.plans])), row
    assert shows(spread, scatter.min(), scatter.max()), row
    assert shows(rms, kept.min(), kept.max()), row


@pytest.mark.slow
@pytest.mark.parametrize("linear", [True, False], ids=["linear", "nonlinear"])
@pytest.mark.parametrize("sigma", ["known", "estimated"])
def test_estimates_scatter_as_predicted(linear: bool, sigma: str) -> None:
    """2000 campaigns of each published plan: linear truth, linear fit; nonlinear, iterated fit."""
    how = Fit("linear" if linear else "equilibrium", sigma)  # type: ignore[arg-type]
    found = campaigns(STUDY, TRUTH, PLANS, 2000, seed=11, how=how, reality=Reality(linear=linear))
    assert [one.experiments for one in found.plans] == [12] * 5
    assert found.known == ("A1",)
    for one in found.plans:
        check_statistics(one)
    check_page(found, f"{'linear; linear' if linear else 'nonlinear; iterated'}; {sigma}")
    chance = [one.likelihood_ratio()[1] for one in found.plans]
    assert 0.07 < min(chance) < max(chance) < 0.42


@pytest.mark.slow
def test_the_iterated_fit_has_no_bias_to_speak_of() -> None:
    """20 000 campaigns, in which a bias of 0.03 standard errors could not hide."""
    found = campaigns(STUDY, TRUTH, PLANS, 20_000, seed=12)
    for one in found.plans:
        assert np.abs(one.bias).max() < 0.035  # 0.007 is the standard deviation of chance
        assert (np.abs(one.coverage - 0.95) < 0.007).all()
    check_page(found, "nonlinear; iterated, 20 000 campaigns; known")


def test_the_linear_fit_of_a_nonlinear_truth_is_biased() -> None:
    """The negative control: what the statistics above would show if something were wrong.

    A bias does not shrink with repeats as the standard error does: with each load case measured
    once it is 0.3 to 0.8 standard errors, with 12 experiments in all up to 2.
    """
    worst = {}
    for experiments in (1, 12):
        plans = {
            name: (cases, np.full(len(repeats), 1) if experiments == 1 else repeats)
            for name, (cases, repeats) in PLANS.items()
        }
        found = campaigns(STUDY, TRUTH, plans, 2000, seed=11, how=Fit(model="linear"))
        worst[experiments] = {
            one.name: (np.abs(one.bias).max(), one.coverage.min(), one.likelihood_ratio()[1])
            for one in found.plans
        }
    check_page(found, "nonlinear; linear; known")
    once, often = worst[1], worst[12]
    few = [once[f"{m} configurations"] for m in (2, 3, 4)]
    assert [bias for bias, _, _ in few] == pytest.approx(3 * [0.82], abs=0.02)
    assert [coverage for _, coverage, _ in few] == pytest.approx(3 * [0.87], abs=0.01)
    biases = [bias for bias, _, _ in often.values()]
    assert (min(biases), max(biases)) == pytest.approx((1.47, 2.04), abs=0.01)
    for bias, coverage, scatter in often.values():
        assert bias > 1.4
        assert coverage < 0.75
        assert scatter > 1e-3  # only the mean is wrong, the scatter is not


def test_load_errors_and_outliers_break_the_prediction() -> None:
    """Two more negative controls: what the covariance (13) does not know of widens the scatter."""
    plan = {"plan": PLANS["4 configurations"]}
    loads = campaigns(STUDY, TRUTH, plan, 1000, seed=1, reality=Reality(LoadError(0.01, 0.005)))
    gross = campaigns(
        STUDY, TRUTH, plan, 1000, seed=1, reality=Reality(outliers=Outliers(0.1, 1e-3))
    )
    for found in (loads, gross):
        assert found.plans[0].likelihood_ratio()[1] < 1e-12
        assert found.plans[0].spread.max() > 1.3
        assert found.plans[0].coverage.min() < 0.9


def test_the_number_of_workers_changes_nothing() -> None:
    two = {name: PLANS[name] for name in ("3 configurations", "4 configurations")}
    number = CHUNK + 30
    alone, together = (
        campaigns(STUDY, TRUTH, two, number, seed=5, workers=workers) for workers in (1, 2)
    )
    for one, other in zip(alone.plans, together.plans, strict=True):
        np.testing.assert_array_equal(one.estimate, other.estimate)
        np.testing.assert_array_equal(one.standard_error, other.standard_error)
        np.testing.assert_array_equal(one.error, other.error)
    assert not np.any(alone.plans[0].estimate[:30] == alone.plans[0].estimate[CHUNK:])
    more = campaigns(STUDY, TRUTH, two, 2 * CHUNK, seed=5)
    np.testing.assert_array_equal(more.plans[0].estimate[:CHUNK], alone.plans[0].estimate[:CHUNK])


def test_noise_free_data_give_the_truth_back() -> None:
    """Linear data by the linear fit, nonlinear data by the iterated one: to 1e-10."""
    for linear, model in ((True, "linear"), (False, "equilibrium")):
        made = simulate(
            replace(STUDY, instrument=ec.Isotropic(1e-16)),
            TRUTH,
            published_cases(4),
            np.ones(4, dtype=int),
            np.random.default_rng(0),
            reality=Reality(linear=linear),
        )
        found = identify(STUDY.arm, made, Fit(model=model), known=TRUTH)  # type: ignore[arg-type]
        np.testing.assert_allclose(found.compliance, TRUTH.compliance[1:], rtol=1e-10)


def test_the_error_of_the_linear_fit_falls_linearly_with_the_load() -> None:
    """Noise-free nonlinear data: half the load, half the error, over three decades."""
    loads = np.append(2500.0 * 0.5 ** np.arange(10), 25.0)
    errors = []
    for load in loads:
        cases = published_cases(4, np.array([0.0, 0.0, -load]))
        exact = replace(STUDY, instrument=ec.Isotropic(1e-18))
        made = simulate(exact, TRUTH, cases, np.ones(4, dtype=int), np.random.default_rng(0))
        found = identify(STUDY.arm, made, Fit(model="linear"), known=TRUTH)
        errors.append(np.abs(found.compliance / TRUTH.compliance[1:] - 1.0))
    worst = 100.0 * np.max(errors, axis=1)
    assert worst[[0, 1, -1]] == pytest.approx([1.06, 0.53, 0.011], abs=0.005)
    ratios = np.array(errors[:-2]) / np.array(errors[1:-1])
    np.testing.assert_allclose(ratios[4:], 2.0, rtol=0.02)
    np.testing.assert_allclose(ratios, 2.0, rtol=0.4)
    assert 1e-3 < np.max(errors[0]) < 0.1


def test_what_cannot_be_simulated_is_refused() -> None:
    plan = {"plan": PLANS["4 configurations"]}
    with pytest.raises(InputError, match="truth says nothing of A2, which the study identifies"):
        campaigns(STUDY, known_only(["A1", "A3"]), plan, 10)
    with pytest.raises(InputError, match="at least 2, found 1"):
        campaigns(STUDY, TRUTH, plan, 1)
    with pytest.raises(InputError, match="workers must be at least 1"):
        campaigns(STUDY, TRUTH, plan, 10, workers=0)
    for how in (Fit(loss="huber"), Fit(nonnegative=True)):
        with pytest.raises(InputError, match="plain least squares, without bounds"):
            campaigns(STUDY, TRUTH, plan, 10, how=how)
    everything = replace(STUDY, springs=joint_springs(STUDY.robot), test_poses=())
    with pytest.raises(IdentifiabilityError, match="A1"):
        campaigns(everything, TRUTH, plan, 10)


def test_progress_is_told() -> None:
    told: list[tuple[str, float]] = []
    campaigns(
        STUDY,
        TRUTH,
        {"a": PLANS["2 configurations"]},
        4 * CHUNK + 1,
        progress=lambda *a: told.append(a),
    )
    assert told == [("a", 0.8), ("a", 1.0)]
