"""Names with line breaks, escapes or signs unseen are refused, whatever file they stand in."""

from __future__ import annotations

import json
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from elastocal.names import LONGEST, flaw, shown
from tests.cli.test_bad_studies import GOOD
from tests.cli.test_commands import run

UNSEEN = [
    "\n", "\r", "\t", "\0", "\x1b", "\x7f", "\x85", "\x9b", "\u2028", "\u2029", "\ud800",
    "\u202e", "\u2066", "\u200b", "\u200d", "\ufeff", "\u00ad", "\U000e0041",
    "\u3164", "\uffa0", "\u2800", "\u034f", "\ufe0f", "\U000e0100", "\uffff", "\ue000",
]  # fmt: skip


@pytest.mark.parametrize("sign", UNSEEN, ids=ascii)
def test_signs_unseen(sign: str) -> None:
    said = flaw(f"J1{sign}movej")
    assert f"U+{ord(sign):04X}, at place 3" in said
    assert said.isascii()
    assert said.isprintable()
    assert flaw(f"{sign}x").isprintable()


@pytest.mark.parametrize("name", ["A1", "Süd – Zelle 3 (µ)", "关节一", "a ; b", "🦾", 'x" y\\', ""])
def test_signs_that_can_be_seen(name: str) -> None:
    assert flaw(name) == ""
    assert shown(name) == name


def test_length() -> None:
    assert flaw("x" * LONGEST) == ""
    assert f"at most {LONGEST} characters, found {LONGEST + 1}" in flaw("x" * (LONGEST + 1))
    assert len(flaw("x" * 900_000)) < 200
    assert flaw("x" * 900, 900) == ""


@given(st.text())
def test_what_passes_is_one_line_without_escapes(text: str) -> None:
    if not flaw(text):
        assert len(text.splitlines()) <= 1
        assert not {unicodedata.category(sign) for sign in text} & {
            "Cc",
            "Cf",
            "Cn",
            "Co",
            "Cs",
            "Zl",
            "Zp",
        }
        text.encode("utf-8")
    assert len(shown(text).splitlines()) <= 1


TABLE = """robot:
  name: "NAME_R"
  convention: modified
  dh:
    - {joint: "NAME_J", d_mm: 300, limits_deg: [-160, 160]}
    - {joint: "J2", alpha_deg: -90, a_mm: 100, limits_deg: [-160, 160]}
    - {joint: "J3", a_mm: 600, limits_deg: [-160, 160]}
"""
STUDY = f"""elastocal: 1
name: "NAME_S"
{TABLE}tools:
  "NAME_T": {{load_point_mm: [100, 0, 50], markers_mm: {{"NAME_M": [100, 0, 50]}}}}
test_poses:
  - {{name: "NAME_P", tool: "NAME_T", q_deg: [20, 40, 10], force_N: [50, 80, 10]}}
experiments: {{tool: "NAME_T", force_N: [0, 0, -100], count: 6, max_configurations: 3}}
identify: [J2, J3]
instrument: {{sigma_mm: 0.03}}
constraints:
  obstacles:
  - {{name: "NAME_O", center_mm: [3000, 0, 0], sphere_radius_mm: 100}}
check_poses:
  - {{name: "NAME_C", q_deg: [0, 0, 0], flange_mm: [700, 0, 300]}}
"""
FIELDS = {
    "R": ("line 4", "robot.name"), "J": ("line 7", "joint"), "S": ("line 2", "name"),
    "T": ("line 1", "tools"), "M": ("line 11", "markers_mm"), "P": ("line 13", "name"),
    "O": ("line 19", "name"), "C": ("line 21", "name"),
}  # fmt: skip


def study(bad: str, field: str) -> str:
    """A study with `bad`, as YAML escapes it, in the name called `field`."""
    text = STUDY.replace(f"NAME_{field}", f"a{bad}b")
    return text.replace("NAME_", "n")


@pytest.mark.parametrize("field", FIELDS)
@pytest.mark.parametrize("bad", ["\\n", "\\r", "\\e[31m", "\\x85", "\\u2028", "\\ud800", "\\u202e"])
def test_names_in_a_study(field: str, bad: str, tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(study(bad, field), encoding="utf-8")
    result = run("check", path)
    assert result.exit_code == 2
    place, key = FIELDS[field]
    for words in (place, key, "expected a name on one line of visible signs", ascii("a")[:-1]):
        assert words in result.stderr
    assert result.stderr[:-1].isprintable()


def test_the_study_itself_is_good(tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(STUDY, encoding="utf-8")
    result = run("check", path)
    assert "expected a name" not in result.stderr
    path.write_text(study("x" * 300, "M"), encoding="utf-8")
    assert "at most 200 characters, found 302" in run("check", path).stderr


SPRINGS = GOOD.replace("instrument:", 'springs: {"s\\nq": {carried_by: A2}}\ninstrument:')


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("identify: [", 'identify: ["A\\n2", '),
        ("robot: kuka-kr270", 'robot: "kuka\\nkr270"'),
        ("instrument:", 'springs: {"s\\nq": {carried_by: A2}}\ninstrument:'),
        ("instrument:", 'controller: {offsets_deg: {"A\\n2": 1}}\ninstrument:'),
        ("instrument:", 'prior: {plan: "a\\0.json"}\ninstrument:'),
        ("instrument:", 'known: "a\\0.json"\ninstrument:'),
    ],
)
def test_other_names_in_a_study(old: str, new: str, tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    result = run("check", path)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "visible signs" in result.stderr
    assert "line " in result.stderr


URDF = """<robot name="ROBOT"><link name="base"/><link name="l1"/>
<joint name="JOINT" type="revolute"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1"/></joint></robot>"""


@pytest.mark.parametrize(("field", "line"), [("ROBOT", 1), ("JOINT", 2), ("l1", 1)])
@pytest.mark.parametrize("bad", ["&#10;", "&#13;", "&#8232;", "&#133;", "&#8238;"])
def test_names_in_a_urdf(field: str, line: int, bad: str, tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(URDF.replace(field, f"a{bad}b"), encoding="utf-8")
    path = tmp_path / "study.yaml"
    robot = GOOD.replace("robot: kuka-kr270", "robot: {urdf: arm.urdf}")
    path.write_text(robot, encoding="utf-8")
    result = run("check", path)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert f"arm.urdf, line {line}" in result.stderr
    assert "visible signs" in result.stderr


@pytest.fixture
def good(tmp_path: Path) -> Path:
    path = tmp_path / "study.yaml"
    path.write_text(GOOD, encoding="utf-8")
    return path


MEASURED = (
    "experiment,marker,A1 [deg],A2 [deg],A3 [deg],A4 [deg],A5 [deg],A6 [deg],"
    "Fx [N],Fy [N],Fz [N],dx [mm],dy [mm],dz [mm]\n"
    "1,M1,0,-50,60,0,0,0,0,0,-2500,0,0,-1\n"
)


@pytest.mark.parametrize(("cell", "column"), [("1,M", "experiment"), ("M1", "marker")])
def test_names_in_measurements(good: Path, cell: str, column: str) -> None:
    path = good.parent / "measured.csv"
    bad = MEASURED.replace(cell, f"\u2066{cell}" if column == "marker" else "\u202e1,M")
    path.write_text(bad, encoding="utf-8")
    result = run("check", good, "--measurements", path)
    assert result.exit_code == 2
    assert f"measured.csv, line 2, column '{column}'" in result.stderr
    assert result.stderr[:-1].isprintable()


def test_names_in_a_mapping(good: Path) -> None:
    path = good.parent / "mapping.yaml"
    measured = good.parent / "measured.csv"
    measured.write_text(MEASURED, encoding="utf-8")
    for text, line in (
        ('elastocal: 1\ncolumns: {"exp\\neriment": 1}\n', 2),
        ('elastocal: 1\nencoding: "utf-8\\0"\ncolumns: {experiment: 1}\n', 2),
        ('elastocal: 1\ncolumns: {experiment: 1}\nwords: {marker: {M1: "M\\u2028"}}\n', 3),
    ):
        path.write_text(text, encoding="utf-8")
        result = run("check", good, "--measurements", measured, "--mapping", path)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
        assert f"mapping.yaml, line {line}" in result.stderr
        assert "visible signs" in result.stderr


@pytest.mark.parametrize("section", ["compliance", "stiffness", "springs"])
def test_names_in_a_model(good: Path, section: str) -> None:
    entry = {"carried_by": "A2"} if section == "springs" else {"value": 1, "unit": "rad/(N.m)"}
    model = good.parent / "model.json"
    model.write_text(json.dumps({section: {"A\n2": entry}}, indent=1), encoding="utf-8")
    path = good.parent / "path.csv"
    path.write_text("x", encoding="utf-8")
    result = run("compensate", good, model, path, "--out", good.parent / "out.csv")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "model.json, line 3" in result.stderr
    assert "visible signs" in result.stderr


def test_the_source_of_a_model(good: Path) -> None:
    entry = {"A2": {"value": 1, "unit": "mrad/(kN.m)"}}
    model = good.parent / "model.json"
    model.write_text(json.dumps({"source": "a\x1b[2J", "compliance": entry}), encoding="utf-8")
    path = good.parent / "path.csv"
    path.write_text("x", encoding="utf-8")
    result = run("compensate", good, model, path, "--out", good.parent / "out.csv")
    assert result.exit_code == 2
    assert "model.json, line 1: expected a name on one line" in result.stderr


@pytest.mark.parametrize(
    ("place", "edit"),
    [
        ("load_cases.q_deg", lambda d: d["load_cases"][0]["q_deg"].update({"A\n1": 0})),
        ("criteria", lambda d: d.update(criteria={"\x1b[2J": 1})),
        ("after.measurements", lambda d: d.update(after={"measurements": "a\u202eb"})),
        ("study.name", lambda d: d["study"].update(name="\u2028")),
    ],
)  # fmt: skip
def test_names_in_a_plan(good: Path, place: str, edit: object) -> None:
    case = {"q_deg": {"A1": 0}, "force_N": [0, 0, -2500], "repeats": 1}
    document = {"elastocal": 1, "kind": "plan", "study": {"text": GOOD}, "load_cases": [case]}
    edit(document)  # type: ignore[operator]
    path = good.parent / "plan.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    for command in (["evaluate", good, path], ["export", path, "--to", "krl"]):
        result = run(*command)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
        assert f"plan.json, {place}: " in result.stderr
        assert "visible signs" in result.stderr


def test_names_in_a_path(good: Path) -> None:
    path, model = good.parent / "path.csv", good.parent / "model.json"
    model.write_text('{"compliance": {"A2": {"value": 1, "unit": "mrad/(kN.m)"}}}')
    joints = ",".join(f"A{i} [deg]" for i in range(1, 7))
    path.write_text(f"point,{joints}\n\u202ep,0,-50,60,0,0,0\n", encoding="utf-8")
    out = good.parent / "out.csv"
    force = ("--force-n", 0, 0, -100)
    result = run("compensate", good, model, path, "--tool", "milling", *force, "--out", out)
    assert result.exit_code == 2, result.stderr
    assert "path.csv, line 2, column 'point'" in result.stderr
