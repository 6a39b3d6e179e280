"""The largest sum of what few load cases tell."""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.planning.shared_bound import largest_sum


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.integers(1, 5))
def test_against_all_splits(seed: int, count: int, distinct: int) -> None:
    """The best of several concave curves, as those of several load cases are."""
    rng = np.random.default_rng(seed)
    size, shared = rng.uniform(0.2, 5.0, 4), rng.uniform(0.0, 2.0, 4)
    asked: list[int] = []

    def most(n: int) -> float:
        asked.append(n)
        return float((size * n / (1.0 + n * shared)).max())

    found = largest_sum(most, count, distinct)
    assert len(asked) == len(set(asked))
    best = max(
        sum(most(n) for n in parts if n)
        for parts in combinations_with_replacement(range(count + 1), distinct)
        if sum(parts) == count
    )
    assert found == pytest.approx(best, rel=1e-11)


def test_independent_repeats_are_asked_about_once() -> None:
    asked: list[int] = []

    def most(n: int) -> float:
        asked.append(n)
        return 2.0 * n

    assert largest_sum(most, 12, 12) == pytest.approx(24.0)
    assert asked == [1]
