"""What else explains readings: a missing spring, a tool that shifted, a convention; in a right
model nothing."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from elastocal.arrays import Array
from elastocal.elastic.arm import ElasticArm
from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import deflection
from elastocal.elastic.springs import VirtualJoints, joint_springs, merged
from elastocal.errors import InputError
from elastocal.files.models.identification_section import identification_sections
from elastocal.identification.candidate_columns import Candidate, candidates
from elastocal.identification.candidates import added, each_added, what_is_missing
from elastocal.identification.convention_search import other_convention
from elastocal.identification.doubts import is_weak
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.impossible import refuse_impossible_fit
from elastocal.identification.linearised import linearised
from elastocal.identification.result import Identification
from elastocal.identification.search import searched
from elastocal.measuring.measurements import Measurements
from elastocal.robot.chain import T_body_joint, Tool
from elastocal.robot.controller_axes import coupling, uncoupled
from elastocal.robot.posture import Posture, flange_axes
from elastocal.wording import worded
from tests.campaigns import MARKERS, SIGMA, arm, sideways

NAMES = ("A1", "A2", "A3", "A4", "A5", "A6")
TRUTH = np.array([0.45, 0.302, 0.406, 3.002, 3.303, 2.365]) * 1e-6
LINEAR, ESTIMATED = Fit("linear"), Fit("linear", "estimated")


def bent(tool: Tool | None = None) -> ElasticArm:
    return arm(NAMES, tool)


def forearm() -> VirtualJoints:
    """A spring about x of the frame of A3."""
    robot = bent().robot
    frame = T_body_joint(robot, 3)
    axis = frame[:3, :3] @ [1.0, 0.0, 0.0]
    at = frame[:3, 3][None]
    return VirtualJoints(("bend",), np.array([3]), axis[None], at, np.array([False]))


def read(
    values: Array, cases: LoadCases, *, seed: int | None = 0, tool: Tool | None = None
) -> Measurements:
    """Readings of deflections (N, 3K), with noise unless there is no seed."""
    tool = tool or bent().tool
    values = values.reshape(-1, 3)
    if seed is not None:
        values = values + SIGMA * np.random.default_rng(seed).normal(size=values.shape)
    case, marker = np.divmod(np.arange(len(values)), len(tool.markers))
    names = tuple(map(str, range(1, len(cases) + 1)))
    covariance = np.tile(SIGMA**2 * np.eye(3), (len(values), 1, 1))
    return Measurements(tool, cases, names, case, marker, values, covariance)


def fitted(values: Array, cases: LoadCases, how: Fit = ESTIMATED, seed: int = 0) -> Identification:
    return identify(bent(), read(values, cases, seed=seed), how)


def missing(found: Identification) -> list[Candidate]:
    return [one.candidate for one in what_is_missing(found).missing]


def test_a_spring_that_is_missing_is_named_with_what_it_changes() -> None:
    cases = sideways(24)
    robot = bent().robot
    soft = ElasticArm(robot, merged(joint_springs(robot, NAMES), forearm()), bent().tool)
    truth = dict(zip((*NAMES, "bend"), [*TRUTH, 1e-6], strict=True))
    values = deflection(soft, np.array([truth[n] for n in soft.springs.names]), cases)[:, :3]
    for how in (ESTIMATED, LINEAR, Fit(sigma="estimated"), Fit("linear", "estimated", "huber")):
        found = fitted(values, cases, how)
        lacks = what_is_missing(found)
        assert [one.candidate for one in lacks.missing] == [Candidate("turning", "A3", "x")]
        one = lacks.missing[0]
        assert one.size[0] == pytest.approx(1e-6, rel=0.15)
        assert one.left_out < 0.6 * one.before
        (doubt,) = lacks.doubts
        assert is_weak(doubt)
        assert "a spring about x of A3" in worded(doubt)
    # What it says is what a fit with it gives.
    found = fitted(values, cases)
    whole = identify(soft, read(values, cases), ESTIMATED)
    change = [c for n, c in zip(whole.identified, whole.compliance, strict=True) if n != "bend"]
    lacks = what_is_missing(found)
    np.testing.assert_allclose(
        found.compliance * (1.0 + lacks.missing[0].change), change, rtol=1e-6
    )
    left = np.sqrt(np.mean(np.sum(whole.left_out**2, axis=1)))
    assert lacks.missing[0].left_out == pytest.approx(left)
    assert missing(whole) == []


def test_a_tool_that_shifted_is_named_with_how_far() -> None:
    cases = sideways(16)
    values = deflection(bent(), TRUTH, cases)[:, :3]
    shift = np.array([0.0, 0.2e-3, 1.9e-3])
    values = values + flange_axes(Posture(bent().robot, cases.q)) @ shift
    (one,) = what_is_missing(fitted(values, cases)).missing
    assert one.candidate == Candidate("tool-shift")
    np.testing.assert_allclose(one.size, shift, atol=5e-5)
    assert "mm in its frame" in worded(what_is_missing(fitted(values, cases)).doubts[0])


def test_a_station_that_moved_is_named() -> None:
    cases = sideways(16)
    values = deflection(bent(), TRUTH, cases)[:, :3]
    moved = values + np.array([5e-4, -3e-4, 0.0])
    assert missing(fitted(moved, cases))[0] == Candidate("station-shift")
    turn = np.array([0.0, 0.0, 4e-4])
    at = Posture(bent().robot, cases.q).point(bent().tool.markers[0]).T
    assert missing(fitted(values + np.cross(turn, at), cases))[0] == Candidate("station-turn")


def test_a_rigid_joint_that_bends_is_named() -> None:
    cases = sideways(20)
    values = deflection(bent(), TRUTH, cases)[:, :3]
    without = arm(NAMES[1:])
    found = identify(without, read(values, cases), ESTIMATED)
    assert missing(found)[0] == Candidate("in-joint", "A1")


def test_nothing_is_missing_in_a_right_model() -> None:
    for count in (8, 12, 40):
        alarms = 0
        for seed in range(40):
            cases = sideways(count, seed)
            values = deflection(bent(), TRUTH, cases)[:, :3]
            alarms += bool(missing(fitted(values, cases, seed=seed)))
        assert alarms <= 2  # of 40; one in 100 is expected


def test_several_markers_and_one_configuration_alone() -> None:
    cases = sideways(6)
    values = deflection(bent(MARKERS), TRUTH, cases)[:, :9]
    found = identify(bent(MARKERS), read(values, cases, tool=MARKERS), ESTIMATED)
    assert missing(found) == []
    one = LoadCases(cases.q[[0] * 6], cases.wrench)  # nothing can be left out
    few = arm(("A2", "A3"))
    values = deflection(few, TRUTH[1:3], one)[:, :3]
    lacks = what_is_missing(identify(few, read(values, one), ESTIMATED))
    assert lacks.missing == ()
    assert all(np.isfinite(list(d.numbers.values())).all() for d in lacks.doubts)
    exact = fitted(deflection(bent(), TRUTH, cases)[:, :3], cases)
    quiet = replace(exact.measurements, deflection=exact.measurements.deflection - exact.residual)
    assert missing(identify(bent(), quiet, ESTIMATED)) == []


def test_a_candidate_enters_as_a_refit_would() -> None:
    """Also where a prior counts, which no reading repeats."""
    cases = sideways(12)
    values = deflection(bent(), TRUTH, cases)[:, :3]
    before = fitted(values, cases, seed=5).model
    found = identify(bent(), read(values, cases, seed=1), LINEAR, prior=before)
    fit = linearised(found)
    name, columns = next(c for c in candidates(found) if c[0] == Candidate("turning", "A3", "x"))
    white = fit.white(columns)
    whole = added(fit, white)
    flat = np.hstack([fit.rows.reshape(-1, 6), white.reshape(-1, 1)])
    prior = fit.information - flat[:, :6].T @ flat[:, :6]
    information = flat.T @ flat
    information[:6, :6] += prior
    pull = flat.T @ fit.residual.ravel() * np.array([0, 0, 0, 0, 0, 0, 1])
    step = np.linalg.solve(information, pull)
    np.testing.assert_allclose(
        whole.residual.ravel(), fit.residual.ravel() - flat @ step, atol=1e-9
    )
    (one,) = each_added(fit, [(name, white)], found.compliance, known=True)
    np.testing.assert_allclose(one.size, step[6:], rtol=1e-8)


WRONG = [
    coupling(bent().robot),
    coupling(bent().robot, signs={"A3": -1, "A5": -1}),
    coupling(bent().robot, signs={"A2": -1}, couple={"A3": {"A2": 1.0}}),
]


@pytest.mark.parametrize("assumed", WRONG)
def test_the_convention_is_told_by_the_readings(assumed: object) -> None:
    robot, cases = bent().robot, sideways(30, seed=3)
    signs = dict.fromkeys(("A3", "A4", "A6"), -1.0)
    true = coupling(robot, signs=signs, couple={"A3": {"A2": -1.0}})
    values = deflection(bent(), TRUTH, cases)[:, :3]
    shown = true.to_controller(cases.q)
    read_as = LoadCases(assumed.to_model(shown), cases.wrench)  # type: ignore[attr-defined]
    for how in (ESTIMATED, Fit("linear", "estimated", nonnegative=True)):
        found = identify(bent(), read(values, read_as), how)
        other = other_convention(found, assumed)  # type: ignore[arg-type]
        assert other is not None
        assert other.after < 0.2 * other.before
        mended = {d.about[0]: d.numbers["sign"] for d in other.mistakes if "sign" in d.numbers}
        was = {n: float(np.sign(s)) for n, s in zip(NAMES, np.diag(assumed.matrix), strict=True)}  # type: ignore[attr-defined]
        now = {**was, **mended}
        assert now == {name: signs.get(name, 1.0) for name in NAMES}
        assert searched(found, assumed).lacks is None  # type: ignore[arg-type]
        assert "another one fits best" in worded(other.doubt)


def test_controller_values_taken_as_those_of_the_model() -> None:
    robot, cases = bent().robot, sideways(30, seed=3)
    true = coupling(robot, signs={"A3": -1, "A4": -1}, couple={"A3": {"A2": -1.0}})
    values = deflection(bent(), TRUTH, cases)[:, :3]
    found = identify(
        bent(), read(values, LoadCases(true.to_controller(cases.q), cases.wrench)), ESTIMATED
    )
    other = other_convention(found, true)
    assert other is not None
    assert "joints: controller" in worded(other.doubt)


def test_the_right_convention_is_left_alone() -> None:
    """Also with a tool that shifted, so that little is explained."""
    for seed in range(10):
        cases = sideways(12, seed)
        values = deflection(bent(), TRUTH, cases)[:, :3]
        values = values + flange_axes(Posture(bent().robot, cases.q)) @ [0.0, 0.0, 3e-3]
        found = fitted(values, cases, seed=seed)
        assert other_convention(found, uncoupled(bent().robot)) is None


def test_a_refusal_names_the_convention() -> None:
    robot, cases = bent().robot, sideways(30, seed=4)
    values = deflection(bent(), TRUTH, cases)[:, :3]
    wrong = LoadCases(cases.q * [1, -1, -1, 1, 1, 1], cases.wrench)
    found = identify(bent(), replace(read(values, wrong), covariance=found_small(30)), LINEAR)
    with pytest.raises(InputError, match="another one fits best") as error:
        refuse_impossible_fit(found, uncoupled(robot))
    assert [d.code for d in error.value.doubts] == ["impossible-fit", "other-convention"]


def found_small(count: int) -> Array:
    return np.tile((0.2 * SIGMA) ** 2 * np.eye(3), (count, 1, 1))


def test_documents_have_what_was_looked_for() -> None:
    cases = sideways(12)
    values = deflection(bent(), TRUTH, cases)[:, :3] + np.array([5e-4, 0.0, 0.0])
    found = fitted(values, cases)
    diagnostics = identification_sections(found, searched(found, uncoupled(bent().robot)))[
        "diagnostics"
    ]
    json.dumps(diagnostics)
    (first, *_) = [c for c in diagnostics["candidates"] if c["missing"]]
    assert first["kind"] == "station-shift"
    assert first["size_SI"] == pytest.approx([5e-4, 0.0, 0.0], abs=1e-4)
    assert set(first["changes"]) == set(NAMES)
    assert "candidates" not in identification_sections(found)["diagnostics"]


def test_readings_that_share_an_unloaded_one_miss_nothing() -> None:
    """Errors in common look like a shift, unless it is known that they are in common."""
    alarms = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        place = np.repeat(np.arange(6), 4)  # four loads after each unloaded reading
        cases = LoadCases(sideways(6, seed).q[place], sideways(24, seed).wrench)
        values = deflection(bent(), TRUTH, cases)[:, :3]
        noise = SIGMA / np.sqrt(2.0) * rng.normal(size=(30, 3))
        data = read(values + noise[:24] - noise[24:][place], cases, seed=None)
        alarms += bool(missing(identify(bent(), replace(data, unloaded_of=place), ESTIMATED)))
    assert alarms <= 2
