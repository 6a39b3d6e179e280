"""Nothing in a program but what was planned: hostile names, one name for one program, pages."""

from __future__ import annotations

import itertools
import re
import time
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.programs.campaign_program import campaign_program
from elastocal.programs.robot_program import Move, Provenance, RobotProgram, path_program
from elastocal.programs.writers import WRITERS, Settings, export, start, too_long
from elastocal.programs.writers.names import DEVICES, identifier
from elastocal.robot.chain import Robot
from tests.programs.writers.campaigns import DIGEST, arm, study_for
from tests.programs.writers.lints import LINTS
from tests.programs.writers.parsers import PARSERS, Event

SIGNS = ["\n", "\r", '"', ";", "'", "%", "]", "[", "{", "}", "\u2028", "\\", "#", "!", "\0", "\x1b",
         "\ud800", "\x85", "|", ",", ":", "=", "---", "\u202e"]  # fmt: skip
HOSTILE = [
    "a{0}movej([0,0,0,0,0,0], a=10, v=3){0}#", "a {0} J P[9] 100% FINE {0} b",
    "{0}PTP {{A1 90}}{0}",
    'x{0}");HALT{0}', "{0}MoveAbsJ [[9]]\\NoEOffs,v1000,fine,tool0;", "{0}END{0}", "{0}/END{0}",
    "{0}- positions: [9]{0}", "{0}FOLD{0}", "{0}",
]  # fmt: skip
FIELDS = ["name", "study", "robot", "joint", "marker", "notes", "purpose", "made_by"]


def campaign() -> RobotProgram:
    study = study_for(arm("RRRRRR"))
    q = np.array([[0.1, 0.2, 0.3, -0.4, 0.5, -0.6]])
    wrench = np.array([[0.0, 0, -100, 0, 0, 0]])
    return campaign_program(study, LoadCases(q, wrench), np.array([1]), digest=DIGEST)


BASE = campaign()


def named(field: str, name: str) -> RobotProgram:
    """A campaign with a name in a field, made past all readers."""
    robot, source = BASE.robot, BASE.provenance
    if field == "robot":
        return replace(BASE, robot=replace(robot, name=name))
    if field == "joint":
        joints = (replace(robot.joints[0], name=name), *robot.joints[1:])
        return replace(BASE, robot=Robot("arm", joints))
    if field == "marker":
        steps = [
            replace(step, text=step.text.replace("M1", name)) if hasattr(step, "text") else step
            for step in BASE.steps
        ]
        return replace(BASE, steps=tuple(steps))
    if field in ("study", "made_by"):
        return replace(BASE, provenance=replace(source, **{field: name}))
    return replace(BASE, **{field: (name,) if field == "notes" else name})  # type: ignore[arg-type]


def deeds(events: list[Event]) -> list[Event]:
    """What a controller does, whatever is read meanwhile."""
    return [(kind, None if kind == "stop" else value) for kind, value in events]


PLAIN = {c: deeds(PARSERS[c](export(named("name", "plain"), c))) for c in WRITERS}


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("controller", WRITERS)
def test_a_name_is_no_instruction(controller: str, field: str) -> None:
    few = [*itertools.product(SIGNS, HOSTILE[:2]), *itertools.product(SIGNS[:4], HOSTILE)]
    for sign, shape in few:
        if (controller, field, sign) == ("ros", "joint", "\ud800"):
            continue  # half a sign: YAML cannot say it, and no name that is read has it
        files = export(named(field, shape.format(sign)), controller)
        assert "".join(files.values()).isascii()
        assert deeds(PARSERS[controller](files)) == PLAIN[controller], (sign, shape)
        assert [c for c in LINTS[controller](files) if "minus zero" not in c] == [], (sign, shape)


@settings(max_examples=100)
@given(st.text(max_size=300), st.sampled_from(FIELDS), st.sampled_from(sorted(WRITERS)))
def test_no_text_is_an_instruction(text: str, field: str, controller: str) -> None:
    files = export(named(field, text), controller)
    assert "".join(files.values()).isascii()
    assert deeds(PARSERS[controller](files)) == PLAIN[controller]


def test_joint_names_of_ros_come_back_as_they_are() -> None:
    import yaml

    for name in ("a\nb", "\u2028", "関節", "🦾 1", 'q"\\', "'", "a: {b}"):
        (text,) = export(named("joint", name), "ros").values()
        documents = [d for d in yaml.safe_load_all(text) if d]
        assert {d["joint_names"][0] for d in documents} == {name}


def test_labels_of_targets_are_letters_and_digits() -> None:
    good = {"name": "x", "purpose": "x", "robot": arm("RR"), "steps": (Move(0),)}
    for labels in (("a\nb", "P2"), ("P1", "P1"), ("P1", ""), ("P1", "P" * 13), ("P1", "É")):
        with pytest.raises(InputError, match="letters and digits"):
            RobotProgram(targets=np.zeros((2, 2)), target_names=labels, **good)  # type: ignore[arg-type]


def test_texts_that_no_program_holds_are_refused() -> None:
    with pytest.raises(InputError, match=r"takes 9999 lines, STUDY_\w+ would have"):
        export(named("notes", "word " * 100_000), "fanuc")
    export(named("notes", "word " * 100_000), "krl")


def test_cells_are_no_formulas() -> None:
    (text,) = export(named("joint", '=HYPERLINK("http://x")'), "csv").values()
    header = next(line for line in text.splitlines() if not line.startswith("#"))
    assert "'=HYPERLINK" in header


def program(name: str, **source: Any) -> RobotProgram:
    q = np.array([[0.0, -1, 1, 0, 0.5, 0]])
    return path_program(arm("RRRRRR"), q, name=name, provenance=Provenance(**source))


ALIKE = [
    "Cell 7 roughing of the left flank", "Cell 7 roughing of the left rib", "corrected roughing",
    "corrected finishing", "path 1", "PATH-1", "path_1", "Path_1", "PATH_1", "path  1", "path 1 ",
    "Cell 7 roughing of the left flank, side A", "Cell 7 roughing of the left flank, side B",
    "Süd", "Sud", "sud", "SUD", "関節", "节", "", "x", "X", "a.b", "a b", "a-b", "CON", "con",
]  # fmt: skip


@pytest.mark.parametrize("controller", WRITERS)
def test_two_programs_never_have_one_name(controller: str) -> None:
    sources: list[dict[str, Any]] = [
        {}, {"digest": DIGEST}, {"digest": DIGEST[::-1]}, {"digest": DIGEST, "of": "path"},
        {"digest": DIGEST, "beside": (("model", DIGEST),)},
    ]  # fmt: skip
    found = [
        next(iter(export(program(name, **source), controller))).lower()
        for name, source in itertools.product(ALIKE, sources)
    ]
    assert len(set(found)) == len(found)
    again = next(iter(export(program(ALIKE[0]), controller)))
    assert again.lower() == found[0]


@pytest.mark.parametrize("controller", WRITERS)
@pytest.mark.parametrize("device", [*sorted(DEVICES), "con", "Lpt1"])
def test_no_program_is_called_as_a_device_of_windows(controller: str, device: str) -> None:
    for name in export(program(device), controller):
        assert name.split(".")[0].upper() not in DEVICES
    with pytest.raises(InputError, match="not a program name for"):
        export(program("x"), controller, Settings(name=device))


def test_names_that_are_given_stay_or_are_refused() -> None:
    for controller in WRITERS:
        name = "CELL_3" if controller == "fanuc" else "cell_3"
        files = export(program("x", digest=DIGEST), controller, Settings(name=name))
        assert {file.split(".")[0] for file in files} == {name}
    for controller, name, would_be in (
        ("krl", "cell 3", "cell_3"), ("krl", "7axes", "P_7axes"), ("krl", "IR_STOPM", "IR_STOPM_1"),
        ("urscript", "set_tcp", "set_tcp_1"), ("urscript", "movej", "movej_1"),
        ("rapid", "tool0", "tool0_1"), ("rapid", "v500", "v500_1"), ("fanuc", "cell", "CELL"),
        ("fanuc", "com1", "COM1_1"), ("fanuc", "A" * 17, "A" * 16),
        ("csv", "plan-1", "plan_1"), ("ros", "é", "e"),
    ):  # fmt: skip
        words = f"not a program name for {controller}, '{would_be}' would be one"
        with pytest.raises(InputError, match=words):
            export(program("x"), controller, Settings(name=name))


def test_reserved_words_get_the_first_number_that_is_free() -> None:
    assert identifier("move", 24, ["MOVE"]) == "move_1"
    assert identifier("move", 24, ["Move", "move_1"]) == "move_2"
    assert identifier("abcdefgh", 8, ["ABCDEFGH"]) == "abcdef_1"
    assert identifier("7 axes", 24) == "P_7_axes"


def long_path(count: int) -> RobotProgram:
    rng = np.random.default_rng(0)
    q = rng.uniform(-3.0, 3.0, (count, 6))
    source = Provenance("cell", DIGEST, of="path", beside=(("model", DIGEST[::-1]),))
    return path_program(arm("RRRRRR"), q, name="a long path", provenance=source)


@pytest.mark.parametrize("controller", WRITERS)
def test_long_paths_are_paged(controller: str) -> None:
    count = 1100 if controller == "ros" else 2345  # to parse YAML takes long
    path = long_path(count)
    files = export(path, controller)
    assert LINTS[controller](files) == []
    events = PARSERS[controller](files)
    scale = 1.0 if controller in ("urscript", "ros") else 180.0 / np.pi
    assert [kind for kind, _ in events] == ["move"] * count
    found = np.array([value for _, value in events])
    digit = {"csv": 1e-6, "urscript": 1e-8, "ros": 1e-9}.get(controller, 1e-4)
    np.testing.assert_allclose(found, scale * path.targets, rtol=0, atol=0.5001 * digit)
    pages = {"krl": 3, "rapid": 2, "fanuc": 5, "urscript": 3}.get(controller, 1)
    main = {"krl": 2, "rapid": 1, "fanuc": 1}.get(controller, 0) if pages > 1 else 0
    assert len(files) == pages + main
    assert all(len(text.splitlines()) <= 10_500 for text in files.values()) or controller in (
        "csv", "ros",
    )  # fmt: skip
    if pages > 1:
        first = next(iter(files.values()))
        first = " ".join(re.sub(r" ;|\d+:|[;!#]", " ", first).split())
        assert re.search(rf"its {pages} pages|Script 1 of", first)
    named = export(path, controller, Settings(name="A_PATH"))
    assert LINTS[controller](named) == []
    assert {len(file.split(".")[0]) for file in named} <= {6, 10}


@pytest.mark.parametrize("controller", ["krl", "rapid", "fanuc", "urscript"])
def test_long_campaigns_are_paged(controller: str) -> None:
    robot = arm("RRRRRR")
    rng = np.random.default_rng(1)
    q = rng.uniform(-2.0, 2.0, (40, 6))
    wrench = np.tile([0.0, 0, -100, 0, 0, 0], (40, 1))
    study = study_for(robot)
    repeats = np.full(40, 30)
    campaign = campaign_program(study, LoadCases(q, wrench), repeats, digest=DIGEST)
    files = export(campaign, controller)
    assert LINTS[controller](files) == []
    events = PARSERS[controller](files)
    moves = [value for kind, value in events if kind == "move"]
    targets = [step.target for step in campaign.steps if isinstance(step, Move)]
    scale = 1.0 if controller in ("urscript", "ros") else 180.0 / np.pi
    np.testing.assert_allclose(moves, scale * campaign.targets[targets], rtol=0, atol=1e-4)
    assert len(files) > 2


@pytest.mark.parametrize("controller", WRITERS)
def test_time_and_size_are_those_of_the_points(controller: str) -> None:
    """Four times the points take four times as long, not sixteen times: user time, best of two."""
    took = []
    for count in (2500, 10_000):
        path, best = long_path(count), np.inf
        for _ in range(2):
            before = time.process_time()
            export(path, controller)
            best = min(best, time.process_time() - before)
        took.append(best)
    assert took[1] < 8.0 * took[0] + 0.05


@pytest.mark.parametrize("controller", WRITERS)
def test_how_it_is_started_is_said(controller: str) -> None:
    files = export(long_path(3), controller)
    text = " ".join(" ".join(files.values()).split())
    text = re.sub(r" ;(?: \d+: !)?| !| #| ; ", " ", text)
    assert "Start: " in text
    said = start(controller, Settings(), next(iter(files)).split(".")[0])
    assert said.startswith("Start: ")
    for word in said.split()[:3]:
        assert word in text
    assert too_long(controller, files) == ""
    large = too_long(controller, {"a": "x" * 3_000_000, "b": "y"})
    assert large.startswith("The program has 3.0 MB in 2 files")


@pytest.mark.parametrize("controller", WRITERS)
def test_header_words_are_true(controller: str) -> None:
    files = export(long_path(3), controller, Settings())
    text = "".join(files.values())
    assert f"path sha256 {DIGEST[:16]}" in text
    assert f"model sha256 {DIGEST[::-1][:16]}" in text
    assert "plan sha256" not in text
    assert "empty calibration tool" not in " ".join(text.split())
    from elastocal.robot.controller_axes import uncoupled

    same = export(long_path(3), controller, Settings(coupling=uncoupled(arm("RRRRRR"))))
    assert "converted" not in "".join(same.values())


def test_scripts_for_a_script_node_call_their_function() -> None:
    for path in (long_path(3), long_path(1500)):
        for name, text in export(path, "urscript", Settings(script_node=True)).items():
            lines = text.splitlines()
            stem = name.removesuffix(".script")
            assert (lines[0], lines[-2:]) == (f"def {stem}():", ["end", f"{stem}()"])
        for name, text in export(path, "urscript").items():
            lines = text.splitlines()
            assert lines[0] == f"def {name.removesuffix('.script')}():"
            assert lines[-1] == "end"
            assert all(line[0] == " " for line in lines[1:-1])
    with pytest.raises(InputError, match="a Script node takes URScript, not krl"):
        export(long_path(3), "krl", Settings(script_node=True))


def test_modules_stand_side_by_side_in_one_task() -> None:
    """What two modules of RAPID both have, only they know."""
    text = "".join(export(named("name", "a"), "rapid").values())
    declared = re.findall(r"^  (\w+) (?:CONST|VAR|PERS)?", text, re.M)
    assert set(declared) <= {"LOCAL", "PROC", "ENDPROC"}
    routines = set()
    for name in ("a", "b"):
        text = "".join(export(named("name", name), "rapid").values())
        routines |= set(re.findall(r"PROC (\w+)\(\)", text))
    assert len(routines) == 2
