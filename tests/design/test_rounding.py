"""Efficient apportionment (Pukelsheim & Rieder 1992)."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from elastocal.design.rounding import apportion

reproducible = settings(max_examples=200)
weights = st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=8).map(
    lambda values: np.array(values) / np.sum(values)
)


@pytest.mark.parametrize(
    ("shares", "count", "expected"),
    [
        ([1.0], 7, [7]),
        ([0.5, 0.5], 2, [1, 1]),
        ([0.25, 0.5, 0.25], 8, [2, 4, 2]),
        ([1 / 3, 1 / 3, 1 / 3], 9, [3, 3, 3]),
        ([0.2, 0.6, 0.2], 5, [1, 3, 1]),
        # Nearest integers would be 1, 10 of 11: the small weight must not be starved.
        ([0.05, 0.95], 11, [1, 10]),
        ([0.01, 0.99], 5, [1, 4]),
        # Rounding to the nearest gives 2 + 2 + 1 + 1 = 6 where seven are wanted.
        ([0.32, 0.32, 0.18, 0.18], 7, [2, 2, 2, 1]),
    ],
)
def test_small_examples(shares: list[float], count: int, expected: list[int]) -> None:
    """By hand, from the rule that max (n_i - 1)/w_i <= min n_i/w_i; ties as they come."""
    assert sorted(apportion(np.array(shares), count)) == sorted(expected)


@reproducible
@given(weights, st.integers(0, 40))
def test_sum_and_support(shares: np.ndarray, extra: int) -> None:
    count = len(shares) + extra
    repeats = apportion(shares, count)
    assert repeats.sum() == count
    assert (repeats >= 1).all()
    assert repeats.dtype == np.int64


@reproducible
@given(weights, st.integers(0, 40))
def test_no_repeat_can_be_moved_to_a_needier_point(shares: np.ndarray, extra: int) -> None:
    """The characterisation of efficient roundings: (n_i - 1)/w_i <= n_j/w_j for all i, j."""
    repeats = apportion(shares, len(shares) + extra)
    assert ((repeats - 1) / shares).max() <= (repeats / shares).min() * (1.0 + 1e-12)


@reproducible
@given(weights, st.integers(0, 40))
def test_promised_efficiency(shares: np.ndarray, extra: int) -> None:
    """min n_i/(m w_i) bounds the efficiency of the rounding by any information function; it is
    at least 1 - S/m."""
    count = len(shares) + extra
    promised = (apportion(shares, count) / (count * shares)).min()
    assert promised >= 1.0 - len(shares) / count - 1e-12


@pytest.mark.parametrize("count", [3, 5, 8, 11])
def test_no_other_rounding_promises_more(count: int) -> None:
    """By trying all of them."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        shares = rng.dirichlet(np.ones(3))
        promised = (apportion(shares, count) / shares).min()
        best = max(
            (np.array(trial) / shares).min()
            for trial in itertools.product(range(1, count), repeat=3)
            if sum(trial) == count
        )
        assert promised == pytest.approx(best, rel=1e-12)


@reproducible
@given(weights)
@example(np.array([0.4, 0.4, 0.2]))
def test_one_more_experiment_never_takes_one_away(shares: np.ndarray) -> None:
    """No Alabama paradox: divisor methods are monotone in the sample size."""
    before = apportion(shares, len(shares))
    for count in range(len(shares) + 1, len(shares) + 12):
        after = apportion(shares, count)
        # Between equal ratios either may come first, so compare up to such ties.
        ratio = np.round(after / shares, 9)
        assert (after >= before).all() or len(set(ratio)) < len(ratio)
        before = after


def test_points_without_weight_get_nothing() -> None:
    assert apportion(np.array([0.5, 0.0, 0.5, 1e-12]), 6).tolist() == [3, 0, 3, 0]


def test_too_few_experiments_go_to_the_largest_weights() -> None:
    assert apportion(np.array([0.1, 0.4, 0.2, 0.3]), 2).tolist() == [0, 1, 0, 1]


def test_weights_need_not_sum_to_one() -> None:
    assert apportion(np.array([10.0, 20.0, 10.0]), 8).tolist() == [2, 4, 2]
