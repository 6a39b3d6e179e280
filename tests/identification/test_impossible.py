"""What no arm can have measured is refused; what is only noisy, or a wrong convention, is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.impossible import (
    LOAD,
    NOISES,
    SHARE,
    refuse_impossible_fit,
    refuse_impossible_readings,
)
from elastocal.measuring.measurements import Measurements
from tests.campaigns import SIGMA, TRUTH, arm, hung, measured

ARM = arm()


def campaign(noise: float = SIGMA, count: int = 12) -> Measurements:
    rng = np.random.default_rng(3)
    return measured(ARM, hung(count, seed=1), rng=rng, linear=True, noise=noise)


def with_joints(data: Measurements, change: Callable[[np.ndarray], np.ndarray]) -> Measurements:
    return replace(data, cases=LoadCases(change(np.array(data.cases.q)), data.cases.wrench))


def with_loads(data: Measurements, factor: float) -> Measurements:
    return replace(data, cases=LoadCases(data.cases.q, factor * data.cases.wrench))


def fitted(data: Measurements, **how: object) -> None:
    refuse_impossible_fit(identify(ARM, data, Fit(**({"model": "linear"} | how))))  # type: ignore[arg-type]


def refused(data: Measurements) -> str:
    with pytest.raises(InputError) as caught:
        refuse_impossible_readings(data, ARM.robot)
    assert caught.value.doubts
    return str(caught.value)


def test_degrees_as_radians_are_refused_before_any_fit() -> None:
    said = refused(with_joints(campaign(), np.degrees))
    assert (
        "test: no robot stands there: A1, A2, A3, A4, A5, A6 are far beyond the limits in 12"
        in said
    )
    assert "were degrees meant?" in said


def test_one_experiment_out_of_twelve_is_a_remark() -> None:
    def one(q: np.ndarray) -> np.ndarray:
        q[3] = 40.0
        return q

    refuse_impossible_readings(with_joints(campaign(), one), ARM.robot)


@pytest.mark.parametrize(("factor", "ok"), [(0.99 * LOAD / 2500.0, True), (1e3, False)])
def test_loads_that_no_robot_bears(factor: float, ok: bool) -> None:
    data = with_loads(campaign(), factor)
    if ok:
        refuse_impossible_readings(data, ARM.robot)
    else:
        assert "most loads are 2.5e+06 N or so; look at their unit" in refused(data)


def test_deflections_that_are_a_good_part_of_the_arm() -> None:
    data = campaign()
    size = np.linalg.norm(data.deflection, axis=1)
    least = SHARE * 3.9 / np.median(size)  # the arm reaches 3.9 m at most
    said = refused(replace(data, deflection=1.1 * least * data.deflection))
    assert "no arm bends so far" in said
    refuse_impossible_readings(replace(data, deflection=0.3 * least * data.deflection), ARM.robot)
    few = np.array(data.deflection)
    few[:5] *= 1e4  # a beam that broke, five times of twelve
    refuse_impossible_readings(replace(data, deflection=few), ARM.robot)


@pytest.mark.parametrize("times", [1.0, 3.0, 10.0, 25.0])
def test_more_noise_than_promised_is_no_impossibility(times: float) -> None:
    """Whatever comes out negative of it."""
    fitted(campaign(times * SIGMA))


def test_noise_beyond_all_promises_with_springs_below_zero() -> None:
    data = campaign(300.0 * SIGMA)
    found = identify(ARM, data, Fit(model="linear"))
    assert found.scale > NOISES
    assert (found.compliance < 0.0).any()  # the noise is larger than what A2 bends
    with pytest.raises(
        InputError, match=r"times as far from the model as σ promises, with .* below"
    ):
        refuse_impossible_fit(found)
    fitted(data, sigma="estimated")
    fitted(data, loss="huber")
    with pytest.raises(InputError, match="below zero"):
        fitted(data, nonnegative=True)


def test_as_noisy_with_all_above_zero_and_within_limits() -> None:
    """A σ that is promised a hundred times too small is a remark."""
    data = campaign()
    fitted(replace(data, covariance=1e-4 * data.covariance))
    names = identify(ARM, replace(data, covariance=1e-4 * data.covariance), Fit(model="linear"))
    assert names.scale > NOISES

    def lifted(q: np.ndarray) -> np.ndarray:
        return np.asarray(q + np.array([0.0, 3.0, 0.0, 0.0, 0.0, 0.0]))

    beyond = with_joints(replace(data, covariance=1e-4 * data.covariance), lifted)
    with pytest.raises(InputError, match="A2 beyond its limits"):
        fitted(beyond)


def test_exchanged_states_are_refused_and_one_negative_spring_is_not() -> None:
    data = campaign()
    with pytest.raises(InputError, match="all of A2, A3, A4, A5, A6 do: were loaded and unloaded"):
        fitted(replace(data, deflection=-data.deflection))
    odd = TRUTH * [-1.0, 1.0, 1.0, 1.0, 1.0]
    fitted(measured(ARM, hung(12, seed=1), odd, linear=True))


def with_deflection(data: Measurements, rows: slice, value: list[float]) -> Measurements:
    deflection = np.array(data.deflection)
    deflection[rows] = value
    return replace(data, deflection=deflection)


def test_deflections_that_nobody_read_are_refused() -> None:
    data = campaign()
    half = len(data) // 2
    said = refused(with_deflection(data, slice(half + 1), [0.0, 0.0, 0.0]))
    assert f"{half + 1} of {len(data)} deflections under load are exactly zero" in said
    said = refused(with_deflection(data, slice(None), [1e-3, 0.0, -2e-3]))
    assert "are the same to the last digit" in said
    refuse_impossible_readings(with_deflection(data, slice(half), [0.0, 0.0, 0.0]), ARM.robot)
    refuse_impossible_readings(with_deflection(data, slice(1, None), [1e-3, 0, 0]), ARM.robot)


def test_repeats_of_one_load_case_may_be_the_same() -> None:
    """A gauge with coarse digits; and nothing bends where there is no load."""
    data = campaign()
    first = np.zeros(len(data.cases), dtype=int)
    one = LoadCases(data.cases.q[first], data.cases.wrench[first])
    same = with_deflection(replace(data, cases=one), slice(None), [1e-3, 0.0, -2e-3])
    refuse_impossible_readings(same, ARM.robot)
    nothing = with_deflection(with_loads(data, 0.0), slice(None), [0.0, 0.0, 0.0])
    refuse_impossible_readings(nothing, ARM.robot)
