"""What is left out in turn goes with all its repeats, whatever is fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.case_errors import CaseErrors
from elastocal.identification.identify import identify
from elastocal.identification.leave_one_out import left_out_covariance
from elastocal.identification.left_out_error import left_out_error, repeats_left
from elastocal.measuring.measurements import chosen
from tests.identification.test_nuisance import LINEAR, WHOLE, campaign, dense, nuisance, rows_of

KINDS = {
    "joints alone": None,
    "springs": CaseErrors(),
    "each load": CaseErrors(gain=0.02),
    "each load case": CaseErrors(discrepancy=0.05),
}


def by_hand(kind: str, shared: bool) -> tuple[float, float]:
    """Errors of load cases by fits without them, and what these fits expect."""
    what = replace(nuisance(), errors=KINDS[kind] or CaseErrors())
    arm, data = campaign(WHOLE, shared=shared)
    near = np.append(identify(arm, data, LINEAR).compliance, np.zeros(4))
    if KINDS[kind] is None:
        what = replace(what, errors=CaseErrors(), deviation=np.full(4, 1e-15))  # none at all
    rows, values = rows_of(arm, data.cases, what), data.deflection.ravel()
    prior = np.diag(np.append(np.zeros(3), what.deviation**-2.0))
    for _ in range(2):
        covariance = dense(arm, data, what, near)
        inverse = np.linalg.inv(covariance)
        near = np.linalg.solve(rows.T @ inverse @ rows + prior, rows.T @ inverse @ values)
    seen = promised = 0.0
    for g in np.unique(data.cases.distinct):
        out = np.repeat((data.cases.distinct == g)[data.case], 3)
        inverse = np.linalg.inv(covariance[np.ix_(~out, ~out)])
        spread = np.linalg.inv(rows[~out].T @ inverse @ rows[~out] + prior)
        left = values[out] - rows[out] @ spread @ rows[~out].T @ inverse @ values[~out]
        seen += left @ left
        whole = rows[out] @ spread @ rows[out].T + covariance[np.ix_(out, out)]
        promised += np.trace(whole)
    return float(np.sqrt(seen / len(data))), float(np.sqrt(promised / len(data)))


@pytest.mark.parametrize("shared", [False, True], ids=["own unloaded", "shared unloaded"])
@pytest.mark.parametrize("kind", KINDS)
def test_load_cases_are_left_out_with_all_their_repeats(kind: str, shared: bool) -> None:
    arm, data = campaign(WHOLE, shared=shared)
    errors = KINDS[kind]
    besides = None if errors is None else replace(nuisance(), errors=errors)
    found = identify(arm, data, LINEAR, nuisance=besides)
    error = left_out_error(found)
    seen, promised = by_hand(kind, shared)
    assert error.load_cases
    assert error.seen == pytest.approx(seen, rel=1e-4)
    assert error.promised == pytest.approx(promised, rel=1e-4)
    assert repeats_left(found, error) == " with their repeats"
    if kind == "joints alone" and not shared:  # then repeats that stay say what is read
        one = np.sqrt(np.mean(np.sum(found.left_out**2, axis=1)))
        assert one < seen
        some = np.array([1, 0, 0, 0, 0, 1, 0, 0, 1], dtype=bool)
        np.testing.assert_allclose(
            left_out_covariance(found, some, load_cases=True),
            left_out_covariance(found, load_cases=True)[some[data.case]],
        )


def test_experiments_are_left_out_where_load_cases_cannot_be() -> None:
    arm, data = campaign(WHOLE, markers=1)
    found = identify(arm, chosen(data, data.cases.distinct == 3), LINEAR)
    error = left_out_error(found)
    assert np.isfinite(error.seen)
    assert not error.load_cases
    assert repeats_left(found, error) == " (repeats stay)"


def test_without_repeats_nothing_is_said_of_them() -> None:
    arm, data = campaign(WHOLE)
    once = chosen(data, np.array([1, 1, 0, 1, 1, 0, 0, 1, 1], dtype=bool))
    found = identify(arm, once, LINEAR)
    assert repeats_left(found, left_out_error(found)) == ""
    np.testing.assert_array_equal(found.left_out, found.without_load_case.residual)
