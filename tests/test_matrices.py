"""When information is singular: one question, one answer, on the right scale."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.springs import VirtualJoints
from elastocal.errors import IdentifiabilityError
from elastocal.fitting.influence import influence
from elastocal.fitting.least_squares import fit
from elastocal.identification.identify import identify
from elastocal.identification.validation import leave_one_out
from elastocal.matrices import Confounded, confounded, rank_of
from elastocal.study.identifiability import unidentifiable
from tests.campaigns import NAMES, TRUTH, arm, hung, measured


def of_rows(rows: np.ndarray) -> np.ndarray:
    return np.asarray(rows.T @ rows)


def test_the_rank_does_not_depend_on_units() -> None:
    rng = np.random.default_rng(9)
    full = of_rows(rng.normal(size=(12, 3)))
    low = of_rows(rng.normal(size=(2, 3)))
    units = np.diag([1e-4, 1.0, 1e4])
    every = np.array([full, low, units @ full @ units, units @ low @ units])
    assert rank_of(every).tolist() == [3, 2, 3, 2]
    assert rank_of(np.diag([2.0, 0.0, 3.0])) == 2
    assert rank_of(np.zeros((3, 3))) == 0


@pytest.mark.parametrize(("error", "rank"), [(3e-5, 2), (3e-6, 1)])
def test_a_share_of_1e_minus_5_of_its_own_makes_an_unknown_known(error: float, rank: int) -> None:
    """Two columns at right angles but for a common part: eigenvalues 2 and about error²/2."""
    rows = np.array([[1.0, 1.0], [0.0, error * np.sqrt(2.0)]])
    assert rank_of(of_rows(rows)) == rank


def test_a_rest_is_judged_on_the_scale_of_the_whole() -> None:
    """1e-16 of rounding is nothing next to 1, and would be everything next to itself."""
    whole = np.diag([1.0, 4.0])
    rest = np.diag([1e-16, 3.0])
    assert rank_of(rest) == 2
    assert rank_of(rest, scale=whole) == 1


def test_groups_have_nothing_in_common() -> None:
    rng = np.random.default_rng(2)
    free = rng.normal(size=(40, 4))
    rows = np.column_stack(
        [
            free[:, 0],
            np.zeros(40),  # never seen
            free[:, 1],
            -3.0 * free[:, 1],  # the same as the one before
            free[:, 2],
            free[:, 3],
            free[:, 2] + 0.1 * free[:, 3],  # three through two combinations
        ]
    )
    scale = np.array([1.0, 1.0, 1e-4, 1e3, 1.0, 50.0, 1e-3])
    assert confounded(of_rows(rows * scale)) == (
        Confounded((1,), 0),
        Confounded((2, 3), 1),
        Confounded((4, 5, 6), 2),
    )
    assert confounded(of_rows(free)) == ()


@pytest.mark.parametrize("error", [0.0, 1e-9, 1e-7, 1e-6, 2e-6, 1e-5, 2e-5, 1e-4, 1e-3])
def test_planning_and_identification_agree_on_what_is_confounded(error: float) -> None:
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(30, 3))
    rows[:, 2] = 2.0 * rows[:, 1] + error * rng.normal(size=30)
    before = bool(unidentifiable(("A1", "A2", "A3"), of_rows(rows)))
    after = bool(confounded(fit(rows, rng.normal(size=30)).information))
    assert before == after
    assert before == (error < 5e-6) or 5e-6 <= error <= 5e-5


def test_what_one_group_alone_carries_is_seen_whatever_rounding_leaves() -> None:
    for seed in range(400):
        rng = np.random.default_rng(seed)
        rows = np.zeros((6, 3, 2))
        rows[0, :, 0] = rng.normal(size=3)
        rows[1:, :, 1] = rng.normal(size=(5, 3))
        if seed >= 200:
            rows[0, :, 1] = rng.normal(size=3)
        information = np.einsum("rip,riq->pq", rows, rows)
        found = influence(rows, rng.normal(size=(6, 3)), np.arange(6), 6, information)
        assert np.isinf(found.error_ratio[0, 0]), seed
        assert np.isfinite(found.error_ratio[1:]).all(), seed


def test_a_joint_that_one_experiment_carries_is_not_predicted_without_it() -> None:
    """Hung weights and one sideways force: A1 rests on that one, as in the paper."""
    every, truth = ("A1", *NAMES), np.append(0.6e-6, TRUTH)
    for seed in range(60):
        cases = hung(12, seed)
        wrench = np.array(cases.wrench)
        wrench[3] = [0.0, 1500.0, -1000.0, 0.0, 0.0, 0.0]
        readings = measured(
            arm(every), LoadCases(cases.q, wrench), truth, rng=np.random.default_rng(seed)
        )
        found = identify(arm(every), readings)
        assert np.isinf(found.influence.error_ratio[3, 0]), seed
        if seed < 20:
            checked = leave_one_out(found)
            assert checked.coordinates == 33
            assert checked.inside <= 33


def test_a_combination_that_is_hardly_seen_is_refused_after_measuring_too() -> None:
    """Two links' springs about the same axis but for 1e-6 rad: no reading tells them apart."""
    tilt = 1e-6
    springs = VirtualJoints(
        names=("link", "twin"),
        body=np.array([2, 2]),
        axis=np.array([[0.0, 0.0, 1.0], [0.0, np.sin(tilt), np.cos(tilt)]]),
        origin=np.zeros((2, 3)),
        prismatic=np.array([False, False]),
    )
    bent = replace(arm(), springs=springs)
    readings = measured(bent, hung(12), np.array([1e-6, 1e-6]), rng=np.random.default_rng(0))
    with pytest.raises(IdentifiabilityError, match="link and twin"):
        identify(bent, readings)


def test_each_matrix_of_a_batch_is_judged_on_its_own_scale() -> None:
    """Tiny information beside large: its rank is its own."""
    whole = np.diag([1.0, 2.0, 3.0])
    batch = np.array([whole, 1e-30 * whole, np.diag([1.0, 0.0, 1.0])])
    assert rank_of(batch).tolist() == [3, 3, 2]
    assert [int(rank_of(one)) for one in batch] == [3, 3, 2]


def test_what_is_not_seen_at_all_comes_first() -> None:
    """The first two only by their sum, the last one not at all."""
    row = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]])
    assert confounded(row.T @ row) == (Confounded((3,), 0), Confounded((0, 1), 1))
