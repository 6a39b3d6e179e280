"""Mixed estimation: the textbook without a prior, the likelihood, coverage with one."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.special import stdtrit

from elastocal.fitting import mixed
from elastocal.fitting.few_readings import spread_of_few
from elastocal.fitting.mixed import (
    Rows,
    condensed,
    estimate,
    freedom,
    noise_variance,
    spread_found,
    spread_known,
)


def campaign(
    rng: np.random.Generator, *, readings: int = 12, sigma: float = 1.0, prior: float | None = 0.2
) -> tuple[Rows, np.ndarray]:
    """Readings with a half of them in doubt by more than their noise, and a prior; the truth."""
    p = 4
    x = rng.normal(size=(readings, p))
    x[:, 0] *= 0.05  # only a prior can tell it
    truth = rng.normal(size=p)
    absolute = np.where(np.arange(readings) < readings // 2, 0.0, 0.5)
    y = x @ truth + rng.normal(size=readings) * np.sqrt(sigma**2 + absolute)
    own = np.ones(readings)
    if prior is not None:
        mean = truth + prior * rng.normal(size=p)
        x, y = np.vstack([x, np.eye(p) / prior]), np.append(y, mean / prior)
        own, absolute = np.append(own, np.zeros(p)), np.append(absolute, np.ones(p))
    return Rows(x, y, own, absolute), truth


def minus_log_likelihood(rows: Rows, variance: float) -> float:
    """Restricted, up to a constant."""
    weight = rows.weight(variance)
    found, covariance = estimate(rows, variance)
    square = float(np.sum(weight * (rows.values - rows.rows @ found) ** 2))
    return 0.5 * (square - float(np.log(weight).sum()) - np.linalg.slogdet(covariance)[1])


def test_without_prior_it_is_the_textbook() -> None:
    rng = np.random.default_rng(0)
    x, y = rng.normal(size=(20, 3)), 7.0 * rng.normal(size=20)
    rows = Rows(x, y, np.ones(20), np.zeros(20))
    found, _ = estimate(rows, 1.0)
    square = float(np.sum((y - x @ found) ** 2)) / 17
    assert noise_variance(rows) == pytest.approx(square, rel=1e-9)
    spread = spread_found(rows, square)
    assert spread.dof == pytest.approx(17.0)
    np.testing.assert_allclose(spread.covariance, square * np.linalg.inv(x.T @ x), rtol=1e-9)
    np.testing.assert_allclose(freedom(spread, np.eye(3)), 17.0)
    assert rows.pure_dof == 17


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("sigma", [0.1, 1.0, 10.0])
def test_the_noise_is_the_maximum_of_the_likelihood(seed: int, sigma: float) -> None:
    rows, _ = campaign(np.random.default_rng(seed), sigma=sigma, readings=24)
    variance = noise_variance(rows)
    best = minimize_scalar(
        lambda log: minus_log_likelihood(rows, float(np.exp(log))),
        bounds=(np.log(variance) - 2.0, np.log(variance) + 2.0),
        method="bounded",
        options={"xatol": 1e-9},
    )
    assert np.log(variance) == pytest.approx(best.x, abs=1e-5)


@pytest.mark.parametrize("sigma", [3.0, 30.0])
def test_noise_among_large_errors_is_found_in_few_rounds(
    sigma: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Promised far too small: scoring alone goes up by some percent in each of fifty rounds."""
    rng = np.random.default_rng(1)
    x = rng.normal(size=(3000, 6))
    absolute = 10.0 ** rng.uniform(1.5, 3.5, 3000)
    absolute[:4] = 0.0
    y = rng.normal(size=3000) * np.sqrt(sigma**2 + absolute)
    rows, asked = Rows(x, y, np.ones(3000), absolute), []

    def counted(rows: Rows, variance: float) -> tuple[np.ndarray, np.ndarray]:
        asked.append(variance)
        return estimate(rows, variance)

    monkeypatch.setattr(mixed, "estimate", counted)
    variance = noise_variance(rows)
    assert len(asked) < 20
    around = [minus_log_likelihood(rows, variance * np.exp(step)) for step in (-0.01, 0.0, 0.01)]
    assert around[1] == min(around)
    assert 0.5 * sigma < np.sqrt(variance) < 2.0 * sigma


def test_fewer_rows_say_the_same() -> None:
    rows, _ = campaign(np.random.default_rng(3), readings=40)
    few = condensed(rows)
    assert len(few.rows) < len(rows.rows)
    assert noise_variance(few) == pytest.approx(noise_variance(rows), rel=1e-8)
    whole, part = spread_found(rows, 1.3), spread_found(few, 1.3)
    np.testing.assert_allclose(part.covariance, whole.covariance, rtol=1e-9, atol=1e-15)
    assert part.dof == pytest.approx(whole.dof, rel=1e-9)
    assert few.pure_dof == rows.pure_dof == 16


def test_the_part_of_the_noise_is_the_slope_of_the_covariance() -> None:
    rows, _ = campaign(np.random.default_rng(4))
    step = 1e-5
    slope = (estimate(rows, 1.0 + step)[1] - estimate(rows, 1.0 - step)[1]) / (2.0 * step)
    np.testing.assert_allclose(spread_found(rows, 1.0).by_noise, slope, rtol=1e-6, atol=1e-9)


def test_what_only_a_prior_knows_keeps_its_uncertainty() -> None:
    """The noise found is ten times the promised one; the prior stays what it was."""
    x = np.zeros((30, 2))
    x[:, 0] = 1.0
    y = 10.0 * np.random.default_rng(5).normal(size=30)
    prior = np.eye(2) / 0.3
    rows = Rows(
        np.vstack([x, prior]),
        np.append(y, [0.0, 1.0]),
        np.append(np.ones(30), np.zeros(2)),
        np.append(np.zeros(30), np.ones(2)),
    )
    spread = spread_found(rows, noise_variance(rows))
    assert np.sqrt(spread.covariance[1, 1]) == pytest.approx(0.3, rel=1e-9)
    assert np.isinf(freedom(spread, np.array([[0.0, 1.0]])))[0]


def test_no_noise_is_found_where_nothing_shows_it() -> None:
    rows = Rows(np.eye(2), np.zeros(2), np.ones(2), np.full(2, 0.5))
    assert noise_variance(rows) == 0.0
    assert rows.pure_dof == 0


@pytest.mark.parametrize("sigma", [0.1, 1.0, 10.0])
def test_intervals_hold_the_truth_as_often_as_they_say(sigma: float) -> None:
    """600 campaigns, 4 unknowns each: 95 % within four standard errors of that count; scaling the
    prior with the noise, as if it were as wrong as the readings, does not."""
    rng, count, inside, scaled = np.random.default_rng(6), 600, 0, 0
    for _ in range(count):
        rows, truth = campaign(rng, sigma=sigma, readings=20)
        variance = noise_variance(rows)
        spread = spread_found(rows, variance)
        found, _ = estimate(rows, variance)
        error = np.sqrt(np.diagonal(spread.covariance))
        width = stdtrit(np.minimum(freedom(spread, np.eye(4)), 1e9), 0.975)
        inside += int(np.sum(np.abs(found - truth) <= width * error))
        wrong = replace_all_by_own(rows)
        promised = spread_known(wrong).covariance * sigma**2
        scaled += int(np.sum(np.abs(found - truth) <= 1.96 * np.sqrt(np.diagonal(promised))))
    assert inside / (4 * count) == pytest.approx(0.95, abs=0.02)
    if sigma != 1.0:
        assert abs(scaled / (4 * count) - 0.95) > 0.02


def replace_all_by_own(rows: Rows) -> Rows:
    return Rows(rows.rows, rows.values, np.ones(len(rows.own)), np.zeros(len(rows.own)))


def test_few_readings_leave_room_for_all_sizes_of_the_noise() -> None:
    """One pure degree of freedom and a prior: intervals hold at least as often as they say, where
    the likelihood alone falls short."""
    rng, inside, alone, count = np.random.default_rng(8), 0, 0, 150
    for _ in range(count):
        x, truth = rng.normal(size=(3, 2)), rng.normal(size=2)
        mean = truth + 0.3 * rng.normal(size=2)
        values = np.append(x @ truth + rng.normal(size=3), mean / 0.3)
        rows = Rows(
            np.vstack([x, np.eye(2) / 0.3]), values,
            np.array([1.0, 1, 1, 0, 0]), np.array([0.0, 0, 0, 1, 1]),
        )  # fmt: skip
        assert rows.pure_dof == 1
        spread = spread_of_few(rows)
        found, _ = estimate(rows, spread.variance)
        width = stdtrit(freedom(spread, np.eye(2)), 0.975)
        inside += int(
            np.sum(np.abs(found - truth) <= width * np.sqrt(np.diagonal(spread.covariance)))
        )
        variance = noise_variance(rows)
        if variance > 0.0:
            _, narrow = estimate(rows, variance)
            other, _ = estimate(rows, variance)
            alone += int(np.sum(np.abs(other - truth) <= 1.96 * np.sqrt(np.diagonal(narrow))))
    assert 0.93 < inside / (2 * count) <= 1.0
    assert alone / (2 * count) < 0.9


def test_without_prior_few_readings_are_student() -> None:
    """Flat in s, one degree of freedom, nothing known: the interval is that of Student's t."""
    x = np.array([[1.0], [1.0], [2.0]])
    rows = Rows(x, np.array([0.4, -0.3, 1.0]), np.ones(3), np.zeros(3))
    spread = spread_of_few(rows)
    width = stdtrit(freedom(spread, np.eye(1))[0], 0.975) * np.sqrt(spread.covariance[0, 0])
    found, _ = estimate(rows, 1.0)
    square = float(np.sum((rows.values - x @ found) ** 2)) / 2.0
    exact = stdtrit(1, 0.975) * np.sqrt(2.0 * square / 6.0)  # flat in s: one freedom less
    assert width == pytest.approx(exact, rel=0.02)
