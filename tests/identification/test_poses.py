"""Identification from poses: the closed form, the truth, refits, and rows that lack a part."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.regressor import regressor
from elastocal.fitting.goodness import p_value_ratio
from elastocal.identification.doubts import doubts
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.identification.validation import doubts_of_validation, leave_one_out, validate
from elastocal.measuring.instrument import Isotropic, PoseProbe
from elastocal.measuring.measurements import Measurements, chosen
from elastocal.simulation.virtual_campaign import Reality, simulate
from elastocal.study.study import Study
from tests.kr270 import kr270_study, kr270_truth, published_cases

SIGMA, TURN = 3e-5, 5e-5


@cache
def study() -> Study:
    return replace(kr270_study(), instrument=PoseProbe(Isotropic(SIGMA), TURN))


def read(seed: int = 5, *, quiet: float = 1.0, linear: bool = False) -> Measurements:
    """Four published configurations, each several times, with noise, or with nearly none."""
    one = replace(study(), instrument=PoseProbe(Isotropic(quiet * SIGMA), quiet * TURN))
    rng, repeats = np.random.default_rng(seed), np.array([3, 1, 5, 2])
    truth = kr270_truth(one)
    return simulate(one, truth, published_cases(4), repeats, rng, reality=Reality(linear=linear))


@cache
def found(sigma: str = "known") -> Identification:
    truth = kr270_truth(study())
    return identify(study().arm, read(), Fit(sigma=sigma), known=truth)  # type: ignore[arg-type]


def without(data: Measurements, drop: Array) -> Measurements:
    """The readings that are not dropped, (R,)."""
    return replace(
        data,
        case=data.case[~drop],
        marker=data.marker[~drop],
        deflection=data.deflection[~drop],
        covariance=data.covariance[~drop],
        unloaded_of=data.unloaded[~drop],
    )


def test_the_linear_fit_is_the_least_squares_of_all_six_rows() -> None:
    """Paper eq. (6) with the weights of the noise, by hand."""
    data = read(linear=True)
    rows = regressor(study().arm, data.cases) / np.repeat([SIGMA, TURN], 3)[:, None]
    values = data.deflection.reshape(-1, 6) / np.repeat([SIGMA, TURN], 3)
    rows = rows.reshape(-1, rows.shape[2])
    expected = np.linalg.lstsq(rows, values.ravel(), rcond=None)[0]
    linear = identify(study().arm, data, Fit(model="linear"))
    np.testing.assert_allclose(linear.compliance, expected, rtol=1e-11)
    np.testing.assert_allclose(linear.information, rows.T @ rows, rtol=1e-11)
    assert linear.dof == 6 * 11 - 5


def test_readings_without_noise_give_the_truth() -> None:
    truth = kr270_truth(study())
    exact = identify(study().arm, read(quiet=1e-6), known=truth)
    np.testing.assert_allclose(exact.compliance, truth.of(exact.identified), rtol=1e-7)
    assert np.abs(exact.residual).max() < 1e-9


def test_positions_and_rotations_alone_find_the_same() -> None:
    """Each by itself agrees with the truth within its errors, and with both at once."""
    data, truth = read(), kr270_truth(study())
    both = found()
    for drop in (data.rotations, ~data.rotations):
        part = identify(study().arm, without(data, drop), known=truth)
        off = (part.compliance - truth.of(part.identified)) / part.standard_error
        assert np.abs(off).max() < 4.0
        assert (part.standard_error > both.standard_error).all()
        assert [kind.name for kind in part.measurements.quantities] == [
            "rotation" if drop[0] else "position"
        ]
        assert len(doubts(part)) < 10
        judged = validate(study().arm, part.model, data)
        assert 0.8 < judged.inside <= 1.0


def test_left_out_residuals_are_those_of_a_refit() -> None:
    data, truth = read(), kr270_truth(study())
    whole = identify(study().arm, data, Fit(model="linear"), known=truth)
    keep = np.arange(len(data.cases)) != 4
    rest = identify(study().arm, chosen(data, keep), Fit(model="linear"), known=truth)
    judged = validate(study().arm, rest.model, chosen(data, ~keep))
    own = data.case == 4
    # By the linear model, as both fits: measured minus the rows of the refit.
    bent = ElasticArm(study().robot, rest.model.springs, data.tool)
    modelled = (regressor(bent, data.cases)[4] @ rest.model.compliance).reshape(2, 3)
    np.testing.assert_allclose(
        whole.left_out[own], data.deflection[own] - modelled, rtol=1e-6, atol=1e-13
    )
    deviation = leave_one_out(whole).deviation[own]
    np.testing.assert_allclose(deviation, judged.deviation, rtol=2e-2)


def test_noise_of_each_kind_in_its_own_unit() -> None:
    data = found().measurements
    position, rotation = data.quantities
    assert (position.name, position.unit, rotation.name, rotation.unit) == (
        "position", "m", "rotation", "rad")  # fmt: skip
    assert data.noise_of(position) == pytest.approx(SIGMA)
    assert data.noise_of(rotation) == pytest.approx(TURN)
    residual = np.zeros((len(data), 3))
    residual[data.rotations] = 1.0
    assert not data.by_experiment(residual, position).any()
    np.testing.assert_allclose(data.by_experiment(residual, rotation), np.sqrt(3.0))


def test_one_factor_for_both_kinds_if_the_noise_is_estimated() -> None:
    estimated = found("estimated")
    assert estimated.dof == 6 * 11 - 5
    np.testing.assert_allclose(
        estimated.standard_error, estimated.scale * found().standard_error, rtol=1e-9
    )


def noisier(turn: float, seed: int = 5) -> Identification:
    """Rotations with so many times the noise they promise."""
    one = replace(study(), instrument=PoseProbe(Isotropic(SIGMA), turn * TURN))
    rng, repeats, truth = np.random.default_rng(seed), np.array([9, 8, 9, 9]), kr270_truth(one)
    data = simulate(one, truth, published_cases(4), repeats, rng)
    promised = np.where(data.rotations, TURN, SIGMA)[:, None, None] ** 2 * np.eye(3)
    return identify(study().arm, replace(data, covariance=promised), known=truth)


def test_the_noise_of_each_kind_is_found_from_its_own_residuals() -> None:
    """Their freedoms and χ² are those of the fit; noise of twice the size is told, and once not."""
    for turn in (1.0, 2.0):
        one = noisier(turn)
        position, rotation = one.noise_of_kinds
        assert position.dof + rotation.dof == pytest.approx(one.dof)
        total = sum(n.dof * n.scale**2 for n in one.noise_of_kinds)
        assert total == pytest.approx(one.chi_square)
        assert position.scale == pytest.approx(1.0, abs=0.2)
        assert rotation.scale == pytest.approx(turn, rel=0.2)
        assert ("unlike-noise" in {d.code for d in doubts(one)}) == (turn > 1.0)
    alone = without(read(), read().rotations)
    one = identify(study().arm, alone, known=kr270_truth(study()))
    assert [n.scale for n in one.noise_of_kinds] == [one.scale]


def test_the_ratio_of_the_noises_is_judged_as_chance_would_have_it() -> None:
    """As promised: probabilities uniform from 0 to 1 (Kolmogorov and Smirnov)."""
    found = [noisier(1.0, seed).noise_of_kinds for seed in range(80)]
    p = [p_value_ratio(a.scale, a.dof, b.scale, b.dof) for a, b in found]
    assert stats.kstest(p, "uniform").pvalue > 0.05


def test_an_experiment_that_turns_the_wrong_way_is_named() -> None:
    """A rotation far out is an outlier by its own name; the position beside it is not."""
    data = read()
    wrong = np.array(data.deflection)
    wrong[7] += [0.0, 12.0 * TURN, 0.0]
    assert data.rotations[7]
    said = doubts(
        identify(study().arm, replace(data, deflection=wrong), known=kr270_truth(study()))
    )
    names = next(doubt.about for doubt in said if doubt.code == "outlying")
    assert names[0] == "4/rotation"
    robust = identify(
        study().arm,
        replace(data, deflection=wrong),
        Fit(loss="bisquare"),
        known=kr270_truth(study()),
    )
    assert robust.weight[7] < 0.1
    assert np.delete(robust.weight, 7).min() > 0.3


def test_a_model_that_turns_the_arm_wrongly_is_worse_by_kind() -> None:
    data = read()
    still = replace(found().model, compliance=0.0 * found().model.compliance)
    flipped = np.array(data.deflection)
    flipped[data.rotations] *= -1.0
    judged = validate(study().arm, found().model, replace(data, deflection=flipped))
    worse = next(d for d in doubts_of_validation(judged) if d.code == "worse-with-model")
    assert worse.about == tuple(f"{i + 1}/rotation" for i in range(11))
    nothing = validate(study().arm, still, data)
    before, after = nothing.sizes(data.quantities[1])
    assert before.rms == after.rms
