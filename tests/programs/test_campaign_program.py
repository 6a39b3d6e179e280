"""Campaigns as robot programs: cycles, order, never moving loaded; and what is refused."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.constraints import HalfSpace, Tilt
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InfeasibleError, InputError
from elastocal.motion.pace import Pace
from elastocal.programs.approach import Approach
from elastocal.programs.campaign_program import STANDARD_GRAVITY, campaign_program, load_text
from elastocal.programs.robot_program import (
    Ask,
    Measure,
    Move,
    RobotProgram,
    Settle,
    check_limits,
    path_program,
)
from elastocal.programs.writers import WRITERS, export
from tests.programs.writers.campaigns import arm, study_for
from tests.programs.writers.parsers import PARSERS

Q = np.array([[0.1, 0.2, 0.3], [-0.5, 0.6, -0.7]])
WRENCH = np.array([[0.0, 0, -100, 0, 0, 0], [10, 20, 30, 1, 2, 3]])


def campaign(repeats: Any = (2, 1), **options: Any) -> RobotProgram:
    study = study_for(arm("RRR"))
    return campaign_program(study, LoadCases(Q, WRENCH), np.array(repeats), **options)


def test_one_cycle() -> None:
    steps = campaign(repeats=(1, 1)).steps
    kinds = [type(step) for step in steps[:8]]
    assert kinds == [Move, Move, Settle, Measure, Ask, Settle, Measure, Ask]
    assert [step.loaded for step in steps[:8] if isinstance(step, Measure)] == [False, True]
    assert steps[8:10] == (Move(2), Move(3))
    assert steps[-1] == Move(2)


def test_targets_are_within_the_limits_to_the_last_digit() -> None:
    """A plan may be over a limit by rounding; a controller does not forgive that."""
    study = study_for(arm("RRR", limit=0.7))
    q = Q.copy()
    q[1] = [0.7 + 8e-7, -0.7 - 8e-7, 0.3]
    targets = campaign_program(study, LoadCases(q, WRENCH), np.array([1, 1])).targets
    assert np.abs(targets).max() == 0.7
    np.testing.assert_allclose(targets[[1, 3]], q, atol=9e-7)
    q[1, 1] = -0.7 - 4e-6
    with pytest.raises(InfeasibleError, match=r"load case 2 has joint 'J2' at -40\.1072.*40\.1070"):
        campaign_program(study, LoadCases(q, WRENCH), np.array([1, 1]))


@pytest.mark.parametrize("study_limits", [None, 400.0, 180.0])
def test_joints_that_turn_without_end_are_exported_as_planned(study_limits: float | None) -> None:
    """Planning looks within half a turn; what is planned elsewhere is no mistake."""
    robot = arm("RRR", limit=np.inf)
    study = study_for(robot)
    if study_limits is not None:
        limits = np.radians(study_limits) * np.array([[-1.0], [1.0]]) * np.ones(3)
        study = replace(study, limits=limits, endless=np.zeros((2, 3), dtype=bool))
    q = np.radians([[190.0, 10.0, -170.0], [-300.0, 200.0, 0.0]])
    if study_limits == 180.0:  # limits that somebody gave hold, also at half a turn
        with pytest.raises(InfeasibleError, match="load case 1 breaks J1 <= 180"):
            campaign_program(study, LoadCases(q, WRENCH), np.array([1, 1]))
        return
    program = campaign_program(study, LoadCases(q, WRENCH), np.array([1, 1]))
    np.testing.assert_allclose(program.targets[[1, 3]], q, rtol=0, atol=1e-15)
    np.testing.assert_allclose(program.targets[[0, 2]], q - np.radians(0.5), rtol=0, atol=1e-15)
    for controller in WRITERS:
        if controller == "urscript":
            continue
        moves = [
            v for kind, v in PARSERS[controller](export(program, controller)) if kind == "move"
        ]
        found = np.array(moves)[:4, :3]
        scale = 1.0 if controller == "ros" else 180.0 / np.pi
        np.testing.assert_allclose(found, scale * program.targets, rtol=0, atol=0.5001e-4)


def test_via_points_are_judged_by_the_study() -> None:
    up = HalfSpace("height of the flange", np.zeros(3), np.array([0.0, 0, 1]), 1.1)
    held = Tilt("tilt of flange x", [1, 0, 0], [1, 0, 0], np.radians(80.0))
    study = replace(study_for(arm("RRR")), constraints=(up, held))
    cases, once = LoadCases(np.zeros((2, 3)), WRENCH[:1].repeat(2, axis=0)), np.array([1, 1])
    none, low = np.zeros((0, 3)), np.array([[0.1, 0.0, 0.0], [0.0, 1.5, 1.5]])
    with pytest.raises(InfeasibleError) as error:
        campaign_program(study, cases, once, home=np.zeros(3), via=[none, low, none])
    assert str(error.value).startswith(
        "via point 2 from configuration 1 to configuration 2 breaks height of the flange by "
    )
    turned = np.array([[1.8, 0.0, 0.0]])
    with pytest.raises(InfeasibleError, match="via point 1 from configuration 2 to home breaks J1"):
        campaign_program(study, cases, once, via=[none, none, 2.0 * turned])
    program = campaign_program(study, cases, once, via=[none, turned, none])
    assert "where nothing is measured, via point 1 from configuration 1" in program.notes[-1]
    assert "breaks tilt of flange x by 23.1" in program.notes[-1]
    away = replace(study, pace=Pace(home=np.array([0.0, 1.5, 1.5])))
    campaign_program(away, cases, once, via=[none, low[1:], none])  # home is judged by itself


def test_repeats_are_whole_cycles_with_their_own_approach() -> None:
    program = campaign(repeats=(3, 2), home=np.zeros(3))
    visits = [program.target_names[s.target] for s in program.steps if isinstance(s, Move)]
    assert visits == ["H0", *["AP1", "P1"] * 3, *["AP2", "P2"] * 2, "H0"]
    measured = [s for s in program.steps if isinstance(s, Measure)]
    assert [s.experiment for s in measured] == [k for e in range(1, 6) for k in (e, e)]
    assert [s.configuration for s in measured] == [1] * 6 + [2] * 4
    assert program.experiments == 5


@pytest.mark.parametrize("home", [True, False])
def test_via_points_are_passed_in_order_where_they_were_planned(home: bool) -> None:
    """One to the first pose, two to the second, one on the way home; without home not the ends."""
    v = [0.01 * np.full((count, 3), k) for k, count in enumerate((1, 2, 1), start=1)]
    v[1] = np.array([[0.02, 0.0, 0.0], [0.0, 0.02, 0.0]])
    program = campaign(repeats=(2, 1), home=np.zeros(3) if home else None, via=v)
    moves = [s.target for s in program.steps if isinstance(s, Move)]
    names = [program.target_names[target] for target in moves]
    first, second = ["AP1", "P1"] * 2, ["AP2", "P2"]
    if home:
        assert names == ["H0", "V1", *first, "V2", "V3", *second, "V4", "H0"]
    else:
        assert names == [*first, "V2", "V3", *second, "AP2"]
    passed = [t for t, name in zip(moves, names, strict=True) if name in ("V2", "V3")]
    np.testing.assert_array_equal(program.targets[passed], v[1])


@settings(max_examples=50)
@given(repeats=st.lists(st.integers(1, 5), min_size=2, max_size=2), home=st.booleans())
def test_the_robot_never_moves_with_the_load_on(repeats: list[int], home: bool) -> None:
    loaded = False
    for step in campaign(repeats, home=np.zeros(3) if home else None).steps:
        if isinstance(step, Ask):
            loaded = "take the load off" not in step.text
        elif isinstance(step, Measure):
            assert step.loaded == loaded
        elif isinstance(step, Move):
            assert not loaded
    assert not loaded


def test_approach_distances() -> None:
    study = study_for(arm("PRR"))
    program = campaign_program(
        study, LoadCases(Q, WRENCH), np.array([1, 1]), approach=Approach(0.02, 0.003)
    )
    np.testing.assert_allclose(
        program.targets[1::2] - program.targets[::2], [[0.003, 0.02, 0.02]] * 2
    )
    plain = campaign_program(study, LoadCases(Q, WRENCH), np.array([1, 1]))
    np.testing.assert_allclose(plain.targets[1] - plain.targets[0], [1e-3, *np.radians([0.5, 0.5])])


def test_loads_in_words() -> None:
    assert load_text(np.array([0, 0, -2500.0, 0, 0, 0])) == "hang 254.929 kg, Fx 0 Fy 0 Fz -2500 N"
    up = np.array([0, 0, 2500.0, 0, 0, 0])
    assert load_text(up) == "apply 2500 N, Fx 0 Fy 0 Fz 2500 N"
    skew = np.array([0.001, 0, -10.0, 0, 0, 0])
    assert load_text(skew).startswith("apply 10 N")
    turn = np.array([0.0, 0, 0, -1.25, 0, 100])
    assert load_text(turn) == "Tx -1.25 Ty 0 Tz 100 N.m"
    kilogram = np.array([0, 0, -STANDARD_GRAVITY, 0, 0, 0])
    assert load_text(kilogram).startswith("hang 1 kg")


def test_a_plan_that_breaks_a_limit_or_a_load_is_refused() -> None:
    study = study_for(arm("RRR", limit=0.55))
    with pytest.raises(InfeasibleError) as error:
        campaign_program(study, LoadCases(Q, WRENCH), np.array([1, 1]))
    assert error.value.doubts[0].code == "constraint-broken"
    assert error.value.doubts[0].numbers["load_case"] == 2
    with pytest.raises(InfeasibleError) as error:
        campaign_program(study_for(arm("RRR"), 90.0), LoadCases(Q, WRENCH), np.array([1, 1]))
    assert error.value.doubts[0].code == "load-too-large"
    assert error.value.doubts[0].numbers["bound"] == 90.0


def test_home_must_keep_the_limits_and_is_noted_if_it_breaks_constraints() -> None:
    up = HalfSpace("height of the flange", np.zeros(3), np.array([0.0, 0, 1]), 1.1)
    study = replace(study_for(arm("RRR")), constraints=(up,))
    cases, once = LoadCases(np.zeros((1, 3)), WRENCH[:1]), np.array([1])
    low = campaign_program(study, cases, once, home=[0.0, 1.5, 1.5])
    assert low.notes[-1].startswith("Home breaks height of the flange by ")
    high = campaign_program(study, cases, once, home=np.zeros(3))
    assert not any("Home breaks" in note for note in high.notes)
    with pytest.raises(InputError, match="target home: joint 'J1' is at 200°"):
        campaign_program(study, cases, once, home=np.radians([200.0, 0, 0]))
    with pytest.raises(InputError, match="home needs 3"):
        campaign_program(study, cases, once, home=[0.0])


@pytest.mark.parametrize(
    ("approach", "words"),
    [
        ({"settle": -1.0}, "settling time"),
        ({"settle": 301.0}, "settling time"),
        ({"settle": np.nan}, "settling time"),
        ({"angle": -0.1}, "approach distance"),
        ({"angle": np.nan}, "approach distance"),
        ({"length": np.inf}, "approach distance"),
        ({"angle": 4.0}, "cannot be approached"),
    ],
)
def test_approaches_out_of_range(approach: dict[str, float], words: str) -> None:
    with pytest.raises(InputError, match=words):
        campaign(approach=Approach(**approach))


@pytest.mark.parametrize("speed", [0.0, 1.1])
def test_speeds_out_of_range(speed: float) -> None:
    with pytest.raises(InputError, match="speed"):
        campaign(speed=speed)


def test_provenance() -> None:
    program = campaign(digest="ab" * 32)
    assert program.provenance.digest == "ab" * 32
    assert program.provenance.study == "study"
    assert program.provenance.made_by.startswith("elastocal ")


def test_a_path_is_its_targets_in_order() -> None:
    program = path_program(arm("RRR"), Q, name="corrected")
    np.testing.assert_array_equal(program.targets, Q)
    assert program.steps == (Move(0), Move(1))
    assert program.experiments == 0
    assert not program.targets.flags.writeable


@pytest.mark.parametrize(
    ("q", "words"),
    [
        ([[0.0, 4.0, 0.0]], "target P1: joint 'J2' is at 229.183°"),
        ([[0.0, 0.0, 0.0], [0.0, np.nan, 0.0]], "target P2: joint 'J2' has no finite value"),
        ([[0.0, 0.0]], r"targets of shape \(T, 3\)"),
        ([], "a path needs targets"),
        ([0.0, 0.0, 0.0], "a path needs targets"),
    ],
)
def test_paths_that_are_none(q: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        path_program(arm("RRR"), q, name="x")


@pytest.mark.parametrize("end", [-1.0, 1.0])
def test_targets_at_a_limit_may_be_beyond_it_by_rounding(end: float) -> None:
    robot = arm("RRR", limit=0.7)
    for beyond, refused in ((1e-10, False), (1e-3, True)):
        q = np.array([[0.0, end * (0.7 + beyond), 0.0]])
        if refused:
            with pytest.raises(InputError, match=r"'J2' is at .*, expected -40\.107 to 40\.107°"):
                check_limits(robot, q, ["P1"])
        else:
            check_limits(robot, q, ["P1"])
