"""Influence of groups of readings, each number against a refit without the group."""

from __future__ import annotations

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.fitting.influence import influence, reordered, shifts

GROUP = np.array([2, 0, 1, 1, 0, 2, 2])
SCALES = np.array([1.0, 1e3, 1e-4])


def problem() -> tuple[Array, Array, Array, Array]:
    """Rows (7, 2, 3) of very different columns, values, the fit and its information."""
    rng = np.random.default_rng(0)
    rows, values = rng.normal(size=(7, 2, 3)) * SCALES, rng.normal(size=(7, 2))
    return rows, values, *refit(rows, values)


def refit(rows: Array, values: Array) -> tuple[Array, Array]:
    flat = rows.reshape(-1, 3) / SCALES
    found = np.linalg.lstsq(flat, values.reshape(-1), rcond=None)[0] / SCALES
    return found, np.outer(SCALES, SCALES) * (flat.T @ flat)


def test_leaving_a_group_out_is_refitting() -> None:
    rows, values, whole, information = problem()
    residual = values - rows @ whole
    found = influence(rows, residual, GROUP, 3, information)
    covariance = np.linalg.inv(information)
    for g in range(3):
        own = g == GROUP
        without, less = refit(rows[~own], values[~own])
        shift = without - whole
        np.testing.assert_allclose(found.shift[g], shift, rtol=1e-8)
        assert found.cook[g] == pytest.approx(shift @ information @ shift / 3.0)
        ratio = np.sqrt(np.diagonal(np.linalg.inv(less)) / np.diagonal(covariance))
        np.testing.assert_allclose(found.error_ratio[g], ratio, rtol=1e-8)
        mine = rows[own].reshape(-1, 3)
        assert found.leverage[g] == pytest.approx(np.trace(mine @ covariance @ mine.T))
    assert found.leverage.sum() == pytest.approx(3.0)


def test_a_group_that_alone_sees_an_unknown() -> None:
    """No refit without it: infinite error ratios, no shift, leverage of one at least."""
    rows, values, *_ = problem()
    rows[GROUP != 1, :, 2] = 0.0
    whole, information = refit(rows, values)
    found = influence(rows, values - rows @ whole, GROUP, 3, information)
    assert np.isnan(found.shift[1]).all()
    assert np.isinf(found.error_ratio[1]).all()
    assert found.leverage[1] > 1.0 - 1e-9
    assert np.isfinite(found.shift[[0, 2]]).all()


@pytest.mark.parametrize("unknowns", [3, 5, 9])
def test_shifts_alone_are_the_same(unknowns: int) -> None:
    """Few unknowns go another way than many."""
    rng = np.random.default_rng(unknowns)
    rows, residual = rng.normal(size=(60, 3, unknowns)), rng.normal(size=(60, 3))
    rows[:2, :, 0], rows[2:, :, 0] = 1.0, 0.0
    group = np.repeat(np.arange(30), 2)
    flat = rows.reshape(-1, unknowns)
    whole = flat.T @ flat
    found = shifts(rows, residual, group, 30, whole)
    assert np.isnan(found[0]).all()
    expected = influence(rows, residual, group, 30, whole)
    np.testing.assert_allclose(found, expected.shift, rtol=1e-9)
    for g in range(1, 30):
        own = rows[group == g].reshape(-1, unknowns)
        pulled = own.T @ residual[group == g].ravel()
        np.testing.assert_allclose(found[g], -np.linalg.solve(whole - own.T @ own, pulled))
        ratio = np.diagonal(np.linalg.inv(whole - own.T @ own)) / np.diagonal(np.linalg.inv(whole))
        np.testing.assert_allclose(expected.error_ratio[g] ** 2, ratio)


def test_reordered_groups_keep_their_numbers() -> None:
    rows, values, whole, information = problem()
    found = influence(rows, values - rows @ whole, GROUP, 3, information)
    order = np.array([2, 0, 1])
    other = reordered(found, order)
    moved = influence(rows, values - rows @ whole, np.argsort(order)[GROUP], 3, information)
    for name in ("leverage", "cook", "shift", "error_ratio"):
        np.testing.assert_allclose(getattr(other, name), getattr(moved, name), rtol=1e-10)
