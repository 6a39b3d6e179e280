"""Compliances that errors of the joint readings alone tell apart are said to be known together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.elastic.springs import joint_springs
from elastocal.errors import Doubt, InputError
from elastocal.identification.doubts import doubts, is_weak
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.parallel import READ, parallel, refuse_parallel
from elastocal.measuring.measurements import Measurements
from elastocal.wording import worded
from tests.campaigns import TRUTH, arm, hung, measured

NAMES = ("A2", "A3", "A5")
LINEAR = Fit("linear")


def near_to_straight(spread: float, *, noise: float = 3e-5) -> Measurements:
    """Eight poses within some degrees of one in which the three axes are parallel, as read."""
    rng = np.random.default_rng(1)
    q = np.radians([0, -45, 10, 0, -10, 0]) + np.radians(spread) * rng.normal(size=(8, 6))
    cases = LoadCases(q, np.tile([0.0, 0.0, -2500.0, 0.0, 0.0, 0.0], (8, 1)))
    data = measured(arm(NAMES), cases, TRUTH[[0, 1, 3]], rng=rng, noise=noise)
    return replace(data, cases=LoadCases(q + READ * rng.normal(size=q.shape), cases.wrench))


def said(spread: float) -> dict[str, Doubt]:
    found = identify(arm(NAMES), near_to_straight(spread), LINEAR)
    return {d.code: d for d in doubts(found) if "parallel" in d.code}


def test_what_readings_of_joints_make_is_not_knowledge() -> None:
    assert said(5.0) == said(0.3) == {}
    near = said(0.03)["nearly-parallel"]
    assert not is_weak(near)
    assert "bias" in worded(near)
    weak = said(0.01)["parallel"]
    assert is_weak(weak)
    assert weak.about == NAMES
    assert weak.numbers["seen"] == 2.0
    assert "only 2 combinations of them are known" in worded(weak)


def test_bias_is_as_foretold() -> None:
    """An estimate along the direction that is told least shrinks by 1 / (1 + 1/μ)."""
    spread, rng = 0.03, np.random.default_rng(2)
    exact = near_to_straight(spread)
    q = np.radians([0, -45, 10, 0, -10, 0]) + np.radians(spread) * np.random.default_rng(1).normal(
        size=(8, 6)
    )
    cases = LoadCases(q, exact.cases.wrench)
    true = np.array([0.3, 30.0, -60.0]) * 1e-6  # mostly what is told least
    clean = replace(measured(arm(NAMES), cases, true, linear=True), cases=cases)
    estimates = []
    for _ in range(300):
        read = LoadCases(q + READ * rng.normal(size=q.shape), cases.wrench)
        estimates.append(identify(arm(NAMES), replace(clean, cases=read), LINEAR).compliance)
    (doubt,) = parallel(identify(arm(NAMES), clean, LINEAR))
    shrunk = np.median(np.array(estimates)[:, 2]) / true[2]
    assert shrunk == pytest.approx(1.0 / (1.0 + 1.0 / doubt.numbers["ratio"]), abs=0.03)


def test_the_combination_that_is_known_is_named() -> None:
    """The load in line with the axes of A2 and A3: both move it the same way."""
    two, angle = arm(("A2", "A3")), 0.5
    for width in 1.0 / 50.0 ** np.arange(8):
        q = np.tile(np.radians([0, -45, 0, 0, 0, 0]), (201, 1))
        q[:, 2] = angle + np.linspace(-width, width, 201)
        rows = regressor(two, LoadCases(q, np.tile([0.0, 0, -2500, 0, 0, 0], (201, 1))))
        apart = np.linalg.norm(np.cross(rows[:, :, 0], rows[:, :, 1]), axis=1)
        angle = float(q[int(np.argmin(apart)), 2])
    q = np.tile(np.radians([0, -45, 0, 0, 0, 0]), (8, 1))
    q[:, 2] = angle
    exact = measured(two, LoadCases(q, np.tile([0.0, 0, -2500, 0, 0, 0], (8, 1))), TRUTH[:2])
    off = READ * np.random.default_rng(5).normal(size=q.shape)
    found = identify(two, replace(exact, cases=LoadCases(q + off, exact.cases.wrench)), LINEAR)
    (doubt,) = (d for d in doubts(found) if d.code == "parallel")
    assert doubt.numbers["seen"] == 1.0
    assert "only the combination A2 + 0." in worded(doubt)
    factor = doubt.numbers["A3"]
    known = found.compliance @ [1.0, factor]
    assert known == pytest.approx(TRUTH[:2] @ [1.0, factor], rel=0.02)


def test_ordinary_campaigns_have_none() -> None:
    for count in (3, 12, 60):
        data = measured(arm(), hung(count), rng=np.random.default_rng(3))
        assert parallel(identify(arm(), data, LINEAR)) == ()
        refuse_parallel(arm(), data)


def test_a_prior_tells_what_readings_do_not() -> None:
    data = near_to_straight(0.01)
    before = measured(arm(NAMES), hung(12), TRUTH[[0, 1, 3]], rng=np.random.default_rng(4))
    prior = identify(arm(NAMES), before, LINEAR).model
    assert parallel(identify(arm(NAMES), data, LINEAR, prior=prior)) == ()


def test_what_is_known_before_need_not_be_seen() -> None:
    """A spring that no reading moves but by rounding, known from before, is no riddle."""
    data = near_to_straight(5.0)
    first = joint_springs(arm().robot, ("A1",))
    known = ComplianceModel(first, np.array([1e-6]), np.array([[1e-14]]))
    found = identify(arm(NAMES), data, LINEAR, known=known)
    assert "A1" in found.fitted
    assert np.abs(regressor(replace(arm(NAMES), springs=first), data.cases)).max() < 1e-9
    assert parallel(found) == ()


def test_it_is_the_reason_why_a_fit_does_not_come_to_rest() -> None:
    data = near_to_straight(0.002, noise=3e-3)
    with pytest.raises(InputError, match="does not come to rest"):
        identify(arm(NAMES), data)
    with pytest.raises(InputError, match="only 2 combinations of them are known") as error:
        refuse_parallel(arm(NAMES), data)
    assert error.value.doubts[0].code == "parallel"
