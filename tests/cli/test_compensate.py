"""`elastocal compensate`: what it prints, writes, refuses."""

from __future__ import annotations

import csv
import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import PathFileError
from elastocal.files.tables.csv_table import read_table
from elastocal.robot.chain import transform
from elastocal.robot.rotations import from_zyx_angles
from tests.cli.test_commands import run
from tests.programs.writers.parsers import PARSERS

EXAMPLE = Path(__file__).parents[2] / "examples" / "kr270"
STUDY, TRUTH, PATH = (EXAMPLE / name for name in ("study.yaml", "truth.json", "path.csv"))
KUKA = ec.load_robot("kuka-kr270")


@pytest.fixture(scope="module")
def corrected(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("corrected") / "corrected.csv"
    result = run("compensate", STUDY, TRUTH, PATH, "-o", out, "--truth", TRUTH)
    assert result.exit_code == 0, result.stderr
    for words in ("200 of 200 points", "nonlinear", "before, by the model", "after, in truth"):
        assert words in result.stdout
    assert "wrote " in result.stdout
    return out


def test_the_corrected_file_holds_what_it_promises(corrected: Path) -> None:
    table = read_table(corrected, PathFileError)
    assert len(table.rows) == 200
    degrees = {"deg": 1.0}
    q = np.radians(table.numbers(KUKA.joint_names, degrees))
    wanted = np.radians(table.numbers([f"{n} wanted" for n in KUKA.joint_names], degrees))
    wrench = table.numbers(["Fx", "Fy", "Fz"], {"N": 1.0})
    cases = ec.LoadCases(q, np.hstack([wrench, np.zeros((200, 3))]))
    # The loaded arm, by the nonlinear equilibrium, is where the task wants it: to 1e-6 mm.
    tool = KUKA.tools["milling"]
    model = ec.read_model(TRUTH, KUKA)
    arm = ec.ElasticArm(KUKA, model.springs, tool)
    bent = ec.loaded_deflection(arm, model.compliance, cases)
    tcp = transform(None, tool.tcp)
    command = ec.forward_kinematics(KUKA, q) @ tcp
    target = ec.forward_kinematics(KUKA, wanted) @ tcp
    remaining = command[:, :3, 3] + bent - target[:, :3, 3]
    # Seven decimals of a degree, 3 m away from the base.
    assert np.linalg.norm(remaining, axis=1).max() < 2e-8
    places = table.numbers(["x", "y", "z"], {"mm": 1e-3})
    np.testing.assert_allclose(places, command[:, :3, 3], atol=2e-8)
    turns = from_zyx_angles(np.radians(table.numbers(["A", "B", "C"], degrees)))
    np.testing.assert_allclose(turns, command[:, :3, :3], atol=1e-8)


def test_a_corrected_path_is_not_corrected_again(corrected: Path, tmp_path: Path) -> None:
    result = run("compensate", STUDY, TRUTH, corrected, "-o", tmp_path / "again.csv")
    assert result.exit_code == 2
    assert "corrected path already" in result.stderr
    assert not list(tmp_path.iterdir())


def test_json_for_programs(tmp_path: Path) -> None:
    arguments = ("-o", tmp_path / "c.csv", "--truth", TRUTH, "--rule", "linear", "--json")
    result = run("compensate", STUDY, TRUTH, PATH, *arguments)
    document = json.loads(result.stdout)
    assert document["rule"] == "linear"
    assert len(document["points"]) == 200
    point = document["points"][74]
    assert np.linalg.norm(point["before_mm"]) == pytest.approx(1.56, abs=0.01)
    assert np.linalg.norm(point["residual_mm"]) < 1e-6
    assert (point["converged"], point["line"]) == (True, 76)


def small_path(tmp_path: Path, header: str, *rows: str) -> Path:
    path = tmp_path / "path.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


JOINTS = "A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg]"
POSE = "0,-56.9,89.3,45.1,76,57.2"


def model_of(tmp_path: Path, name: str, **values: float) -> Path:
    path = tmp_path / name
    unit = "rad/(N·m)"
    entries = {
        joint: {"value": v, "unit": unit, "standard_error": 0.03 * v} for joint, v in values.items()
    }
    path.write_text(json.dumps({"compliance": entries}), encoding="utf-8")
    return path


def test_models_of_two_campaigns_and_a_constant_force(tmp_path: Path) -> None:
    most = model_of(tmp_path, "a.json", A2=3e-7, A3=4e-7, A4=3e-6, A5=3e-6, A6=2e-6)
    path = small_path(tmp_path, JOINTS, POSE)
    force = ("--force-n", "0", "280", "-180")
    out = tmp_path / "c.csv"
    result = run("compensate", STUDY, most, path, *force, "-o", out)
    assert result.exit_code == 0, result.stderr
    assert "A1 has no compliance in the model and is taken as rigid" in " ".join(
        result.stdout.split()
    )
    first = model_of(tmp_path, "b.json", A1=6e-7)
    result = run("compensate", STUDY, most, path, *force, "-o", out, "--model", first)
    assert result.exit_code == 0, result.stderr
    assert "rigid" not in result.stdout
    with out.open(encoding="utf-8") as file:
        row = next(csv.DictReader(file))
    assert float(row["rho0 [mm]"]) > 0.01
    assert float(row["A1 [deg]"]) > 0.01
    result = run("compensate", STUDY, most, path, *force, "-o", out, "--model", most)
    assert result.exit_code == 2
    assert "'A2' is given twice" in result.stderr


@pytest.mark.parametrize("to", ["krl", "rapid", "fanuc", "urscript", "ros", "csv"])
def test_the_corrected_path_as_a_robot_program(tmp_path: Path, to: str) -> None:
    path = small_path(tmp_path, f"{JOINTS},Fx [N],Fy [N],Fz [N]", f"{POSE},0,280,-180")
    out = tmp_path / "out" / "corrected.csv"
    out.parent.mkdir()
    result = run("compensate", STUDY, TRUTH, path, "-o", out, "--to", to)
    assert result.exit_code == 0, result.stderr
    programs = [p for p in out.parent.iterdir() if p != out]
    assert out.exists()
    assert programs
    if to == "krl":
        assert any("45.15" in p.read_text("ascii") for p in programs)  # A4, corrected


REFUSED = {
    "rule": (("--rule", "cubic"), "no rule 'cubic'; there are nonlinear, linear"),
    "tool": (("--tool", "drill"), "no tool 'drill'; there are milling, calibration"),
    "start": (("--start", "A1=0deg"), "start: joint 'A2' is missing"),
    "program": (("--to", "basic"), "no export to 'basic'"),
    "two loads": (("--force-n", "1", "2", "3"), "one for all points is given too"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_wrong_options(tmp_path: Path, what: str) -> None:
    options, sentence = REFUSED[what]
    result = run("compensate", STUDY, TRUTH, PATH, "-o", tmp_path / "c.csv", *options)
    assert result.exit_code == 2
    assert sentence in result.stderr
    assert not list(tmp_path.iterdir())


def test_points_beyond_the_limits_are_not_written(tmp_path: Path) -> None:
    path = small_path(
        tmp_path, f"{JOINTS},Fx [N],Fy [N],Fz [N]", f"{POSE},0,280,-180", "0,0,60,0,60,0,0,0,900"
    )
    out = tmp_path / "c.csv"
    result = run("compensate", STUDY, TRUTH, path, "-o", out)
    assert result.exit_code == 3
    assert "1 of 2 points would leave the joint limits" in result.stderr
    assert "point 2 in line 3: A2 would need 0.0" in result.stderr
    assert not out.exists()


def test_an_arm_that_gives_way_is_refused(tmp_path: Path) -> None:
    soft = model_of(tmp_path, "soft.json", A2=3e-2, A3=4e-2)
    path = small_path(tmp_path, f"{JOINTS},Fx [N],Fy [N],Fz [N]", f"{POSE},0,2800,-9800")
    result = run("compensate", STUDY, soft, path, "-o", tmp_path / "c.csv")
    assert result.exit_code == 3
    assert "1 of 1 points cannot be corrected" in result.stderr
    assert not (tmp_path / "c.csv").exists()


def test_a_floor_that_gives_way_is_compensated_too(tmp_path: Path) -> None:
    model = tmp_path / "model.json"
    unit = {"unit": "rad/(N·m)"}
    document = {
        "compliance": {"A2": {"value": 3e-7} | unit, "floor": {"value": 5e-8} | unit},
        "springs": {"floor": {"carried_by": "base", "type": "revolute", "axis": [0, 1, 0]}},
    }
    model.write_text(json.dumps(document), encoding="utf-8")
    result = run(
        "compensate", STUDY, model, PATH, "-o", tmp_path / "c.csv", "--truth", model, "--json"
    )
    assert result.exit_code == 0, result.stderr
    points = json.loads(result.stdout)["points"]
    assert max(np.linalg.norm(point["residual_mm"]) for point in points) < 1e-6
    assert all(point["iterations"] >= 1 for point in points)


def test_two_corrected_paths_are_two_programs(tmp_path: Path) -> None:
    """Cut names, other models, other paths: none takes the place of another."""
    path = small_path(tmp_path, f"{JOINTS},Fx [N],Fy [N],Fz [N]", f"{POSE},0,280,-180")
    other = tmp_path / "other.json"
    for name in ("corrected_roughing", "corrected_finishing"):
        out = tmp_path / f"{name}.csv"
        result = run("compensate", STUDY, TRUTH, path, "-o", out, "--to", "fanuc")
        assert result.exit_code == 0, result.stderr
        assert "Start: load all of CORRECTED_" in result.stdout
    programs = [p for p in tmp_path.iterdir() if p.suffix == ".ls"]
    assert len(programs) == 2
    text = programs[0].read_text("ascii")
    for what, file in (("path", path), ("model", TRUTH), ("study", STUDY)):
        digest = hashlib.sha256(file.read_bytes()).hexdigest()[:16]
        assert f"!{what} sha256 {digest} ;" in text
    assert "plan sha256" not in text
    other.write_text(TRUTH.read_text("utf-8") + "\n", "utf-8")
    result = run("compensate", STUDY, other, path, "-o", out, "--to", "fanuc")
    assert result.exit_code == 0, result.stderr
    assert len([p for p in tmp_path.iterdir() if p.suffix == ".ls"]) == 3


ENDLESS = """<robot name="arm"><link name="base"/><link name="l1"/><link name="l2"/><link name="t"/>
<joint name="j1" type="continuous"><parent link="base"/><child link="l1"/>
<axis xyz="0 0 1"/></joint>
<joint name="j2" type="revolute"><parent link="l1"/><child link="l2"/><origin xyz="0.1 0 0.5"/>
<axis xyz="0 1 0"/><limit lower="-1.5" upper="1.5" effort="1" velocity="1"/></joint>
<joint name="f" type="fixed"><parent link="l2"/><child link="t"/><origin xyz="0.5 0 0"/></joint>
</robot>"""
ENDLESS_STUDY = """elastocal: 1
robot: {urdf: arm.urdf}
identify: [j2]
tools: {t: {load_point_mm: [100, 0, 0]}}
test_poses: [{tool: t, q_deg: {j1: 0, j2: 30}, force_N: [0, 0, -100]}]
experiments: {tool: t, force_N: [0, 0, -200], count: 2, max_configurations: 2}
instrument: {sigma_mm: 0.03}
"""


@pytest.mark.parametrize("to", ["krl", "rapid", "fanuc", "ros", "csv"])
def test_plans_and_paths_through_the_same_points_are_the_same_motions(
    tmp_path: Path, to: str
) -> None:
    """A joint that turns without end, beyond half a turn: 190 is 190 in both."""
    (tmp_path / "arm.urdf").write_text(ENDLESS)
    study, rows = tmp_path / "study.yaml", ["190,10,0,0,-200", "-300,20,0,0,-200"]
    study.write_text(ENDLESS_STUDY)
    header = "j1 [deg],j2 [deg],Fx [N],Fy [N],Fz [N]"
    path, plan = tmp_path / "path.csv", tmp_path / "plan.csv"
    path.write_text("\n".join([header, *rows]) + "\n")
    plan.write_text("\n".join([f"{header},repeats", *(f"{row},1" for row in rows)]) + "\n")
    rigid = tmp_path / "rigid.json"
    rigid.write_text('{"compliance": {"j2": {"value": 1e-15, "unit": "rad/(N.m)"}}}')
    found = []
    for name, arguments in (
        ("path", ("compensate", study, rigid, path, "--to", to, "-o")),
        ("plan", ("export", plan, "--study", study, "--to", to, "--prebias-deg", 0, "-o")),
    ):
        folder = tmp_path / name
        folder.mkdir()
        out = folder / "corrected.csv" if name == "path" else folder
        result = run(*arguments, out)
        assert result.exit_code == 0, result.stderr
        files = {p.name: p.read_text() for p in folder.iterdir() if p.name != "corrected.csv"}
        moves = [value for kind, value in PARSERS[to](files) if kind == "move"]
        found.append([v for i, v in enumerate(moves) if i == 0 or v != moves[i - 1]])
    assert [row for row in found[1] if row in found[0]] == found[0]  # the plan may start at home
    scale = np.pi / 180.0 if to == "ros" else 1.0
    wanted = scale * np.array([[190.0, 10.0], [-300.0, 20.0]])
    np.testing.assert_allclose(np.array(found[0])[:, :2], wanted, atol=0.5e-4)
