"""Blind errors of many plans at once, against those of one plan, which are made by other code."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from elastocal.elastic.load_cases import LoadCases
from elastocal.files.study.study_file import read_study
from elastocal.planning.blind import UNSEEN, blind_errors
from elastocal.planning.blind_columns import columns_of
from elastocal.planning.blind_sums import blind_sums
from elastocal.study.study import Study
from tests.kr270 import FOLDER, kr270_study
from tests.planning.test_blind import with_tilts


def drawn(study: Study, count: int, seed: int) -> tuple[LoadCases, np.ndarray]:
    rng = np.random.default_rng(seed)
    cases = study.space.load_cases(study.space.sample(count, rng))
    return cases, rng.integers(1, 4, count)


@pytest.mark.parametrize("make", [kr270_study, lambda: with_tilts(3e-8)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_largest_is_at_least_that_of_what_is_listed(
    make: Callable[[], Study], seed: int
) -> None:
    """It is, but where an axis between those that are listed is worse."""
    study = make()
    cases, repeats = drawn(study, 5 + seed, seed)
    sums, found = blind_sums(study, cases), blind_errors(study, cases, repeats)
    assert found is not None
    total = sums.informations(cases, repeats).sum(axis=0)[None]
    worst = float(sums.worst(total, len(cases))[0])
    listed = max(effect.error for effect in found.visible)
    assert worst >= listed * (1.0 - 1e-6)
    between = between_axes(study, cases, repeats, found.seen_half)
    assert worst == pytest.approx(max(listed, between), rel=1e-4)


def between_axes(study: Study, cases: LoadCases, repeats: np.ndarray, half: float) -> float:
    """Largest blind error of springs at 45° to the axis that is seen least, written out."""
    told = columns_of(study, cases, repeats)
    assert told is not None
    first, worst = 0, 0.0
    angles = np.linspace(0.0, np.pi, 20001)
    turned = np.column_stack([np.cos(angles) ** 2, np.sin(angles) ** 2, 0.5 * np.sin(2 * angles)])
    for family in told.families:
        own = slice(first, first + family.columns)
        first += family.columns
        if not family.plane:
            continue
        seen = np.einsum("ai,ij,aj->a", turned, told.seen[own, own], turned)
        for step in (5000, -5000):
            x = turned[(int(seen[:-1].argmin()) + step) % 20000]
            size = min(np.sqrt(half / (x @ told.seen[own, own] @ x)), family.largest)
            if family.largest > UNSEEN * size:
                worst = max(worst, float(np.linalg.norm(told.left[:, own] @ x)) * size)
    return worst


def test_sums_are_of_any_number_of_plans() -> None:
    study = kr270_study()
    cases, repeats = drawn(study, 9, 0)
    sums = blind_sums(study, cases)
    each = sums.informations(cases, repeats)
    chosen = [[0, 1, 2, 3, 4], [2, 3, 5, 6, 8], [0, 4, 5, 7, 8]]
    together = sums.worst(np.array([each[c].sum(axis=0) for c in chosen]), 5)
    alone = [float(sums.worst(each[c].sum(axis=0)[None], 5)[0]) for c in chosen]
    np.testing.assert_allclose(together, alone, rtol=1e-12)


def test_a_high_power_is_the_largest_from_above() -> None:
    study = kr270_study()
    cases, repeats = drawn(study, 8, 4)
    sums = blind_sums(study, cases)
    total = sums.informations(cases, repeats).sum(axis=0)[None]
    largest, soft = (float(sums.worst(total, 8, power)[0]) for power in (np.inf, 12.0))
    assert largest <= soft < 1.4 * largest
    assert float(sums.worst(total, 8, 2000.0)[0]) == pytest.approx(largest, rel=2e-3)


def test_what_no_load_case_shows_does_not_count() -> None:
    """Joint A1 under a hung weight, which is the largest by far; pulled aslant it counts."""
    study = kr270_study()
    cases, repeats = drawn(study, 8, 5)
    found = blind_errors(study, cases, repeats)
    assert found is not None
    sums = blind_sums(study, cases)
    worst = float(sums.worst(sums.informations(cases, repeats).sum(axis=0)[None], 8)[0])
    assert worst < 0.2 * found.effects[0].error
    assert found.effects[0].carriers == ("A1",)


def test_repeats_that_share_errors_tell_less() -> None:
    study = read_study(FOLDER / "study_aslant.yaml")
    cases, _ = drawn(study, 6, 6)
    sums = blind_sums(study, cases)
    once, four = (np.full(6, n) for n in (1, 4))
    part = slice(0, len(sums.base) ** 2)
    told = [
        np.trace(sums.informations(cases, n)[:, part].sum(axis=0).reshape(sums.base.shape))
        for n in (once, four)
    ]
    assert told[0] < told[1] < 4.0 * told[0]
