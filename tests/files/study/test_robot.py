"""The robot of a study: from a file or table; controller and check poses; what is wrong."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from elastocal.cli import app
from elastocal.errors import InputError, StudyError
from elastocal.files.study.study_file import parse_study, read_study
from elastocal.planning.study_check import check
from elastocal.robot.posture import Posture
from tests.robot.sources.oracle import ROOT

EXAMPLES = sorted((ROOT / "examples" / "robots").glob("*/study.yaml"))
FOLDER = ROOT / "examples" / "robots" / "kr270"
GOOD = (FOLDER / "study.yaml").read_text("utf-8")
HEAD = "robot: {urdf: kr270.urdf}"
TAIL = """
identify: [A2]
tools: {t: {tcp_mm: [100, 0, 0]}}
test_poses: [{tool: t, q_deg: [0, -60], force_N: [0, 0, 9]}]
experiments: {tool: t, force_N: [0, 0, -9], count: 3}
instrument: {sigma_mm: 0.1}
"""
TABLE = """elastocal: 1
robot:
  convention: {}
  dh:
    - {{joint: A1, d_mm: 500, a_mm: 100, alpha_deg: 90, sign: -1, mass_kg: 9,
       center_mm: [10, 20, 30]}}
    - {{joint: A2, a_mm: 700, alpha_deg: 30, mass_kg: 5}}
"""

# what is edited: (old, new); what must be in the sentence
WRONG: dict[str, tuple[str, str, list[str]]] = {
    "no such file": (HEAD, "robot: {urdf: kr999.urdf}", ["line 5", "'kr999.urdf'", "folder of st"]),
    "a folder": (HEAD, "robot: {urdf: ../kr270}", ["line 5", "cannot be read"]),
    "not a urdf": (HEAD, "robot: {urdf: study.yaml}", ["line 5", "study.yaml, line 1", "XML"]),
    "bare file name": (HEAD, "robot: kr270.urdf", ["line 5", "{urdf: kr270.urdf}"]),
    "unknown key": (HEAD, "robot: {urdf: kr270.urdf, tpi: x}", ["line 5", "'tpi'", "'tip'"]),
    "file and table": (
        HEAD, "robot: {urdf: a.urdf, dh: []}", ["line 5", "key 'dh'; expected one of urdf"]),
    "neither": (HEAD, "robot: {name: arm}", ["'convention' is missing"]),
    "a list": (HEAD, "robot: [kr270.urdf]", ["line 5", "expected a name"]),
    "unknown tip": (HEAD, "robot: {urdf: kr270.urdf, tip: flang}", ["line 5", "mean 'flange'"]),
    "unknown base": (HEAD, "robot: {urdf: kr270.urdf, base: rail}", ["line 5", "'rail'", "'base'"]),
    "tip before base": (
        HEAD, "robot: {urdf: kr270.urdf, base: link_3, tip: link_1}", ["does not hang on"]),
    "limits of nobody": (
        HEAD, "robot: {urdf: kr270.urdf, limits_deg: {J9: [0, 1]}}", ["line 5", "'J9'", "A1, A2"]),
    "limits in another unit": (
        HEAD, "robot: {urdf: kr270.urdf, limits_mm: {A1: [0, 1]}}", ["line 5", "limits_deg"]),
    "limits twice": (
        HEAD, "robot: {urdf: kr270.urdf, limits_mm: {A1: [0, 1]}, limits_deg: {A1: [0, 1]}}",
        ["line 5", "degrees and mm"]),
    "limits turned round": (
        HEAD, "robot: {urdf: kr270.urdf, limits_deg: {A1: [9, 1]}}", ["line 5", "below the upper"]),
    "limits without a unit": (
        HEAD, "robot: {urdf: kr270.urdf, limits: {A1: [0, 1]}}", ["no unit", "'limits_deg'"]),
    "no such package": (
        HEAD, "robot: {urdf: kr270.urdf, packages: {arm: ../nowhere}}", ["'arm'", "not exist"]),
    "no name of a file": (HEAD, f"robot: {{urdf: {'a' * 3000}}}", ["line 5", "is not there"]),
    "arguments of a urdf": (
        HEAD, "robot: {urdf: kr270.urdf, arguments: {a: 1}}", ["line 5", "for xacro files"]),
    "arguments without names": (
        HEAD, "robot: {urdf: kr270.urdf, arguments: [a]}", ["line 5", "robot.arguments"]),
    "an argument of several": (
        HEAD, "robot: {urdf: kr270.urdf, arguments: {a: [1]}}", ["line 5", "text or a number"]),
    "sign of two": (HEAD, HEAD + "\ncontroller: {signs: {A1: 2}}", ["line 6", "1 or -1", "2"]),
    "sign of nobody": (HEAD, HEAD + "\ncontroller: {signs: {J1: -1}}", ["line 6", "'J1'"]),
    "unknown preset": (HEAD, HEAD + "\ncontroller: {preset: abb}", ["line 6", "'abb'", "fanuc"]),
    "offset without a unit": (
        HEAD, HEAD + "\ncontroller: {offsets: {A1: 1}}", ["line 6", "'offsets_deg'"]),
    "offset in another unit": (
        HEAD, HEAD + "\ncontroller: {offsets_mm: {A1: 1}}", ["line 6", "under offsets_deg"]),
    "coupled to itself": (
        HEAD, HEAD + "\ncontroller: {couple: {A1: {A1: 1}}}", ["line 6", "coupled to itself"]),
    "not invertible": (
        HEAD, HEAD + "\ncontroller: {couple: {A2: {A3: 1}, A3: {A2: 1}}}", ["cannot be inverted"]),
    "one check pose": (
        HEAD, HEAD + "\ncheck_poses: [{q_deg: [0, -9, 0, 0, 0, 0], flange_mm: [1, 2, 3]}]",
        ["line 6", "at least two", "found 1"]),
    "check pose without a position": (
        "tool: milling, tcp_mm: [2436.3, 0.2, 1944.6]", "tool: milling", ["up: give either"]),
    "check pose without its tool": ("tool: milling, tcp_mm: [2436", "tcp_mm: [2436", ["its tool"]),
    "flange of a tool": (
        "tool: milling, tcp_mm: [2436", "tool: milling, flange_mm: [2436", ["instead of"]),
    "check pose with a wrong unit": ("tcp_mm: [2436", "tcp_m: [2436", ["'tcp_mm'"]),
    "check pose with five joints": ("[0, -90, 90, 0, 0, 0]", "[0, -90, 90, 0, 0]", ["6 angles"]),
}  # fmt: skip


@pytest.mark.parametrize("what", WRONG)
def test_a_wrong_robot_gets_its_sentence(what: str) -> None:
    old, new, expected = WRONG[what]
    text = GOOD if "check_poses" not in new else GOOD[: GOOD.index("check_poses")] + (
        GOOD[GOOD.index("tools:") :])  # fmt: skip
    assert text.count(old) == 1, old
    with pytest.raises(StudyError) as caught:
        parse_study(text.replace(old, new), FOLDER / "study.yaml")
    message = str(caught.value)
    assert message.startswith(f"{FOLDER / 'study.yaml'}")
    assert "\n" not in message
    for words in expected:
        assert words in message


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_every_example_is_a_sound_study(path: Path) -> None:
    found = check(read_study(path))
    assert found.problem is None
    assert found.poses is None or found.poses.fits


def test_there_are_six_examples() -> None:
    assert len(EXAMPLES) >= 6


def test_limits_of_the_study_replace_those_of_the_file() -> None:
    text = GOOD.replace(HEAD, "robot: {urdf: kr270.urdf, limits_deg: {A4: [-180, 170]}}")
    robot = parse_study(text, FOLDER / "study.yaml").robot
    assert np.degrees([robot.lower[3], robot.upper[3]]) == pytest.approx([-180, 170])


def test_arguments_are_text_numbers_or_truths(tmp_path: Path) -> None:
    given = "arguments: {name: arm, empty: '', long: 0.6, fixed: true}"
    (tmp_path / "arm.xacro").write_text(
        '<robot name="$(arg name)$(arg empty)-$(arg long)-$(arg fixed)"><link name="base"/>'
        '<link name="tip"/><joint name="J" type="continuous"><parent link="base"/>'
        '<child link="tip"/><axis xyz="0 1 0"/></joint></robot>'
    )
    text = f"elastocal: 1\nrobot: {{urdf: arm.xacro, {given}}}" + TAIL.replace("[A2]", "[J]")
    study = parse_study(text.replace("[0, -60]", "[0]"), tmp_path / "study.yaml")
    assert study.robot.name == "arm-0.6-true"


def test_the_reader_remarks_on_what_it_leaves_out(tmp_path: Path) -> None:
    urdf = (FOLDER / "kr270.urdf").read_text()
    grip = (
        '<link name="finger"/><joint name="grip" type="continuous"><parent link="flange"/>'
        '<child link="finger"/></joint></robot>'
    )
    (tmp_path / "kr270.urdf").write_text(urdf.replace("</robot>", grip))
    text = GOOD.replace(HEAD, "robot: {urdf: kr270.urdf, tip: flange}")
    study = parse_study(text, tmp_path / "study.yaml")
    assert "grip: not between 'base_link' and 'flange', held at zero" in study.robot.remarks


@pytest.mark.parametrize("convention", ["modified", "classic"])
def test_masses_of_a_table_are_in_the_frames_of_its_rows(convention: str) -> None:
    robot = parse_study(TABLE.format(convention) + TAIL, Path("table.yaml")).robot
    q = np.array([[0.4, -0.7]])
    posture = Posture(robot, q)
    assert [(m.body, m.mass) for m in robot.masses] == [(1, 9.0), (2, 5.0)]
    # The frame of the last row is the flange.
    assert posture.point(robot.masses[1].center, 2) == pytest.approx(posture.point(np.zeros(3)))
    turn, lift, shift = -0.4, np.pi / 2, np.array([0.1, 0.0, 0.0])
    about_z = np.array(
        [[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]
    )
    about_x = np.array(
        [[1, 0, 0], [0, np.cos(lift), -np.sin(lift)], [0, np.sin(lift), np.cos(lift)]]
    )
    up, own = np.array([0.0, 0.0, 0.5]), np.array([0.01, 0.02, 0.03])
    if convention == "classic":
        expected = about_z @ (up + shift + about_x @ own)
    else:
        expected = shift + about_x @ (about_z @ own + up)
    assert posture.point(robot.masses[0].center, 1)[:, 0] == pytest.approx(expected)


def test_a_center_needs_a_mass() -> None:
    text = TABLE.replace(", mass_kg: 9", "").format("classic") + TAIL
    with pytest.raises(StudyError, match="line 5: joint 'A1': center_mm needs mass_kg"):
        parse_study(text, Path("table.yaml"))


def test_a_plan_finds_the_robot_beside_it_or_says_where_it_looked(tmp_path: Path) -> None:
    document = {"elastocal": 1, "kind": "plan", "study": {"text": GOOD}, "load_cases": []}
    plan = tmp_path / "plan.json"
    plan.write_text(json.dumps(document))
    runner = CliRunner()
    lost = runner.invoke(app, ["report", str(plan)])
    assert lost.exit_code == 2
    assert "'kr270.urdf' is not there; it is looked for in" in lost.output
    assert "name the study with --study" in lost.output
    (tmp_path / "kr270.urdf").write_text((FOLDER / "kr270.urdf").read_text())
    found = runner.invoke(app, ["report", str(plan)])
    assert "at least one load case" in found.output
    document["study"]["robot_sha256"] = "0" * 64  # type: ignore[index]
    plan.write_text(json.dumps(document))
    changed = runner.invoke(app, ["report", str(plan)])
    assert changed.exit_code == 2
    assert "the robot file of 'kr270' has changed since this plan was made" in changed.output


def test_check_says_which_mistake_it_is_and_fails(tmp_path: Path) -> None:
    (tmp_path / "kr270.urdf").write_text((FOLDER / "kr270.urdf").read_text())
    study = tmp_path / "study.yaml"
    study.write_text(GOOD.replace(HEAD, HEAD + "\ncontroller: {signs: {A3: -1}}"))
    done = CliRunner().invoke(app, ["check", str(study)])
    assert done.exit_code == 2
    assert "A3 counts the other way (signs: {A3: 1})" in done.output
    study.write_text(GOOD)
    done = CliRunner().invoke(app, ["check", "--json", str(study)])
    assert done.exit_code == 0
    assert json.loads(done.output)["check_poses"]["up"] == pytest.approx(0.54, abs=0.01)


def test_the_coupling_of_a_study_is_that_of_its_section() -> None:
    text = GOOD.replace(
        HEAD, HEAD + "\ncontroller: {preset: fanuc, offsets_deg: {A2: 90}, signs: {A1: -1}}"
    )
    study = parse_study(text, FOLDER / "study.yaml")
    shown = np.degrees(study.coupling.to_controller(np.radians([[10, 20, 30, 0, 0, 0]])))
    assert shown[0, :3] == pytest.approx([-10, 110, -140])
    assert parse_study(GOOD, FOLDER / "study.yaml").coupling.is_identity
    with pytest.raises(InputError):
        parse_study(text.replace("fanuc", "fanux"), FOLDER / "study.yaml")
