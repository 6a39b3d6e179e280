"""What is weak in a result is said, whatever was chosen to make it; a right result stays strong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import Doubt
from elastocal.fitting.goodness import SURE
from elastocal.identification.doubts import SELDOM, doubts, is_weak
from elastocal.identification.fit import Fit
from elastocal.identification.growth import growth
from elastocal.identification.identify import identify
from elastocal.measuring.measurements import Measurements
from elastocal.wording import identification as words
from elastocal.wording import worded
from tests.campaigns import NAMES, SIGMA, TRUTH, arm, hung, measured

LINEAR, ESTIMATED = Fit("linear"), Fit("linear", "estimated")


def campaign(seed: int, *, count: int = 24, noise: float = SIGMA) -> Measurements:
    """Weights of 500 to 4000 N, read with `noise` where SIGMA is promised."""
    rng = np.random.default_rng(seed)
    cases = hung(count, seed)
    cases = LoadCases(cases.q, cases.wrench * rng.uniform(0.2, 1.6, (count, 1)))
    return measured(arm(), cases, rng=rng, linear=True, noise=noise)


def said(data: Measurements, how: Fit = LINEAR) -> dict[str, Doubt]:
    return {doubt.code: doubt for doubt in doubts(identify(arm(), data, how))}


def test_an_estimated_noise_is_still_compared_with_the_promised_one() -> None:
    data = campaign(1, noise=5.0 * SIGMA)
    for how in (
        LINEAR,
        ESTIMATED,
        Fit("linear", loss="huber"),
        Fit("linear", "estimated", "huber"),
    ):
        noisy = said(data, how)["noisier-than-promised"]
        assert noisy.numbers["scale"] == pytest.approx(5.0, rel=0.3)
        assert is_weak(noisy)
        assert ("estimate σ" in worded(noisy)) != how.estimates_sigma


def test_little_explained_is_said_with_its_reason() -> None:
    data = campaign(2)
    turned = replace(data, deflection=data.deflection[:, [1, 2, 0]])  # the frame of another
    little = said(turned, ESTIMATED)["explains-little"]
    assert little.numbers["left"] > 0.5 * little.numbers["whole"]
    assert "look at signs" in worded(little)
    light = measured(arm(), hung(40, force=60.0), rng=np.random.default_rng(3))
    assert "the noise that σ promises" in worded(said(light)["explains-little"])
    assert "explains-little" not in said(data)


def test_large_standard_errors_are_said() -> None:
    data = measured(arm(), hung(12, force=60.0), rng=np.random.default_rng(5))
    found = identify(arm(), data, LINEAR)
    told = {n for d in doubts(found) if d.code.startswith(("hardly", "zero")) for n in d.about}
    vague = {n for n, e in zip(found.identified, found.relative_error, strict=True) if e > 0.3}
    assert vague
    assert vague <= told | {n for n, k in zip(NAMES, found.compliance, strict=True) if k < 0.0}


def test_residuals_that_grow_with_the_load() -> None:
    """A load cell that is off by 5 %, otherwise each time."""
    data, rng = campaign(6, count=40), np.random.default_rng(6)
    off = 1.0 + 0.05 * rng.normal(size=(len(data), 1))
    wrong = identify(arm(), replace(data, deflection=data.deflection * off), ESTIMATED)
    trend = growth(wrong)
    assert trend is not None
    assert trend.p_value < SURE
    assert is_weak(next(d for d in doubts(wrong) if d.code == "grows-with-load"))
    assert growth(identify(arm(), measured(arm(), hung(12), rng=rng), LINEAR)) is None  # one load


def test_growth_has_its_distribution() -> None:
    p_values = []
    for seed in range(400):
        trend = growth(identify(arm(), campaign(seed), LINEAR))
        assert trend is not None
        p_values.append(trend.p_value)
    assert abs(np.mean(p_values) - 0.5) < 4.0 / np.sqrt(12 * 400)
    assert 0.02 < np.mean(np.array(p_values) < 0.05) < 0.09


def test_sizes_that_no_joint_has() -> None:
    data = campaign(7)
    light = replace(data, cases=LoadCases(data.cases.q, 1e-3 * data.cases.wrench))  # kN for N
    soft = said(light, ESTIMATED)["softer-than-any"]
    assert set(soft.about) <= set(NAMES)
    assert soft.unit == "rad/(N·m)"


def test_a_bound_does_not_hide_what_it_holds() -> None:
    truth = np.where(np.array(NAMES) == "A6", -0.4e-6, TRUTH)
    data = measured(arm(), hung(12), truth, rng=np.random.default_rng(8), linear=True)
    free = identify(arm(), data, LINEAR)
    held = identify(arm(), data, Fit("linear", nonnegative=True))
    assert held.held == ("A6",)
    (doubt,) = (d for d in doubts(held) if d.code == "held-at-zero")
    assert doubt.numbers["A6"] == pytest.approx(free.compliance[-1])
    assert doubt.numbers["A6"] < 0.0
    (negative,) = (d for d in doubts(free) if d.code == "negative")
    assert "bound" not in worded(negative)


def test_repeated_load_cases_of_a_plan_carry_nothing_odd() -> None:
    cases = hung(3, seed=4)
    rng = np.random.default_rng(9)
    thrice = LoadCases(np.repeat(cases.q, 3, axis=0), np.repeat(cases.wrench, 3, axis=0))
    single = doubts(identify(arm(), measured(arm(), cases, rng=rng, linear=True), LINEAR))
    repeated = doubts(identify(arm(), measured(arm(), thrice, rng=rng, linear=True), LINEAR))
    assert "carried" in {doubt.code for doubt in single}
    assert "carried" not in {doubt.code for doubt in repeated}


def test_what_chance_may_do_is_no_weakness() -> None:
    assert words.SURE == SURE < SELDOM
    assert is_weak(Doubt("grows-with-load", numbers={"p_value": 0.5 * SURE}))
    assert not is_weak(Doubt("grows-with-load", numbers={"p_value": 2.0 * SURE}))
    assert is_weak(Doubt("negative", ("A2",)))
    assert words.chance(0.0026) == "as in one of 385 right models (p = 0.0026)"


def test_right_models_are_seldom_doubted() -> None:
    odd = [[d for d in doubts(identify(arm(), campaign(s), LINEAR))] for s in range(200)]
    weak = [
        s
        for s, found in enumerate(odd)
        if any(d.code != "linear-model" and is_weak(d) for d in found)
    ]
    assert len(weak) <= 4
