"""Fits with nuisance parameters and shared errors, against dense matrices written out here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.case_errors import CaseErrors
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.nuisance import Nuisance
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.elastic.tensors import against_the_load
from elastocal.elastic.unknowns import Unknowns
from elastocal.errors import IdentifiabilityError, InputError
from elastocal.identification.doubts import doubts, is_weak
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.validation import leave_one_out, validate
from elastocal.measuring.measurements import Measurements, chosen
from tests.arms import random_chain, random_tool

SIGMA = 1e-4
TRUTH = np.array([3.0, 2.0, 4.0]) * 1e-4
LINEAR = Fit("linear")
ERRORS = CaseErrors(friction=0.05, discrepancy=0.1, gain=0.02, tilt=0.01, repeatability=2e-5)


def springs_across(body: int, axes: np.ndarray, name: str) -> VirtualJoints:
    count = len(axes)
    return VirtualJoints(
        tuple(f"{name} {i}" for i in range(count)),
        np.full(count, body), axes, np.zeros((count, 3)), np.zeros(count, dtype=bool),
    )  # fmt: skip


def nuisance(errors: CaseErrors | None = None) -> Nuisance:
    """A foot that tilts alike about x and y, and a tensor across the axis of a joint."""
    root = np.sqrt(0.5)
    foot = springs_across(0, np.eye(3)[:2], "foot")
    link = springs_across(2, np.array([[1, 0, 0], [0, 1, 0], [root, root, 0.0]]), "link")
    make = np.zeros((5, 4))
    make[:2, 0] = 1.0
    make[2:, 1:] = [[1, 0, -1], [0, 1, -1], [0, 0, 2]]
    names = ("foot", "link xx", "link yy", "link xy")
    return Nuisance(
        Unknowns(names, merged(foot, link), make), np.zeros(4), np.array([1, 1, 1, 0.7]) * 1e-4,
        np.array([False, False, False, True]), ("test",) * 4, TRUTH, errors or CaseErrors(),
    )  # fmt: skip


def campaign(
    truth: np.ndarray, *, markers: int = 2, seed: int = 3, shared: bool = False
) -> tuple[ElasticArm, Measurements]:
    """Nine experiments in six load cases; linear readings with noise."""
    rng = np.random.default_rng(seed)
    robot, tool = random_chain(rng, [False] * 3), random_tool(rng, markers)
    arm = ElasticArm(robot, joint_springs(robot), tool)
    q, wrench = rng.uniform(-2, 2, (6, 3)), rng.normal(size=(6, 6))
    which = np.array([0, 1, 1, 2, 3, 3, 3, 4, 5])
    cases = LoadCases(q[which], wrench[which])
    everything = rows_of(arm, cases, nuisance())
    read = (everything @ truth).reshape(-1, 3)
    case, marker = np.repeat(np.arange(9), markers), np.tile(np.arange(markers), 9)
    read = read + SIGMA * rng.normal(size=read.shape)
    data = Measurements(
        tool, cases, tuple(f"E{i}" for i in range(9)), case, marker, read,
        np.tile(SIGMA**2 * np.eye(3), (len(case), 1, 1)),
        unloaded_of=which[case] * markers + marker if shared else np.arange(len(case)),
    )  # fmt: skip
    return arm, data


def lighter(data: Measurements) -> Measurements:
    """Loads, deflections and noise a thousandth: the equilibrium is as good as linear."""
    return replace(
        data,
        cases=LoadCases(data.cases.q, 1e-3 * data.cases.wrench),
        deflection=1e-3 * data.deflection,
        covariance=1e-6 * data.covariance,
    )


def rows_of(arm: ElasticArm, cases: LoadCases, what: Nuisance) -> np.ndarray:
    """(3R, 7) columns of the joints, then of the nuisance parameters."""
    joints = regressor(arm, cases)
    besides = regressor(replace(arm, springs=what.unknowns.springs), cases) @ what.unknowns.make
    return np.concatenate([joints, besides], axis=2).reshape(-1, joints.shape[2] + len(what.names))


def dense(arm: ElasticArm, data: Measurements, what: Nuisance, near: np.ndarray) -> np.ndarray:
    """(3R, 3R) covariance of the readings, entry by entry, errors as shares of what `near` says."""
    markers = len(data.tool.markers)
    total = np.zeros((3 * len(data), 3 * len(data)))
    rows = rows_of(arm, data.cases, what).reshape(len(data.cases), 3 * markers, -1)
    errors = what.errors
    for i, a in enumerate(data.case):
        for j, b in enumerate(data.case):
            at, to = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
            mine, other = (slice(3 * data.marker[k], 3 * data.marker[k] + 3) for k in (i, j))
            block = np.zeros((3, 3))
            if i == j:
                block += data.covariance[i]
            elif data.unloaded[i] == data.unloaded[j]:
                block += 0.5 * data.covariance[i]
            moved = rows[a] @ near
            if data.cases.distinct[a] == data.cases.distinct[b]:
                for k in range(3):
                    one = rows[a][:, k] * near[k]
                    block += errors.friction**2 * np.outer(one[mine], one[other])
                if mine == other:
                    mean = np.sum(moved**2) / markers
                    block += errors.discrepancy**2 * mean * np.eye(3)
            if a == b:
                block += errors.gain**2 * np.outer(moved[mine], moved[other])
                block += errors.repeatability**2 * np.eye(3)
                for axis in np.eye(3):
                    force, moment = np.split(data.cases.wrench[a], 2)
                    turned = np.append(np.cross(axis, force), np.cross(axis, moment))
                    case = LoadCases(data.cases.q[a : a + 1], turned[None])
                    d = rows_of(arm, case, what) @ near
                    block += errors.tilt**2 * np.outer(d[mine], d[other])
            total[at, to] = block
    return total


def ellipsoid(
    rows: np.ndarray, values: np.ndarray, covariance: np.ndarray, what: Nuisance
) -> tuple[np.ndarray, np.ndarray]:
    """Mixed estimate and its covariance, by normal equations."""
    inverse = np.linalg.inv(covariance)
    prior = np.diag(np.append(np.zeros(3), what.deviation**-2.0))
    spread = np.linalg.inv(rows.T @ inverse @ rows + prior)
    return spread @ rows.T @ inverse @ values, spread


WHOLE = np.append(TRUTH, [2e-4, 1.5e-4, 1e-4, -0.3e-4])


@pytest.mark.parametrize("shared", [False, True], ids=["own unloaded", "shared unloaded"])
@pytest.mark.parametrize("errors", [CaseErrors(), replace(ERRORS, gain=0, tilt=0), ERRORS])
def test_the_mixed_fit_is_that_of_dense_matrices(errors: CaseErrors, shared: bool) -> None:
    what = nuisance(errors)
    arm, data = campaign(WHOLE, shared=shared)
    found = identify(arm, data, LINEAR, nuisance=what)
    assert not found.held
    rows, values = rows_of(arm, data.cases, what), data.deflection.ravel()
    near = np.append(identify(arm, data, LINEAR).compliance, np.zeros(4))
    for _ in range(2):  # the errors are shares of the deflections of the fit before
        covariance = dense(arm, data, what, near)
        near, spread = ellipsoid(rows, values, covariance, what)
    np.testing.assert_allclose(found.unknown, near, rtol=1e-7)
    np.testing.assert_allclose(found.unknown_covariance, spread, rtol=1e-6, atol=1e-16)
    left = values - rows @ near
    square = left @ np.linalg.solve(covariance, left) + np.sum((near[3:] / what.deviation) ** 2)
    assert found.chi_square == pytest.approx(square, rel=1e-6)
    assert found.dof == len(values) - 3
    kept, expected = leave_one_out(found), found.without_experiment.covariance
    together = data.cases.distinct[data.case]
    if not (shared or errors.any_shared):
        together = data.case
    for g in range(int(together.max()) + 1):
        out = np.repeat(together == g, 3)
        rest = covariance[np.ix_(~out, ~out)]
        others, unsure = ellipsoid(rows[~out], values[~out], rest, what)
        error = values[out] - rows[out] @ others
        np.testing.assert_allclose(kept.after[together == g].ravel(), error, rtol=1e-5, atol=1e-12)
        whole = rows[out] @ unsure @ rows[out].T + covariance[np.ix_(out, out)]
        blocks = [whole[i : i + 3, i : i + 3] for i in range(0, len(whole), 3)]
        np.testing.assert_allclose(expected[together == g], blocks, rtol=1e-5)


def test_springs_of_the_model_bend_as_the_unknowns_say() -> None:
    what = nuisance()
    arm, data = campaign(WHOLE)
    found = identify(arm, data, LINEAR, nuisance=what)
    model = found.model
    index = [model.names.index(name) for name in what.unknowns.springs.names]
    np.testing.assert_allclose(model.compliance[index], what.unknowns.make @ found.unknown[3:])
    spread = what.unknowns.make @ found.unknown_covariance[3:, 3:] @ what.unknowns.make.T
    np.testing.assert_allclose(model.covariance[np.ix_(index, index)], spread)
    assert found.alone is not None
    assert found.alone.fitted == arm.springs.names


@pytest.mark.parametrize("how", [LINEAR, Fit()], ids=["linear", "equilibrium"])
@pytest.mark.parametrize("some", [True, False], ids=["on the edge", "nothing left"])
def test_nothing_moves_against_the_load(how: Fit, some: bool) -> None:
    """No foot is below zero, and no tensor: the truth here is what no arm can be."""
    link = [1.5e-4, -3e-4, -1e-4] if some else [-3e-3, -3e-3, 0.0]
    arm, data = campaign(np.append(TRUTH, [-3e-4, *link]))
    found = identify(arm, lighter(data), how, nuisance=nuisance())
    assert "foot" in found.held
    assert (found.unknown[:6] >= 0.0).all()
    xx, yy, xy = found.unknown[4:]
    assert xx * yy == pytest.approx(xy**2, abs=1e-18)  # no better inside
    assert found.unknown[6] < 0.0 if some else xx + yy == 0.0
    assert not against_the_load(found.model.springs, found.model.compliance)


def test_what_is_left_out_moves_a_tensor_along_its_edge() -> None:
    """As the fit without the experiment does, to first order."""
    what = replace(nuisance(), deviation=np.full(4, 1e-3))
    arm, data = campaign(np.append(TRUTH, [2e-4, 2e-4, 2e-4, -2.3e-4]), markers=6)
    found = identify(arm, data, LINEAR, nuisance=what)
    xx, yy, xy = found.unknown[4:]
    assert xx * yy == pytest.approx(xy**2, rel=1e-9)
    near = far = 0.0
    for i in range(9):
        others = chosen(data, np.arange(9) != i)
        again = identify(arm, others, LINEAR, nuisance=what)
        out = data.case == i
        rows = rows_of(arm, data.cases, what).reshape(len(data), 3, -1)[out]
        left = data.deflection[out] - rows @ again.unknown
        near += np.sum((found.left_out[out] - left) ** 2)
        far += np.sum((found.residual[out] - left) ** 2)
    assert near < 0.05 * far


def test_the_equilibrium_bends_through_the_nuisance_too() -> None:
    """Small loads: the same as the linear fit, with nuisance springs in the chain."""
    arm, data = campaign(WHOLE)
    data = lighter(data)
    linear = identify(arm, data, LINEAR, nuisance=nuisance(ERRORS))
    bent = identify(arm, data, Fit(), nuisance=nuisance(ERRORS))
    np.testing.assert_allclose(bent.unknown, linear.unknown, rtol=1e-4)


def test_a_common_gain_makes_compliances_as_uncertain_as_it_is() -> None:
    """Nothing of it shows in readings: cov k̂ gains u² k̂ k̂ᵀ, and no estimate moves."""
    arm, data = campaign(np.append(TRUTH, np.zeros(4)))
    bare = nuisance()
    without = identify(arm, data, LINEAR, nuisance=bare)
    gain = replace(bare, errors=CaseErrors(common_gain=0.05))
    found = identify(arm, data, LINEAR, nuisance=gain)
    assert found.fitted[-1] == "load gain"
    more = found.unknown_covariance[:3, :3] - without.unknown_covariance[:3, :3]
    k = found.unknown[:3]
    np.testing.assert_allclose(more, 0.05**2 * np.outer(k, k), rtol=0.1, atol=1e-3 * more.max())


def test_noise_is_found_where_repeats_show_it() -> None:
    """Four times the promised noise, and errors of load cases besides: about four is found."""
    what = nuisance(CaseErrors(discrepancy=0.05))
    arm, data = campaign(WHOLE, markers=3)
    spoilt = replace(data, covariance=data.covariance / 16.0)
    found = identify(arm, spoilt, Fit("linear", "estimated"), nuisance=what)
    assert found.scale == pytest.approx(4.0, rel=0.3)
    assert found.model.noise == found.scale
    assert found.lack_of_fit is not None


def once(data: Measurements) -> Measurements:
    """Each load case once."""
    return chosen(data, np.array([1, 1, 0, 1, 1, 0, 0, 1, 1], dtype=bool))


def test_noise_that_nothing_shows_is_not_estimated() -> None:
    """One reading a load case, each with a discrepancy that is as much as all that is read."""
    what = nuisance(CaseErrors(discrepancy=1.0))
    arm, data = campaign(WHOLE, markers=1)
    with pytest.raises(IdentifiabilityError, match="it is too small to be told"):
        identify(arm, once(data), Fit("linear", "estimated"), nuisance=what)
    assert np.isnan(identify(arm, once(data), LINEAR, nuisance=what).scale)


def test_noise_is_found_beside_errors_that_are_smaller() -> None:
    """Every coordinate has a discrepancy of its own, a tenth of the noise: enough is left."""
    how = Fit("linear", "estimated")
    arm, data = campaign(WHOLE, markers=2)
    near = float(np.mean(data.length))
    what = nuisance(CaseErrors(discrepancy=0.1 * SIGMA / near))
    spoilt = replace(once(data), covariance=once(data).covariance / 16.0)
    found = identify(arm, spoilt, how, nuisance=what)
    alone = identify(arm, spoilt, how, nuisance=nuisance())
    assert found.pure_dof == 0
    assert alone.pure_dof > 3
    assert found.scale == pytest.approx(alone.scale, rel=0.01)
    assert found.model.dof == pytest.approx(alone.model.dof, rel=0.05)
    told = [doubt for doubt in doubts(found) if doubt.code == "noise-beside-errors"]
    assert [doubt.numbers for doubt in told] == [{"dof": found.model.dof}]
    assert not is_weak(told[0])
    assert "noise-beside-errors" not in [doubt.code for doubt in doubts(alone)]


def test_robust_losses_do_not_know_nuisance() -> None:
    arm, data = campaign(WHOLE)
    with pytest.raises(InputError, match="huber does not go with nuisance"):
        identify(arm, data, Fit(loss="huber"), nuisance=nuisance())


def test_a_gain_cancels_where_one_cell_reads_all_forces() -> None:
    """Of (1 + g) k̂ for the same cell, k̂ for an exact force, one more gain for another cell."""
    arm, data = campaign(np.append(TRUTH, np.zeros(4)))
    bare = nuisance()
    without = identify(arm, data, LINEAR, nuisance=bare).model.covariance
    found = {}
    for cell in ("same", "exact", "other"):
        errors = CaseErrors(common_gain=0.05, process_force=cell)
        found[cell] = identify(arm, data, LINEAR, nuisance=replace(bare, errors=errors)).model
    own = [found["same"].names.index(name) for name in arm.springs.names]
    at_task = {cell: np.diagonal(model.at_task)[own] for cell, model in found.items()}
    k = found["same"].compliance[own]
    np.testing.assert_allclose(at_task["same"], np.diagonal(without)[own], rtol=0.2)
    np.testing.assert_array_equal(found["exact"].at_task, found["exact"].covariance)
    np.testing.assert_allclose(at_task["other"] - at_task["exact"], (0.05 * k) ** 2, rtol=1e-6)
    assert (at_task["exact"] - at_task["same"] > 0.5 * (0.05 * k) ** 2).all()


def test_a_model_that_left_out_readings_refute_carries_its_error() -> None:
    """Springs besides that nobody fits: seen where experiments are left out, and promised since."""
    arm, data = campaign(np.append(TRUTH, [9e-4, 9e-4, 3e-4, 0.0]))
    wrong, right = identify(arm, data, LINEAR), identify(arm, data, LINEAR, nuisance=nuisance())
    seen = np.sqrt(np.mean(np.sum(wrong.without_load_case.residual**2, axis=1)))
    assert wrong.model.model_error == pytest.approx(seen)
    assert identify(*campaign(np.append(TRUTH, np.zeros(4))), LINEAR).model.model_error == 0.0
    assert right.model.model_error < 0.3 * seen


def test_validation_counts_what_readings_share() -> None:
    """The squares and the intervals are those of the dense covariance."""
    arm, data = campaign(WHOLE)
    _, other = campaign(WHOLE, seed=3)
    what = nuisance(ERRORS)
    model = identify(arm, data, LINEAR, nuisance=what).model
    small = 1e-3  # deflections so small that the equilibrium is linear
    cases = LoadCases(other.cases.q, small * other.cases.wrench)
    other = replace(other, cases=cases, deflection=small * other.deflection + 2e-8,
                    covariance=small**2 * other.covariance)  # fmt: skip
    found = validate(arm, model, other, errors=ERRORS)
    index = [model.names.index(n) for n in (*arm.springs.names, *what.unknowns.springs.names)]
    bent = replace(arm, springs=merged(arm.springs, what.unknowns.springs))
    rows = regressor(bent, cases)
    place = [bent.springs.names.index(model.names[i]) for i in index]
    rows = rows[:, :, place].reshape(-1, len(index))
    spread = rows @ model.covariance[np.ix_(index, index)] @ rows.T
    own = np.linalg.lstsq(what.unknowns.make, model.compliance[index[3:]], rcond=None)[0]
    whole = spread + dense(arm, other, what, np.append(model.compliance[index[:3]], own))
    after = found.after.ravel()
    assert found.chi_square == pytest.approx(after @ np.linalg.solve(whole, after), rel=1e-3)
    np.testing.assert_allclose(found.deviation.ravel() ** 2, np.diagonal(whole), rtol=1e-3)
    assert validate(arm, model, other).chi_square > 1.5 * found.chi_square


def test_a_prior_that_fitted_the_same_nuisance_is_the_prior_of_both() -> None:
    """Two campaigns one after the other know as much as both at once, not more."""
    arm, data = campaign(np.append(TRUTH, [1e-4, 2e-4, 2e-4, 1e-5]))
    early = np.arange(9) < 4  # load cases of their own, before and after
    whole = identify(arm, data, LINEAR, nuisance=nuisance())
    first = identify(arm, chosen(data, early), LINEAR, nuisance=nuisance())
    then = identify(arm, chosen(data, ~early), LINEAR, prior=first.model, nuisance=nuisance())
    np.testing.assert_allclose(
        then.unknown_covariance, whole.unknown_covariance, rtol=1e-6, atol=1e-18
    )
    assert not first.held
    assert not whole.held
    assert not then.held
    np.testing.assert_allclose(then.unknown, whole.unknown, rtol=1e-6)
    assert then.dof == 3 * 10
