"""Exports: golden files, parsed back, linted; and what controllers cannot hold."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.programs.approach import Approach
from elastocal.programs.campaign_program import campaign_program
from elastocal.programs.robot_program import RobotProgram, path_program
from elastocal.programs.writers import ENDINGS, WRITERS, Settings, export
from elastocal.programs.writers.wording import header
from elastocal.robot.chain import Follower, Joint, Robot
from elastocal.robot.controller_axes import coupling
from tests.programs.writers.campaigns import (
    DIGEST,
    GOLDEN,
    PROGRAMS,
    SHOWN,
    arm,
    expected,
    kr270_program,
    rail_program,
    study_for,
)
from tests.programs.writers.lints import LINTS
from tests.programs.writers.parsers import PARSERS, Event

RADIANS = {"urscript", "ros"}
DEGREES = 1e-4  # what values must agree to, in degrees or millimetres


def check(program: RobotProgram, controller: str, given: Settings | None = None) -> None:
    """Lint, parse back, compare with the program itself."""
    files = export(program, controller, given)
    assert LINTS[controller](files) == []
    found = PARSERS[controller](files)
    robot, n = program.robot, len(program.robot.joints)
    scale = np.ones(n) if controller in RADIANS else robot.shown_scale
    order = list(range(n))
    if controller not in RADIANS and n > 6:
        lead = int(np.flatnonzero(~robot.prismatic)[0])
        outside = (
            list(range(lead))
            if given is None or given.external is None
            else robot.index(given.external)
        )
        order = [i for i in order if i not in outside] + outside
        arm_axes = n - len(outside)
    else:
        arm_axes = n
    wanted = expected(program, scale, order)
    tolerance = np.radians(DEGREES) * 1e-2 if controller in RADIANS else DEGREES
    if controller == "ros":
        wanted = as_documents(wanted)
    if controller == "rapid":  # axes that the arm lacks are zero
        wanted = [(k, pad(v, arm_axes)) if k == "move" else (k, v) for k, v in wanted]
    compare(found, wanted, tolerance)


def pad(values: list[float], arm_axes: int) -> list[float]:
    return [*values[:arm_axes], *[0.0] * (6 - arm_axes), *values[arm_axes:]]


def compare(found: list[Event], wanted: list[Event], tolerance: float) -> None:
    """Events agree in kind and order, numbers to a tolerance, texts but for forbidden signs."""
    assert [kind for kind, _ in found] == [kind for kind, _ in wanted]
    for (kind, value), (_, want) in zip(found, wanted, strict=True):
        if kind == "move":
            np.testing.assert_allclose(value, want, rtol=0, atol=tolerance)
        elif kind == "wait":
            assert value == pytest.approx(want, abs=0.0051)
        else:
            assert value == " ".join(want.split())


def as_documents(events: list[Event]) -> list[Event]:
    """Stops without a motion between them are one comment in a trajectory file."""
    merged: list[Event] = []
    for kind, value in events:
        if (kind, value) == ("wait", 0.0) and (not merged or merged[-1][0] == "move"):
            continue
        stopped = bool(merged) and merged[-1][0] == "stop"
        if kind == "wait" and stopped:
            merged[-1] = ("stop", f"{merged[-1][1]} Wait {value:g} s.")
        elif kind == "stop" and stopped:
            merged[-1] = ("stop", f"{merged[-1][1]} {value}")
        else:
            merged.append((kind, value))
    return merged


@pytest.mark.parametrize(("which", "controller"), SHOWN)
def test_golden_files(which: str, controller: str) -> None:
    for name, text in export(PROGRAMS[which](), controller).items():
        assert text == (GOLDEN / name).read_text(encoding="ascii")


def test_every_golden_file_is_compared() -> None:
    made = {name for which, c in SHOWN for name in export(PROGRAMS[which](), c)}
    assert made == {path.name for path in GOLDEN.iterdir()}


@pytest.mark.parametrize(("which", "controller"), SHOWN)
def test_parsed_back(which: str, controller: str) -> None:
    check(PROGRAMS[which](), controller)


@pytest.mark.parametrize(("watched", "words"), [(True, "were checked"), (False, "are not checked")])
def test_header_says_whether_motions_were_checked(watched: bool, words: str) -> None:
    program = replace(kr270_program(), watched=watched)
    text = " ".join(header(program, Settings(), 200, units="degrees, mm"))
    assert ("were checked" in text, "are not checked" in text) == (watched, not watched)
    assert words in text


@pytest.mark.parametrize("controller", WRITERS)
def test_provenance_and_safety_in_every_file(controller: str) -> None:
    for name, text in export(kr270_program(), controller).items():
        assert name.endswith((ENDINGS[controller], ".dat"))
        plain = " ".join(re.sub(r"^\s*(\d+:)?\s*[;!#]?|;$", "", li) for li in text.splitlines())
        plain = " ".join(plain.replace(" ;", " ").split())
        for words in (
            DIGEST[:16],
            "elastocal",
            "KR 270 milling cell",
            "SAFETY: check",
            "low speed",
        ):
            assert words in plain, words


@pytest.mark.parametrize("controller", WRITERS)
def test_forces_stand_in_the_messages(controller: str) -> None:
    program = rail_program() if controller != "urscript" else kr270_program()
    said = " ".join(
        v for kind, v in PARSERS[controller](export(program, controller)) if kind == "stop"
    )
    if controller == "urscript":
        assert said.count("hang 254.929 kg, Fx 0 Fy 0 Fz -2500 N") == 4
        return
    assert said.count("apply 374.63 N, Fx 100 Fy -200.5 Fz -300.25 N") == 1
    assert said.count("hang 10 kg, Fx 0 Fy 0 Fz -98.07 N, Tx 1.5 Ty 0 Tz -2 N.m") == 2


@pytest.mark.parametrize(
    ("controller", "output", "number"),
    [
        ("krl", "17", "17"),
        ("rapid", "doTracker", "doTracker"),
        ("fanuc", "5", "5"),
        ("urscript", "0", "0"),
    ],
)
def test_measurements_pulse_the_output(controller: str, output: str, number: str) -> None:
    files = export(kr270_program(), controller, Settings(trigger=output))
    assert LINTS[controller](files) == []
    pulses = [value for kind, value in PARSERS[controller](files) if kind == "pulse"]
    assert pulses == [number] * 8  # four experiments, unloaded and loaded


@pytest.mark.parametrize(
    ("controller", "output"),
    [
        ("krl", "0"), ("krl", "one"), ("krl", "5000"), ("rapid", "1 2"), ("rapid", "x;y"),
        ("rapid", "a" * 33), ("fanuc", "-1"), ("urscript", "8"), ("ros", "1"), ("csv", "1"),
    ],
)  # fmt: skip
def test_outputs_that_there_are_not(controller: str, output: str) -> None:
    with pytest.raises(InputError):
        export(kr270_program(), controller, Settings(trigger=output))


@st.composite
def programs(draw: st.DrawFn) -> RobotProgram:
    """Campaigns of random robots, with any limits, poses, repeats and loads."""
    rails = draw(st.integers(0, 3))
    kinds = draw(st.text("RP", min_size=0, max_size=5))
    robot = arm("P" * rails + "R" + kinds, limit=draw(st.sampled_from([0.7, np.pi, 6.1])))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count, n = draw(st.integers(1, 4)), len(robot.joints)
    share = rng.uniform(0.0, 1.0, (count, n))
    edge = draw(st.booleans())
    if edge:  # some joints exactly at a limit
        share = np.where(rng.uniform(size=share.shape) < 0.3, np.round(share[:1]), share)
    q = robot.lower + share * (robot.upper - robot.lower)
    wrench = rng.normal(size=(count, 6)) * 100.0
    if draw(st.booleans()):
        wrench[:, [0, 1, 3, 4, 5]], wrench[:, 2] = 0.0, -np.abs(wrench[:, 2])
    study = study_for(robot, name=draw(st.text(max_size=60)))
    return campaign_program(
        study,
        LoadCases(np.clip(q, robot.lower, robot.upper), wrench),
        rng.integers(1, 4, count),
        home=draw(st.sampled_from([None, np.zeros(n)])),
        approach=Approach(
            0.0 if edge else np.radians(0.5),
            0.0 if edge else 1e-3,
            draw(st.floats(0.0, 300.0).map(lambda s: round(s, 2))),
        ),
        speed=draw(st.floats(0.01, 1.0)),
        digest=DIGEST,
    )


@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
@given(program=programs(), controller=st.sampled_from(sorted(set(WRITERS) - {"urscript"})))
def test_any_campaign_of_any_robot(program: RobotProgram, controller: str) -> None:
    leading = int(np.flatnonzero(~program.robot.prismatic)[0])
    fits = len(program.robot.joints) <= 6 or len(program.robot.joints) - leading <= 6
    if controller in ("ros", "csv") or fits:
        check(program, controller)
    else:
        with pytest.raises(InputError, match="external"):
            export(program, controller)


@settings(max_examples=30)
@given(
    turns=st.lists(st.floats(-6.2, 6.2), min_size=12, max_size=12),
    controller=st.sampled_from(sorted(WRITERS)),
    name=st.text(max_size=80),
)
@example(turns=[0.0] * 12, controller="csv", name="INF")
def test_any_path(turns: list[float], controller: str, name: str) -> None:
    robot = arm("RRRRRR", limit=6.2)
    program = path_program(robot, np.reshape(turns, (2, 6)), name=name)
    files = export(program, controller)
    complaints = [c for c in LINTS[controller](files) if "provenance" not in c]  # from no plan
    assert complaints == []
    moves = [value for kind, value in PARSERS[controller](files) if kind == "move"]
    scale = 1.0 if controller in RADIANS else 180.0 / np.pi
    if controller == "ros" and len(moves) == 1:
        return  # twice the same point
    np.testing.assert_allclose(np.array(moves) / scale, program.targets, atol=np.radians(1e-4))


def test_a_krl_program_is_not_called_as_one_of_its_points() -> None:
    """In KRL a module, its points and the axes share one space of names, without case."""
    q = np.zeros((2, 6))
    q[1] = 0.1
    program = path_program(arm("RRRRRR"), q, name="x")
    point = f"x{program.target_names[1]}"
    for name, module in ((point, f"{point}_1"), ("A3", "A3_1")):
        with pytest.raises(InputError, match=f"'{module}' would be one"):
            export(program, "krl", Settings(name=name))
    files = export(program, "krl", Settings(name="a7"))
    assert sorted(files) == ["a7.dat", "a7.src"]
    assert "DEFDAT a7\n" in files["a7.dat"]


@settings(max_examples=40)
@given(
    limit=st.floats(0.5, 3.1),
    controller=st.sampled_from(sorted(WRITERS)),
    sign=st.sampled_from([1.0, -1.0]),
)
def test_rounding_never_leaves_the_limits(limit: float, controller: str, sign: float) -> None:
    robot = arm("RRRRRR", limit=limit)
    q = np.array([[limit] * 6, [-limit] * 6])
    signs = coupling(robot, signs={"J2": sign})
    files = export(path_program(robot, q, name="x"), controller, Settings(coupling=signs))
    moves = np.array([value for kind, value in PARSERS[controller](files) if kind == "move"])
    bound = limit if controller in RADIANS else np.degrees(limit)
    assert np.abs(moves).max() <= bound + 1e-9
    assert np.abs(moves).min() > bound - 2e-4


@pytest.mark.parametrize("controller", ["krl", "rapid", "fanuc", "csv", "ros"])
def test_coupling_is_applied_once(controller: str) -> None:
    robot = arm("RRRRRR")
    shown = coupling(robot, signs={"J1": -1}, offsets={"J2": 0.25}, couple={"J3": {"J2": -1}})
    q = np.array([[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]])
    files = export(path_program(robot, q, name="x"), controller, Settings(coupling=shown))
    ((_, values),) = PARSERS[controller](files)
    scale = 1.0 if controller in RADIANS else 180.0 / np.pi
    wanted = [-0.1, 0.45, 0.3 - 0.45, 0.4, 0.5, 0.6]
    np.testing.assert_allclose(np.array(values) / scale, wanted, atol=np.radians(1e-4))
    assert "converted for the controller" in "".join(files.values()).replace("\n", " ").replace(
        " ;", ""
    ) or controller in ("fanuc", "rapid")


ROD = "ABB arms with such a rod show J3"
ELEVATION = "FANUC arms show J3 as the elevation of the forearm"


@pytest.mark.parametrize(
    ("controller", "leader", "kinds", "words"),
    [
        ("rapid", "J3", "RRRRRR", ROD),
        ("rapid", "J3", "PRRRRRR", ""),  # there J3 is the second that turns
        ("rapid", "J2", "RRRRRR", ""),  # a cylinder that holds the upper arm
        ("rapid", "", "RRRRRR", ""),
        ("fanuc", "", "RRRRRR", ELEVATION),
        ("fanuc", "", "RR", ""),
        ("krl", "J3", "RRRRRR", ""),
    ],
)
def test_what_a_controller_may_show_otherwise_is_in_its_program(
    controller: str, leader: str, kinds: str, words: str
) -> None:
    robot = arm(kinds)
    if leader:
        rod = replace(robot.joints[-1], name="rod")
        robot = replace(robot, followers=(Follower(rod, 1, leader, -1.0, 0.0),))
    program = path_program(robot, np.zeros((1, len(kinds))), name="x")

    def said(settings: Settings) -> str:
        text = "".join(export(program, controller, settings).values())
        return " ".join(re.sub(r"(?m)^ *(\d+: )? *!| ;$", "", text).split())

    assert [w for w in (ROD, ELEVATION) if w in said(Settings())] == [words] * bool(words)
    settled = said(Settings(coupling(robot, signs={robot.joint_names[0]: -1})))
    assert ROD not in settled
    assert ELEVATION not in settled


def test_a_coupling_of_another_robot_is_refused() -> None:
    other = coupling(arm("RRR"))
    with pytest.raises(InputError, match="coupling is for joints"):
        export(path_program(arm("RRRRRR"), np.zeros((1, 6)), name="x"), "krl", Settings(other))


@pytest.mark.parametrize(
    ("kinds", "controller", "words"),
    [
        ("RRRRRRR", "krl", "7 joints in its arm"),
        ("RRRRRRR", "rapid", "7 joints in its arm"),
        ("RRRRRRR", "fanuc", "7 joints in its arm"),
        ("RRRRRRR", "urscript", "7 joints in its arm"),
        ("PRRRRRR", "urscript", "1 external axes"),
        ("RRRRR", "urscript", "6 turning ones"),
        ("RRRRRP", "urscript", "1 of them sliding"),
        ("PPPPRRRRRR", "fanuc", "4 external axes"),
        ("PPPPPPPRRRRRR", "krl", "7 external axes"),
        ("PPPPPPPRRRRRR", "rapid", "7 external axes"),
        ("PPPPPPP", "krl", "7 joints in its arm"),
    ],
)
def test_robots_that_a_controller_cannot_hold(kinds: str, controller: str, words: str) -> None:
    """And where they can go is said."""
    program = path_program(arm(kinds), np.zeros((1, len(kinds))), name="x")
    with pytest.raises(InputError, match=f"{words}.*; ros and csv take any robot$"):
        export(program, controller)
    assert all(export(program, other) for other in ("ros", "csv"))


@pytest.mark.parametrize(("controller", "hint"), [("krl", True), ("urscript", False)])
def test_external_axes_are_asked_for_where_there_can_be_any(controller: str, hint: bool) -> None:
    """Seven turning joints: which of them is outside is not clear, if one may be."""
    program = path_program(arm("RRRRRRR"), np.zeros((1, 7)), name="x")
    with pytest.raises(InputError) as error:
        export(program, controller)
    assert ("--external" in str(error.value)) == hint


def test_a_value_that_does_not_fit_is_named_with_its_size() -> None:
    """The largest of the column: a controller's format ends at a million."""
    q = np.zeros((3, 6))
    q[1, 2], q[2, 2] = 2e4, -3e4
    program = path_program(arm("RRRRRR", limit=4e4), q, name="x")
    with pytest.raises(InputError, match=r"'J3' reaches 1.71887e\+06 .* below 1e\+06"):
        export(program, "krl")


def test_external_axes_by_name() -> None:
    program = path_program(arm("RRRRRRR"), np.arange(7)[None] / 10.0, name="table last")
    outside = Settings(external=("J7",))
    for controller in ("krl", "rapid", "fanuc", "csv"):
        check_path(program, controller, outside, [0, 1, 2, 3, 4, 5, 6])
    outside = Settings(external=("J1",))
    for controller in ("krl", "rapid", "fanuc", "csv"):
        check_path(program, controller, outside, [1, 2, 3, 4, 5, 6, 0])
    with pytest.raises(InputError, match="no joint 'J9'"):
        export(program, "krl", Settings(external=("J9",)))
    with pytest.raises(InputError, match="twice"):
        export(program, "krl", Settings(external=("J7", "J7")))


def check_path(program: RobotProgram, controller: str, given: Settings, order: list[int]) -> None:
    ((_, values),) = PARSERS[controller](export(program, controller, given))
    np.testing.assert_allclose(values, np.degrees(program.targets[0, order]), atol=1e-4)


def test_scara_and_gantry_keep_their_sliding_joints_in_the_arm() -> None:
    for kinds in ("RRPR", "PRRR", "PPPRRR"):
        program = path_program(arm(kinds), np.full((1, len(kinds)), 0.25), name="x")
        ((_, values),) = PARSERS["krl"](export(program, "krl"))
        wanted = [250.0 if kind == "P" else np.degrees(0.25) for kind in kinds]
        np.testing.assert_allclose(values, wanted, atol=1e-4)
        dat = next(text for name, text in export(program, "krl").items() if name.endswith(".dat"))
        assert "E1 " not in dat


def test_values_that_do_not_fit_the_format() -> None:
    joints = [Joint(f"J{i}", np.eye(4), np.array([0, 0, 1.0]), True) for i in range(2)]
    program = path_program(Robot("long", tuple(joints)), np.array([[0.0, 100.0]]), name="x")
    with pytest.raises(InputError, match="values below 100000"):
        export(program, "fanuc")
    export(program, "krl")
    with pytest.raises(InputError, match="values below"):
        export(path_program(Robot("long", tuple(joints)), np.array([[0.0, 1e4]]), name="x"), "krl")


def test_no_such_controller() -> None:
    with pytest.raises(InputError, match="there are krl, rapid, fanuc"):
        export(kr270_program(), "karel")


def _broken(files: dict[str, str], old: str, new: str) -> dict[str, str]:
    assert any(old in text for text in files.values()), old
    return {name: text.replace(old, new, 1) for name, text in files.items()}


BREAKS: list[tuple[str, str, str]] = [
    ("krl", "\nEND\n", "\n"),
    ("krl", "PTP XP1", "PTP XP9"),
    ("krl", "HALT", "HALTÄ"),
    ("krl", "DECL E6AXIS XP1", "DECL E6AXIS WHILE"),
    ("krl", "XP2=", "XP2_with_a_name_too_long_for_KRL="),
    ("krl", "ENDDAT", ""),
    ("krl", ";ENDFOLD", ";"),
    ("krl", "NO load", "NO load" + "d" * 80),
    ("krl", "DEFDAT KR_270_milling", "DEFDAT other"),
    ("krl", ":IN)", ":OUT)"),
    ("krl", "{A1 ", "{A7 "),
    ("krl", "A1 0.0000", "A1 nan"),
    ("krl", "sha256", "hash"),
    ("rapid", "ENDPROC", ""),
    ("rapid", "ENDMODULE", ""),
    ("rapid", "MoveAbsJ jP1", "MoveAbsJ jP9"),
    ("rapid", "fine,tool0;", "fine,tool0"),
    ("rapid", "9E9]", "9E9,9E9]"),
    ("rapid", "NO load", "NO load" + "d" * 80),
    ("rapid", "MODULE KR_270", "MODULE 270"),
    ("rapid", "jointtarget jP2:", "jointtarget jP1:"),
    ("fanuc", "/POS", ""),
    ("fanuc", "P[2]{", "P[7]{"),
    ("fanuc", "J P[1]", "J P[44]"),
    ("fanuc", "LINE_COUNT\t= ", "LINE_COUNT\t= 9"),
    ("fanuc", "/PROG  KR_270", "/PROG  kr_270"),
    ("fanuc", "CREATE", "CREATED"),
    ("fanuc", "  !Robot", "  !a ; J P[1] 100% FINE ; b"),
    ("rapid", "LOCAL CONST", "CONST"),
    ("urscript", "\n  # Robot", "\n# Robot"),
    ("urscript", "def ", "# made by\ndef "),
    ("fanuc", "MESSAGE[", "MESSAGE[a very much longer text "),
    ("fanuc", "!Robot", "!Robot with a remark that is too long"),
    ("fanuc", "   3:", "   4:"),
    ("fanuc", "J1=", "J1= 1000"),
    ("fanuc", "};", "}"),
    ("urscript", "\nend\n", "\n"),
    ("urscript", "movej([", "movej([0.0, "),
    ("urscript", "movej([-0", "movej([-50"),
    ("urscript", "def KR", "def 2KR"),
    ("ros", "sec: 0", "sec: -1"),
    ("ros", '"A1"', '"B1"'),
    ("csv", "move,", "move,,"),
    ("csv", "SAFETY", "safety"),
]


@pytest.mark.parametrize(("controller", "old", "new"), BREAKS)
def test_lints_reject_broken_programs(controller: str, old: str, new: str) -> None:
    files = export(kr270_program(), controller)
    assert LINTS[controller](files) == []
    assert LINTS[controller](_broken(files, old, new)) != []


def test_the_comparison_notices_a_changed_program() -> None:
    """Negative control of `check`: order, repeats and a hundredth of a degree."""
    program = kr270_program()
    wanted = expected(program, program.robot.shown_scale, list(range(6)))
    files = export(program, "krl")
    for old, new in [("A2 -50.7922", "A2 -50.7932"), ("PTP XP1", "PTP XP2"), ("2500", "2600")]:
        found = PARSERS["krl"](_broken(files, old, new))
        with pytest.raises(AssertionError):
            compare(found, wanted, DEGREES)
    found: list[Any] = PARSERS["krl"](files)
    with pytest.raises(AssertionError):
        compare(found[8:], wanted, DEGREES)
