"""`export` of calibrated robots on the command line: read again, the same robot."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
import pytest

import elastocal as ec
from elastocal.arrays import Array
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.files.models.calibration_file import read_calibration
from elastocal.files.models.calibration_writing import write_calibration
from elastocal.robot.chain import transform
from elastocal.robot.rotations import from_zyx_angles
from tests.calibration.random_calibrated import calibrated_as
from tests.cli.test_commands import run
from tests.robot.sinks.drawn import drawn, ends_of
from tests.robot.sinks.test_dh import plain_flange, turned
from tests.robot.sinks.test_urdf import by_us, configurations, flange
from tests.robot.sources.oracle import OWN, UrdfOracle

EXAMPLES = OWN[0].parents[2]


class Case(NamedTuple):
    """A calibrated robot in a file, with its study."""

    calibrated: CalibratedRobot
    model: Path
    study: Path
    urdf: Path | None


def case_of(urdf: Path | None, folder: Path) -> Case:
    robot = ec.load_robot("kuka-kr270") if urdf is None else drawn(urdf)
    beside = EXAMPLES / "kr270" if urdf is None else urdf.parent
    calibrated = calibrated_as(np.random.default_rng(1), robot)
    write_calibration(calibrated, folder / "model.json")
    return Case(calibrated, folder / "model.json", beside / "study.yaml", urdf)


@pytest.fixture(params=[*OWN, None], ids=lambda urdf: urdf.stem if urdf else "built in")
def case(request: pytest.FixtureRequest, tmp_path: Path) -> Case:
    return case_of(request.param, tmp_path)


@pytest.fixture
def kr270(tmp_path: Path) -> Case:
    return case_of(None, tmp_path)


def export(case: Case, to: str, *more: object) -> Path:
    done = run(
        "export", case.model, "--to", to, "--study", case.study, "-o", case.model.parent, *more
    )
    assert done.exit_code == 0, done.stderr
    return Path(done.stdout.replace("\n", "").rpartition("wrote ")[2])


def test_a_urdf_is_the_calibrated_robot(case: Case) -> None:
    path = export(case, "urdf")
    text = path.read_text("utf-8")
    robot = case.calibrated.robot
    links = [link.attrib["name"] for link in ElementTree.fromstring(text).iter("link")]
    ends = {"base": links[0], "tip": "flange"} if case.urdf is None else ends_of(case.urdf)
    base = ends.get("base", links[0])
    tip = "calibrated_flange" if "calibrated_flange" in links else ends.get("tip", links[-1])
    again, theirs = by_us(text, base, tip), UrdfOracle(path, base, tip)
    for q in configurations(robot, np.random.default_rng(2)):
        assert np.abs(flange(again, q) - flange(robot, q)).max() < 1e-9
        if not robot.followers:
            assert np.abs(theirs.forward(again, q) - plain_flange(robot, q)).max() < 1e-9


def test_its_extension_says_what_bends(kr270: Case) -> None:
    root = ElementTree.fromstring(export(kr270, "urdf").read_text("utf-8"))
    (extension,) = root.iter("elastocal")
    model = kr270.calibrated.compliances
    found = {e.attrib["joint"]: e.attrib for e in extension.iter("compliance")}
    assert list(found) == list(model.names)
    for i, entry in enumerate(found.values()):
        assert float(entry["value"]) == model.compliance[i]
        assert entry["unit"] == "rad/(N.m)"
    (base,) = extension.iter("base")
    shift = np.array(base.attrib["xyz"].split(), dtype=float)
    assert shift == pytest.approx(kr270.calibrated.state.base[0, :3, 3], abs=1e-15)
    markers = [np.array(e.attrib["xyz"].split(), float) for e in extension.iter("reflector")]
    assert np.array(markers) == pytest.approx(kr270.calibrated.state.markers[0], abs=1e-15)


def table_in(text: str) -> tuple[list[dict[str, str]], dict[str, Array]]:
    """Rows, and the frames beside them, read by the words of the head."""
    frames = {"base": np.eye(4), "flange": np.eye(4)}
    for line in text.splitlines():
        for what in frames:
            if line.startswith(f"# {what}, "):
                words = line.partition(": ")[2].split(" [")[0].split()
                values = dict(zip(words[::2], map(float, words[1::2]), strict=True))
                angles = np.radians([[values[name] for name in "ABC"]])
                shift = np.array([values[name] for name in "XYZ"]) / 1e3
                frames[what] = transform(from_zyx_angles(angles)[0], shift)
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return list(csv.DictReader(lines)), frames


@pytest.mark.parametrize("to", ["dh", "mdh"])
def test_a_table_is_the_calibrated_robot(case: Case, to: str) -> None:
    rows, frames = table_in(export(case, to).read_text("utf-8"))
    robot = case.calibrated.robot
    for q in configurations(robot, np.random.default_rng(3)):
        T = frames["base"]
        for row, value in zip(rows, q, strict=True):
            way = float(row["sign"]) * value
            slides = row["type"] == "prismatic"
            theta = np.radians(float(row["theta [deg]"])) + (0.0 if slides else way)
            d = float(row["d [mm]"]) / 1e3 + (way if slides else 0.0)
            about_z = transform(turned(2, theta), (0, 0, d))
            alpha, beta = (
                np.radians(float(row.get(f"{name} [deg]", "0"))) for name in ("alpha", "beta")
            )
            about_x = transform(
                turned(0, alpha) @ turned(1, beta), (float(row["a [mm]"]) / 1e3, 0, 0)
            )
            T = T @ (about_x @ about_z if to == "mdh" else about_z @ about_x)
        assert np.abs(T @ frames["flange"] - plain_flange(robot, q)).max() < 1e-9


def test_json_has_everything(kr270: Case, tmp_path: Path) -> None:
    document = json.loads(export(kr270, "json").read_text("utf-8"))
    T, q = np.eye(4), np.array([0.1, -1.0, 1.2, 0.3, -0.4, 0.5])
    for joint, value in zip(document["joints"], q, strict=True):
        T = T @ np.array(joint["T_parent_joint"])
        axis = np.array(joint["axis"])
        T = T @ transform(rotation_about(axis, value))
    T = T @ np.array(document["T_tip_flange"])
    assert np.abs(T - plain_flange(kr270.calibrated.robot, q)).max() < 1e-12
    assert len(document["dh"]["modified"]["rows"]) == 6
    inner = tmp_path / "inner.json"
    inner.write_text(json.dumps(document["calibration"]), "utf-8")
    again = read_calibration(inner, kr270.calibrated.model.robot)
    assert np.array_equal(again.covariance, kr270.calibrated.covariance)


def rotation_about(axis: Array, angle: float) -> Array:
    """(3, 3) by Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def values_in(text: str) -> dict[tuple[str, str, str], tuple[float, str, str]]:
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return {
        (r["what"], r["of"], r["number"]): (float(r["value"]), r["unit"], r["remark"])
        for r in csv.DictReader(lines)
    }


def test_values_for_a_controller(kr270: Case) -> None:
    """Entered as the head says, they are where the calibrated robot has them."""
    calibrated = kr270.calibrated
    found = values_in(export(kr270, "table").read_text("utf-8"))
    errors = dict(zip(calibrated.model.errors.names, calibrated.state.geometry, strict=True))
    for name in calibrated.robot.joint_names:
        value, unit, remark = found["zero", name, "add to shown"]
        assert unit == "deg"
        assert value == pytest.approx(np.degrees(errors[f"zero {name}"]), abs=1e-9)
        index = calibrated.parameters.names.index(f"zero {name}")
        assert bool(remark) is not bool(calibrated.seen[index])
    for k, name in enumerate(calibrated.model.tool.marker_names):
        point = [found["tool", name, axis][0] / 1e3 for axis in "XYZ"]
        assert point == pytest.approx(calibrated.state.markers[0, k], abs=1e-12)
    T_base_station = np.linalg.inv(calibrated.state.base[0])
    shift = [found["base", "station", axis][0] / 1e3 for axis in "XYZ"]
    assert shift == pytest.approx(T_base_station[:3, 3], abs=1e-12)
    a, b, c = (np.radians(found["base", "station", axis][0]) for axis in "ABC")
    turn = turned(2, a) @ turned(1, b) @ turned(0, c)
    assert np.abs(turn - T_base_station[:3, :3]).max() < 1e-9
    vector = np.array([found["base", "station", axis][0] for axis in ("rx", "ry", "rz")])
    turn = rotation_about(vector, float(np.linalg.norm(vector)))
    assert np.abs(turn - T_base_station[:3, :3]).max() < 1e-8


def test_zeros_are_as_the_controller_counts(kr270: Case, tmp_path: Path) -> None:
    """A controller that counts A2 the other way, and shows A3 with A2 in it."""
    text = kr270.study.read_text("utf-8")
    study = tmp_path / "study.yaml"
    study.write_text(
        f"{text}\ncontroller: {{signs: {{A2: -1}}, couple: {{A3: {{A2: 1}}}}}}\n", "utf-8"
    )
    plain = values_in(export(kr270, "table").read_text("utf-8"))
    other = values_in(export(kr270._replace(study=study), "table").read_text("utf-8"))
    zero = {j: plain["zero", j, "add to shown"][0] for j in ("A1", "A2", "A3")}
    shown = {j: other["zero", j, "add to shown"][0] for j in ("A1", "A2", "A3")}
    assert shown["A1"] == zero["A1"]
    assert shown["A2"] == pytest.approx(-zero["A2"])
    assert shown["A3"] == pytest.approx(zero["A3"] - zero["A2"])


def test_near_parallel_axes_are_said(kr270: Case) -> None:
    done = run(
        "export", kr270.model, "--to", "dh", "--study", kr270.study, "-o", kr270.model.parent
    )
    assert "A2: its axis is nearly parallel to the one beside it" in " ".join(done.stdout.split())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--to", "krl"], "a calibrated robot is exported to urdf, dh, mdh, json, table"),
        (["--to", "urdf", "--home", "A1=0deg"], "--home is for robot programs"),
        (["--to", "urdf", "-o", "robot.txt"], "or a name that ends in .urdf"),
        (["--to", "json", "-o", "MODEL"], "would be written over the file it is made from"),
    ],
)
def test_what_is_refused(kr270: Case, arguments: list[str], message: str) -> None:
    words = [str(kr270.model) if word == "MODEL" else word for word in arguments]
    done = run("export", kr270.model, "--study", kr270.study, *words)
    assert done.exit_code == 2
    assert message in " ".join(done.stderr.split())


def test_a_study_is_needed_and_must_be_the_one(kr270: Case) -> None:
    done = run("export", kr270.model, "--to", "urdf")
    assert done.exit_code == 2
    assert "name its study with --study" in " ".join(done.stderr.split())
    other = OWN[0].parent / "study.yaml"
    done = run("export", kr270.model, "--to", "urdf", "--study", other)
    assert done.exit_code == 2
    assert "this is a calibration of" in " ".join(done.stderr.split())


def test_the_urdf_of_the_study_is_not_written_over(tmp_path: Path) -> None:
    urdf = next(path for path in OWN if path.stem == "kr270")
    for file in urdf.parent.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    case = case_of(urdf, tmp_path)
    own = tmp_path / "kr270.urdf"
    done = run(
        "export",
        case.model,
        "--to",
        "urdf",
        "--study",
        tmp_path / "study.yaml",
        "-o",
        own,
        "--force",
    )
    assert done.exit_code == 2
    assert own.read_bytes() == urdf.read_bytes()


@pytest.mark.parametrize("to", ["urdf", "dh", "mdh", "json", "table"])
def test_a_second_run_replaces_the_first_but_no_other_file(kr270: Case, to: str) -> None:
    path = export(kr270, to)
    assert export(kr270, to) == path
    path.write_text("mine", "utf-8")
    done = run("export", kr270.model, "--to", to, "--study", kr270.study, "-o", path)
    assert done.exit_code == 2
    assert path.read_text("utf-8") == "mine"


def test_a_xacro_file_is_expanded(tmp_path: Path) -> None:
    pytest.importorskip("xacro")
    urdf = next(path for path in OWN if path.stem == "kr270")
    text = urdf.read_text("utf-8")
    space = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    text = text.replace("<robot ", f"<robot {space} ", 1)
    text = text.replace("</robot>", '<xacro:arg name="x" default="1"/></robot>')
    (tmp_path / "arm.urdf.xacro").write_text(text, "utf-8")
    study = (urdf.parent / "study.yaml").read_text("utf-8")
    study = study.replace("{urdf: kr270.urdf}", "{urdf: arm.urdf.xacro}")
    (tmp_path / "study.yaml").write_text(study, "utf-8")
    case = case_of(urdf, tmp_path)._replace(study=tmp_path / "study.yaml")
    text = export(case, "urdf").read_text("utf-8")
    again = by_us(text, None, re.findall(r'<link name="([^"]*)"', text)[-1])
    for q in configurations(again, np.random.default_rng(4)):
        assert np.abs(plain_flange(again, q) - plain_flange(case.calibrated.robot, q)).max() < 1e-9


def test_a_plan_is_no_calibrated_robot(tmp_path: Path) -> None:
    plan = EXAMPLES / "kr270" / "plan.json"
    if not plan.exists():
        plan = tmp_path / "plan.json"
        plan.write_text('{"elastocal": 1, "kind": "plan", "load_cases": []}', "utf-8")
    done = run("export", plan, "--to", "urdf", "--study", EXAMPLES / "kr270" / "study.yaml")
    assert done.exit_code == 2
