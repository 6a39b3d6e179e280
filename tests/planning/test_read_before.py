"""What was read before has errors of load cases, too: plans in two parts, by dense matrices."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import elastocal as ec
from elastocal.design.exact import ExactDesign
from elastocal.elastic.case_errors import (
    CaseErrors,
    common_columns,
    own_covariance,
    shared_covariance,
)
from elastocal.errors import InputError, PlanFileError
from elastocal.files.plans.done_section import done_section, read_done
from elastocal.matrices import scaled_inverse
from elastocal.measuring.measurements import Measurements
from elastocal.planning.aim import accuracy, aim_of
from elastocal.planning.blind_columns import columns_of
from elastocal.planning.certificate import lower_bound
from elastocal.planning.loss import loss_of
from elastocal.planning.remaining import done, knowing
from elastocal.planning.spread import spread
from elastocal.planning.with_errors import WithErrors
from elastocal.study.before import CarriedOut, Done
from elastocal.study.study import Study, with_count
from elastocal.study.two_steps import with_nuisance
from tests.campaigns import MARKERS
from tests.planning.test_aim import COMMON, by_aim, promised, told
from tests.planning.test_near import beside
from tests.planning.test_promise import ALL, PLAN, REPEATS

APART = beside(PLAN, 25.0)


def after_plan(study: Study, cases: ec.LoadCases, repeats: np.ndarray) -> Study:
    """The study after a plan that was carried out, as `prior: {plan: …}` makes it."""
    bare = with_nuisance(study, None)
    carried_out = CarriedOut(cases, repeats)
    prior = carried_out.information(bare.space)
    return with_nuisance(replace(bare, prior=prior, carried_out=carried_out), study.nuisance)


def readings(study: Study, cases: ec.LoadCases, repeats: np.ndarray) -> Measurements:
    """So many readings of load cases; what they read does not matter."""
    truth = ec.ComplianceModel(ec.joint_springs(study.robot), np.full(6, 1e-6))
    return ec.simulate(study, truth, cases, repeats, np.random.default_rng(0))


def after_readings(study: Study, cases: ec.LoadCases, repeats: np.ndarray) -> Study:
    """The study of the rest after readings, as `plan --after` makes it."""
    return knowing(study, done(study, readings(study, cases, repeats)))


@pytest.mark.parametrize("after", [after_plan, after_readings])
@pytest.mark.parametrize("errors", [ALL, COMMON])
def test_a_plan_in_two_parts_promises_what_it_does_in_one(
    errors: CaseErrors, after: object
) -> None:
    assert callable(after)
    study, half = told(errors), np.arange(6) < 3
    repeats = np.array([2, 7, 3, 1, 2, 1])
    whole = ec.assess(study, APART, repeats)
    rest = after(study, APART.chosen(half), repeats[half])
    parts = ec.assess(rest, APART.chosen(~half), repeats[~half])
    assert whole.promise is not None
    assert parts.promise is not None
    for name in ("rho0", "limit", "without"):
        expected = getattr(whole.promise, name)
        assert getattr(parts.promise, name) == pytest.approx(expected, rel=1e-7)
    np.testing.assert_allclose(parts.promise.covariance, whole.promise.covariance, rtol=1e-6)
    found = by_aim(accuracy(rest), APART.chosen(~half), repeats[~half])
    assert found == pytest.approx(whole.promise.rho0, rel=1e-7)
    # By their instrument alone, as if nothing else erred, those of before would promise more.
    blind = replace(rest, done=None, carried_out=None)
    assert promised(blind, APART.chosen(~half), repeats[~half]) < 0.9 * whole.promise.rho0


@pytest.mark.parametrize("after", [after_plan, after_readings])
def test_a_load_case_of_both_parts_shares_its_errors(after: object) -> None:
    assert callable(after)
    study = told(COMMON)
    first, second = np.array([1, 4, 3]), np.array([1, 3, 0])
    expected = promised(study, PLAN, first + second)
    rest = after(study, PLAN, first)
    again = PLAN.chosen(second > 0)
    assert promised(rest, again, second[:2]) == pytest.approx(expected, rel=1e-7)
    assert by_aim(accuracy(rest), again, second[:2]) == pytest.approx(expected, rel=1e-7)
    near = ec.LoadCases(again.q + np.radians(2.0), again.wrench)
    told_near = promised(rest, near, second[:2])
    assert told_near == pytest.approx(expected, rel=0.05)
    far = ec.LoadCases(APART.q[3:5], APART.wrench[3:5])
    assert promised(rest, far, second[:2]) < 0.95 * told_near  # those are new


def test_parts_are_lost_as_they_count() -> None:
    study, half = told(COMMON), np.arange(6) < 3
    ones = np.ones(3, dtype=np.int64)
    rest = after_plan(study, APART.chosen(half), ones)
    lost = loss_of(rest, APART.chosen(~half), ones)
    each = [
        promised(rest, APART.chosen(np.array(kept)), ones[:2]) for kept in ([4, 5], [3, 5], [3, 4])
    ]
    assert lost.rho0 == pytest.approx(max(each), rel=1e-9)
    assert lost.load_case == int(np.argmax(each)) + 1


def three_markers(errors: CaseErrors) -> Study:
    study = told(errors)
    experiments = replace(study.experiments, tool=MARKERS)
    bare = replace(with_nuisance(study, None), experiments=experiments)
    return with_nuisance(bare, study.nuisance)


def test_readings_of_some_markers_with_noise_of_their_own_by_dense_matrices() -> None:
    """Each load case has its own noise and reads other markers; all is one least squares."""
    study = three_markers(COMMON)
    assert study.nuisance is not None
    cases = APART.chosen(np.arange(5))
    full = readings(study, cases, np.ones(5, dtype=np.int64))
    kept = np.ones(len(full), dtype=bool)
    kept[[1, 5, 7, 8]] = False
    rng = np.random.default_rng(1)
    spread_of = rng.normal(scale=5e-5, size=(len(full), 3, 4))
    noise = (spread_of @ spread_of.transpose(0, 2, 1))[kept]
    data = replace(
        full,
        case=full.case[kept],
        marker=full.marker[kept],
        deflection=full.deflection[kept],
        covariance=noise,
        unloaded_of=np.zeros(0, dtype=np.int64),
    )
    rest = knowing(study, done(study, data))
    new = APART.chosen(np.array([5]))
    once = np.array([1])
    known = WithErrors(rest, study.nuisance)
    found = known.total(new, once)
    # Dense: all coordinates with their covariance, common errors integrated out.
    errors, whole = study.nuisance.errors, cases.followed_by(new)
    arm = replace(study.fitted_arm, springs=known.bending)
    rows = study.fitted.columns(ec.regressor(study.fitted_arm, whole))
    place = [
        *zip(data.case.tolist(), data.marker.tolist(), strict=True),
        *((5, marker) for marker in range(3)),
    ]
    absolute = own_covariance(errors, arm, known.usual, whole)
    absolute += shared_covariance(errors, arm, known.usual, whole)
    _, common = common_columns(errors, arm, known.usual, whole)
    size = 3 * len(place)
    a = np.concatenate([rows[i, 3 * k : 3 * k + 3] for i, k in place])
    g = np.concatenate([common[i, 3 * k : 3 * k + 3] for i, k in place])
    sigma = g @ g.T
    for s, (i, k) in enumerate(place):
        for t, (j, other) in enumerate(place):
            if i == j:
                block = absolute[i, 3 * k : 3 * k + 3, 3 * other : 3 * other + 3].copy()
                if s == t:
                    block += noise[s] if s < len(noise) else study.sigma**2 * np.eye(3)
                sigma[3 * s : 3 * s + 3, 3 * t : 3 * t + 3] += block
    assert sigma.shape == (size, size)
    expected = study.prior + a.T @ np.linalg.solve(sigma, a)
    f = len(study.fitted)
    covariance = scaled_inverse(found[None])[0][:f, :f]
    deviation = np.sqrt(np.diagonal(covariance))
    dense = scaled_inverse(expected[None])[0] / np.outer(deviation, deviation)
    np.testing.assert_allclose(covariance / np.outer(deviation, deviation), dense, atol=1e-6)


def test_what_markers_have_in_common_counts_as_it_was_read() -> None:
    study = three_markers(ALL)
    data = readings(study, PLAN, np.ones(3, dtype=np.int64))
    moved = np.full((len(data), 3, 1), 4e-5)
    covariance = data.covariance + moved @ moved.transpose(0, 2, 1)
    found = done(study, replace(data, common=moved, covariance=covariance)).precision
    whole = study.sigma**2 * np.eye(9) + np.full((9, 9), 1.6e-9)
    np.testing.assert_allclose(found @ whole, np.tile(np.eye(9), (3, 1, 1)), atol=1e-9)


def test_what_cannot_be_seen_counts_what_was_read() -> None:
    """The error that blind errors are held against is the promise."""
    half = np.arange(6) < 3
    rest = after_plan(told(COMMON), APART.chosen(half), REPEATS)
    seen = columns_of(rest, APART.chosen(~half), REPEATS)
    assert seen is not None
    expected = promised(rest, APART.chosen(~half), REPEATS)
    over = seen.moved[-len(seen.left) :]
    np.testing.assert_allclose(seen.left, expected * over, rtol=1e-6)


def test_the_bound_holds_after_readings() -> None:
    """No plan passes it: not those beside what was measured, nor those that repeat it."""
    study = with_count(told(COMMON), 4, None)
    rest = after_plan(study, PLAN, np.array([2, 2, 2]))
    bound = lower_bound(rest, np.random.default_rng(0))
    least = bound.loss(4)
    made = ec.plan(rest, effort=ec.Effort(batch=32, generations=3, patience=1, islands=1))
    assert made.assessment.promised >= least
    assert made.certificate.lower_bound <= made.assessment.promised < 1.1 * least
    assert promised(rest, PLAN, np.array([1, 2, 1])) >= least
    space, rng = rest.space, np.random.default_rng(1)
    for _ in range(20):
        cases = space.load_cases(space.sample(4, rng))
        assert promised(rest, cases, np.ones(4, dtype=np.int64)) >= least


def test_the_search_leaves_load_cases_that_were_measured() -> None:
    study = with_count(told(COMMON), 3, None)
    rest = after_plan(study, PLAN, np.array([4, 4, 4]))
    aim = aim_of(rest)
    assert aim.told is not None
    once, near = np.ones(3, dtype=np.int64), ec.LoadCases(PLAN.q + np.radians(2.0), PLAN.wrench)
    x = aim.space.points(near)
    np.testing.assert_allclose(aim.readings(x[None], once[None]), [[5.0, 5.0, 5.0]])
    assert aim.told.near_before(near)[0].sum() == 3
    before = ExactDesign(x, once, 0.0)
    after = spread(aim, aim.space, aim.goal(), before, np.random.default_rng(0))
    moved = aim.space.load_cases(after.x)
    assert not aim.told.near_before(moved)[0].any()
    assert promised(rest, moved, after.counts) < promised(rest, near, once)


def test_plans_that_link_what_was_measured_share_its_errors() -> None:
    """Two load cases of before are one with a new one between them."""
    q = np.repeat(PLAN.q[:1], 2, axis=0)
    q[1, 3] += np.radians(16.0)
    ends = ec.LoadCases(q, np.repeat(PLAN.wrench[:1], 2, axis=0))
    q = PLAN.q.copy()
    q[0, 3] += np.radians(8.0)
    new = ec.LoadCases(q, PLAN.wrench)
    study, times = told(COMMON), np.array([2, 3])
    rest = after_plan(study, ends, times)
    assert rest.nuisance is not None
    found = WithErrors(rest, rest.nuisance).sharing(new, np.array([[1, 1, 1]]))
    np.testing.assert_allclose(found, [[6.0, 1.0, 1.0]])
    whole = promised(study, ends.followed_by(new), np.append(times, [1, 1, 1]))
    assert promised(rest, new, np.ones(3, dtype=np.int64)) == pytest.approx(whole, rel=1e-7)


def test_the_file_of_a_plan_has_what_was_read() -> None:
    study = three_markers(ALL)
    cases = ec.LoadCases(PLAN.q, PLAN.wrench, 0.1 * PLAN.wrench)
    told_done = done(study, readings(study, PLAN, REPEATS))
    assert told_done.repeats.tolist() == REPEATS.tolist()
    assert told_done.experiments == 12
    for one in (told_done, replace(told_done, cases=cases)):
        section = json.loads(json.dumps(done_section(study.robot, one)))
        assert len(section["precisions_per_m2"]) == 1
        back = read_done(section, study.robot, "plan.json: after")
        np.testing.assert_allclose(back.cases.q, one.cases.q, atol=1e-12)
        np.testing.assert_allclose(back.cases.first, one.cases.first)
        assert back.cases.preloaded == one.cases.preloaded
        np.testing.assert_array_equal(back.repeats, one.repeats)
        np.testing.assert_array_equal(back.precision, one.precision)
    section["configurations"][1]["precision"] = 1
    with pytest.raises(PlanFileError, match=r"load case 2: precision: expected one of the 1 of"):
        read_done(section, study.robot, "plan.json: after")
    section["configurations"][1] |= {"precision": 0, "repeats": 0}
    with pytest.raises(PlanFileError, match=r"load case 2: repeats: expected a number from 1"):
        read_done(section, study.robot, "plan.json: after")
    section["configurations"][1]["repeats"] = 8
    with pytest.raises(PlanFileError, match=r"experiments: found 12, .* are 13"):
        read_done(section, study.robot, "plan.json: after")


def test_plans_that_do_not_say_how_often_are_refused_where_it_counts() -> None:
    study = told(ALL)
    before = done(study, readings(study, PLAN, REPEATS))
    old = Done(before.source, "", 12, before.cases, before.information)
    with pytest.raises(InputError, match="does not say how often its load cases were read before"):
        knowing(study, old)
    without = told(CaseErrors())
    np.testing.assert_allclose(knowing(without, old).prior, without.prior + before.information)
    other = three_markers(ALL)
    with pytest.raises(InputError, match="3 coordinates of each load case were read, and the tool"):
        knowing(other, before)


def test_what_else_is_known_later_is_known_of_what_was_read() -> None:
    """The nuisance of a study may come after its readings."""
    study = told(COMMON)
    rest = after_readings(study, PLAN, REPEATS)
    bare = with_nuisance(rest, None)
    assert bare.done is not None
    assert bare.done.information.shape == (5, 5)
    again = with_nuisance(bare, study.nuisance)
    far, once = APART.chosen(np.array([3])), np.array([1])
    assert promised(again, far, once) == pytest.approx(promised(rest, far, once), rel=1e-9)
