"""A second campaign that knows what the first one found, and how far to trust it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import subset
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.identification.validation import leave_one_out, validate
from elastocal.measuring.measurements import Measurements, chosen
from tests.campaigns import NAMES, SIGMA, TRUTH, arm, hung, measured, sideways

LINEAR = Fit(model="linear")
EVERY = ("A1", *NAMES)
WHOLE = np.append(0.6e-6, TRUTH)


def steps(seed: int = 5, count: int = 4) -> tuple[Identification, Measurements]:
    """A2 to A6 found under a hung weight, and readings of a second campaign for A1."""
    rng = np.random.default_rng(seed)
    first = identify(arm(), measured(arm(), hung(12), rng=rng))
    return first, measured(arm(EVERY), sideways(count), WHOLE, rng=rng)


def test_two_steps_as_in_the_paper() -> None:
    """A2 to A6 under a hung weight, then A1 by a sideways force with the others known."""
    first, data = steps()
    found = identify(arm(("A1",)), data, known=first.model)
    assert found.identified == ("A1",)
    assert found.model.names == found.fitted == EVERY
    assert abs(found.compliance[0] - WHOLE[0]) < 4.0 * found.standard_error[0]
    assert found.dof == 3 * 4 - 1
    # What the second step tells of A2 to A6 counts as well: none is known worse after it.
    gain = first.standard_error / found.model.standard_error[1:]
    assert (gain > 1.0).all()
    assert gain.max() < 1.5
    exact = replace(first.model, covariance=np.zeros((5, 5)))
    careless = identify(arm(("A1",)), data, known=exact)
    assert careless.fitted == ("A1",)
    assert careless.standard_error[0] < found.standard_error[0]
    np.testing.assert_array_equal(careless.model.of(NAMES), first.compliance)


def test_a_change_of_what_is_known_moves_the_rest_by_the_covariance() -> None:
    first, data = steps()
    found = identify(arm(("A1",)), data, known=first.model)
    step = first.standard_error[1]
    moved = replace(first.model, compliance=first.compliance + step * np.eye(5)[1])
    slope = (identify(arm(("A1",)), data, known=moved).compliance - found.compliance) / step
    follows = found.model.covariance[0, 1:] @ np.linalg.inv(1e18 * first.model.covariance) * 1e18
    assert follows[1] == pytest.approx(float(slope[0]), rel=1e-3)


@pytest.mark.parametrize("count", [1, 3])
def test_the_fit_is_least_squares_of_readings_and_what_is_known(count: int) -> None:
    """By numpy, from rows over the noise and rows of the inverse covariance; in 1e-6 rad/(N·m)."""
    rng = np.random.default_rng(8)
    data = measured(arm(), hung(16), rng=rng, linear=True)
    early = np.arange(16) < 8
    whole = identify(arm(), chosen(data, early), LINEAR)
    passed = ComplianceModel(
        subset(whole.model.springs, NAMES[:count]),
        whole.compliance[:count],
        whole.model.covariance[:count, :count],
    )
    found = identify(arm(NAMES[count:]), chosen(data, ~early), LINEAR, known=passed)
    late = chosen(data, ~early)
    root = np.linalg.cholesky(np.linalg.inv(1e12 * passed.covariance)).T
    before = np.hstack([root, np.zeros((count, 5 - count))])
    rows = np.vstack([1e-6 * regressor(arm(), late.cases).reshape(-1, 5) / SIGMA, before])
    values = np.append(late.deflection.reshape(-1) / SIGMA, root @ (1e6 * passed.compliance))
    expected = np.linalg.lstsq(rows, values, rcond=None)[0]
    np.testing.assert_allclose(1e6 * found.model.compliance, expected, rtol=1e-8)
    covariance = np.linalg.inv(rows.T @ rows)
    np.testing.assert_allclose(1e12 * found.model.covariance, covariance, rtol=1e-6)
    residual = values - rows @ expected
    assert found.chi_square == pytest.approx(float(residual @ residual))
    assert found.dof == 24 + count - 5
    # Singular values are those of the identified ones alone, whatever the known ones are.
    own = np.linalg.inv(covariance[count:, count:])
    scale = 1.0 / np.sqrt(np.diagonal(own))
    eigenvalues = np.linalg.eigvalsh(own * np.outer(scale, scale))[::-1]
    np.testing.assert_allclose(found.singular_values**2, eigenvalues, rtol=1e-6)


def test_an_experiment_left_out_is_a_refit() -> None:
    """Closed forms of shift, Cook's distance, residual and its deviation, for both steps."""
    first, data = steps(9, 6)
    found = identify(arm(("A1",)), data, LINEAR, known=first.model)
    left = leave_one_out(found)
    for i in range(6):
        out = chosen(data, np.arange(6) == i)
        rest = identify(arm(("A1",)), chosen(data, np.arange(6) != i), LINEAR, known=first.model)
        rows = regressor(arm(EVERY), out.cases)[0]
        after = data.deflection[i] - rows @ rest.model.compliance
        np.testing.assert_allclose(left.after[i], after, atol=1e-8 * SIGMA)
        spread = SIGMA**2 + np.einsum("ip,pq,iq->i", rows, rest.model.covariance, rows)
        np.testing.assert_allclose(left.deviation[i] ** 2, spread, rtol=1e-6)
        shift = rest.compliance - found.compliance
        np.testing.assert_allclose(found.influence.shift[i], shift, rtol=1e-6)
        cook = float((shift / found.standard_error)[0] ** 2)
        assert found.influence.cook[i] == pytest.approx(cook, rel=1e-6)
        ratio = rest.standard_error / found.standard_error
        np.testing.assert_allclose(found.influence.error_ratio[i], ratio, rtol=1e-6)


def test_the_noise_of_the_second_step_is_not_that_of_the_first() -> None:
    """σ of the second step estimated: what was known stays as well known as it says.

    By the mixed estimator's own formulas, all matrices formed: C, and what Kenward and Roger add.
    """
    first, data = steps(10, 6)
    found = identify(arm(("A1",)), data, Fit("linear", "estimated"), known=first.model)
    rows = 1e-6 * regressor(arm(EVERY), data.cases).reshape(-1, 6) / SIGMA
    given = np.zeros((6, 6))
    given[1:, 1:] = np.linalg.inv(1e12 * first.model.covariance)
    covariance = np.linalg.inv(rows.T @ rows / found.scale**2 + given)
    share = covariance @ rows.T @ rows / found.scale**2
    freedom = len(rows) - 2.0 * np.trace(share) + np.trace(share @ share)
    assert found.model.dof == pytest.approx(freedom, rel=1e-6)
    more = covariance @ (given - given @ covariance @ given) @ covariance
    covariance = covariance + 4.0 / freedom * more
    np.testing.assert_allclose(1e12 * found.model.covariance, covariance, rtol=1e-5, atol=1e-12)
    left = leave_one_out(found)
    out = np.arange(18) // 3 == 0
    covariance = np.linalg.inv(rows[~out].T @ rows[~out] / found.scale**2 + given)
    spread = found.scale**2 + np.einsum("ip,pq,iq->i", rows[out], covariance, rows[out])
    np.testing.assert_allclose((left.deviation[0] / SIGMA) ** 2, spread, rtol=1e-6)


def test_validation_of_the_second_step_knows_the_first() -> None:
    """Readings kept aside are expected with the uncertainty of all compliances."""
    first, data = steps(11)
    found = identify(arm(("A1",)), data, known=first.model)
    kept = measured(arm(EVERY), sideways(40, 3), WHOLE, rng=np.random.default_rng(12))
    assert 0.01 < validate(arm(("A1",)), found.model, kept).p_value < 0.99


def test_a_known_combination_without_error_is_held() -> None:
    """All known compliances by one unknown: the dense fit has two unknowns, A1 and that one."""
    first, data = steps(14)
    error = first.standard_error
    tied = replace(first.model, covariance=np.outer(error, error))
    found = identify(arm(("A1",)), data, LINEAR, known=tied)
    rows = regressor(arm(EVERY), data.cases).reshape(-1, 6) / SIGMA
    scale = 1e-6
    both = np.column_stack([scale * rows[:, 0], rows[:, 1:] @ error])
    values = data.deflection.ravel() / SIGMA - rows[:, 1:] @ first.compliance
    information = both.T @ both + np.diag([0.0, 1.0])
    expected = scale * np.linalg.solve(information, both.T @ values)[0]
    deviation = scale * np.sqrt(np.linalg.inv(information)[0, 0])
    assert abs(found.compliance[0] - expected) < 0.01 * deviation
    assert found.standard_error[0] == pytest.approx(deviation, rel=2e-3)
