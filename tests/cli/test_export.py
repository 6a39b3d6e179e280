"""`export` on the command line."""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

import pytest
from rich.table import Table

from elastocal.programs.writers import ENDINGS, WRITERS
from elastocal.terminal.console import whole
from tests.cli.test_commands import run
from tests.programs.writers.campaigns import EXAMPLES
from tests.programs.writers.parsers import PARSERS

STUDY = EXAMPLES / "kr270" / "study.yaml"
HOME = "A1=0deg A2=-60deg A3=60deg A4=0deg A5=20deg A6=0deg"


def plan_document() -> dict[str, Any]:
    joints = ("A1", "A2", "A3", "A4", "A5", "A6")
    poses = (
        [0, -50.79, 63.06, 147.44, -101.66, 86.21],
        [0, -55.46, -72.4, -119.39, -56.59, -179.27],
    )
    cases = [
        {"q_deg": dict(zip(joints, q, strict=True)), "force_N": [0, 0, -2500], "repeats": i + 1}
        for i, q in enumerate(poses)
    ]
    text = STUDY.read_text(encoding="utf-8")
    return {"elastocal": 1, "kind": "plan", "study": {"text": text}, "load_cases": cases}


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(plan_document()), encoding="utf-8")
    return path


def read(folder: Path) -> dict[str, str]:
    return {p.name: p.read_text() for p in folder.iterdir() if p.name != "plan.json"}


@pytest.mark.parametrize("controller", WRITERS)
def test_every_controller(plan: Path, controller: str) -> None:
    result = run("export", plan, "--to", controller, "--out", plan.parent)
    assert result.exit_code == 0, result.stderr
    events = PARSERS[controller](read(plan.parent))
    assert [kind for kind, _ in events].count("move") == 8, "from home to home"
    for words in ("3 experiments in 2 configurations", "AP2", "8 motions", "Check the program"):
        assert words in result.stdout
    assert all(
        str(plan.parent / name) in result.stdout.replace("\n", "") for name in read(plan.parent)
    )


def test_options(plan: Path) -> None:
    result = run(
        "export", plan, "--to", "krl", "--out", plan.parent / "cell3.src", "--home", HOME,
        "--prebias-deg", "0.25", "--settle-s", "5", "--speed-percent", "20", "--trigger", "9",
        "--json",
    )  # fmt: skip
    assert result.exit_code == 0, result.stderr
    document = json.loads(result.stdout)
    assert document["files"] == [str(plan.parent / f"cell3.{e}") for e in ("src", "dat")]
    files = read(plan.parent)
    events = PARSERS["krl"](files)
    moves = [value for kind, value in events if kind == "move"]
    assert moves[0] == moves[-1] == [0, -60, 60, 0, 20, 0]
    # A4 comes from the other side: the pose is at the bound of its elevation.
    assert moves[1] == pytest.approx([-0.25, -51.04, 62.81, 147.69, -101.91, 85.96])
    assert {value for kind, value in events if kind == "wait"} == {5.0}
    assert [value for kind, value in events if kind == "pulse"] == ["9"] * 6
    assert "#VEL_PTP,20" in files["cell3.src"]


def test_home_that_breaks_a_constraint_is_noted(plan: Path) -> None:
    result = run("export", plan, "--to", "krl", "--out", plan.parent, "--home", HOME)
    assert "Home breaks elevation of flange z" in result.stdout.replace("\n", " ")
    assert "; Home breaks elevation of flange z <= 30" in "".join(read(plan.parent).values())


def test_joint_values_of_the_controller(plan: Path) -> None:
    """The study's controller is applied to the targets; home is read off at it."""
    folder = plan.parent
    result = run("export", plan, "--to", "fanuc", "-o", folder / "A.ls")
    assert result.exit_code == 0
    assert "say controller: {preset: fanuc} in the study" in " ".join(result.stdout.split())
    document = plan_document()
    document["study"]["text"] += "controller: {preset: fanuc, offsets_deg: {A6: 10}}\n"
    plan.write_text(json.dumps(document), encoding="utf-8")
    home = HOME.replace("A3=60", "A3=-5")
    result = run("export", plan, "--to", "fanuc", "-o", folder / "B.ls", "--home", home)
    assert result.exit_code == 0, result.stderr
    assert "Joint values are the model" not in result.stdout
    assert "preset" not in result.stdout
    plain, shown = (PARSERS["fanuc"]({n: read(folder)[n]}) for n in ("A.ls", "B.ls"))
    assert shown[0][1] == pytest.approx([0, -60, -5, 0, 20, 0], abs=1e-4)
    q, q_shown = plain[2][1], shown[2][1]
    assert q_shown == pytest.approx([q[0], q[1], -q[2] - q[1], *q[3:5], q[5] + 10], abs=2e-4)


@pytest.mark.parametrize(
    ("arguments", "words", "code"),
    [
        (("--to", "karel"), "no export to 'karel'; there are krl", 2),
        (("--to", "krl", "--out", "nowhere/x.src"), "does not exist", 2),
        (("--to", "krl", "--out", "x.mod"), "ends in .src", 2),
        (("--to", "krl", "--out", "nowhere/else"), "there is no such folder", 2),
        (("--to", "krl", "--out", "2nd.src"), "not a program name for krl, 'P_2nd' would", 2),
        (("--to", "fanuc", "--out", "long_and_small_name.ls"), "'LONG_AND_SMALL_N' would", 2),
        (("--to", "krl", "--home", "A1=0"), "expected name=value with deg or mm, found 'A1=0'", 2),
        (("--to", "krl", "--home", "A1=0mm"), "given in mm, expected deg", 2),
        (("--to", "krl", "--home", "B1=0deg"), "no joint 'B1'", 2),
        (("--to", "krl", "--home", "A1=0deg A1=0deg"), "given twice", 2),
        (("--to", "krl", "--home", "A1=0deg"), "joint 'A2' is missing", 2),
        (("--to", "krl", "--home", "A1=1.2.3deg"), "expected a number", 2),
        (("--to", "krl", "--home", HOME.replace("-60", "60")), "joint 'A2' is at 60°", 2),
        (("--to", "krl", "--settle-s", "999"), "settling time", 2),
        (("--to", "krl", "--speed-percent", "0"), "speed", 2),
        (("--to", "krl", "--prebias-deg", "-1"), "not negative, found -1°", 2),
        (("--to", "krl", "--prebias-deg", "200"), "cannot be approached", 2),
        (("--to", "krl", "--external", "E1"), "no joint 'E1'", 2),
        (("--to", "krl", "--trigger", "x"), "KRL outputs", 2),
        (("--to", "krl", "--trigger", "٣"), "numbers from 1 to 4096, found '٣'", 2),
        (("--to", "fanuc", "--trigger", "²"), "FANUC outputs", 2),
        (("--to", "urscript", "--trigger", "9" * 5000), "URScript outputs", 2),
    ],
)  # fmt: skip
def test_what_is_refused(plan: Path, arguments: tuple[str, ...], words: str, code: int) -> None:
    before = set(plan.parent.iterdir())
    given = [str(plan.parent / a) if a.endswith((".src", ".mod", ".ls")) else a for a in arguments]
    out = () if "--out" in given else ("--out", str(plan.parent))
    result = run("export", plan, *given, *out)
    assert (result.exit_code, result.stdout) == (code, "")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
    assert set(plan.parent.iterdir()) == before


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("q_deg", {"A1": 0, "A2": 50, "A3": 0, "A4": 0, "A5": 0, "A6": 0}, "breaks"),
        ("force_N", [0, 0, -2600], "force"),
    ],
)
def test_a_plan_is_judged_again(plan: Path, key: str, value: Any, words: str) -> None:
    document = plan_document()
    document["load_cases"][1][key] = value
    document["rho0_mm"] = 1.0
    plan.write_text(json.dumps(document), encoding="utf-8")
    result = run("export", plan, "--to", "krl", "--out", plan.parent)
    assert result.exit_code == 3
    assert "load case 2" in result.stderr
    assert words in result.stderr
    assert list(plan.parent.iterdir()) == [plan]


def test_a_table_is_not_written_over_its_plan(tmp_path: Path) -> None:
    joints = ",".join(f"A{i} [deg]" for i in range(1, 7))
    plan = tmp_path / "cell.csv"
    plan.write_text(
        f"{joints},Fx [N],Fy [N],Fz [N],repeats\n0,-50.79,63.06,147.44,-101.66,86.21,0,0,-2500,1\n"
    )
    result = run("export", plan, "--study", STUDY, "--to", "csv", "--out", plan)
    assert result.exit_code == 2
    assert "written over" in result.stderr
    result = run("export", plan, "--study", STUDY, "--to", "csv", "--out", tmp_path)
    assert result.exit_code == 0


def source_of(name: str) -> str:
    """Another plan of the same study: the document with other repeats."""
    document = plan_document()
    document["load_cases"][1]["repeats"] = 5
    return json.dumps(document | {"made_by": name})


@pytest.mark.parametrize("controller", WRITERS)
def test_a_program_does_not_take_the_place_of_another(plan: Path, controller: str) -> None:
    folder, ending = plan.parent, ENDINGS[controller]
    assert run("export", plan, "--to", controller, "-o", folder / f"X{ending}").exit_code == 0
    assert run("export", plan, "--to", controller, "-o", folder / f"X{ending}").exit_code == 0
    before = (folder / f"X{ending}").read_bytes()
    plan.write_text(source_of("other"), encoding="utf-8")
    for name in ("X", "x") if controller != "fanuc" else ("X",):
        to = folder / f"{name}{ending}"
        result = run("export", plan, "--to", controller, "-o", to)
        assert result.exit_code == 2
        as_it_is = "is a program that was made from something else"
        words = as_it_is if name == "X" else "is there, which is the same name to controllers"
        assert f"X{ending} {words}" in result.stderr
        assert "--force" in result.stderr
        assert {path.name for path in folder.glob(f"*{ending}")} == {f"X{ending}"}
    assert (folder / f"X{ending}").read_bytes() == before
    to = folder / f"X{ending}"
    assert run("export", plan, "--to", controller, "-o", to, "--force").exit_code == 0
    assert to.read_bytes() != before
    assert run("export", plan, "--to", controller, "-o", folder).exit_code == 0
    assert len(list(folder.glob(f"*{ending}"))) == 2  # a name of its own


@pytest.mark.parametrize("controller", WRITERS)
def test_two_plans_of_one_study_are_two_programs(plan: Path, controller: str) -> None:
    folder, ending = plan.parent, ENDINGS[controller]
    for text in (json.dumps(plan_document()), source_of("other")):
        plan.write_text(text, encoding="utf-8")
        assert run("export", plan, "--to", controller, "-o", folder).exit_code == 0
    names = [path.name for path in folder.iterdir() if path.suffix == ending]
    assert len({name.lower() for name in names}) == 2
    assert all(re.fullmatch(r"(?i)KR_270_MI\w*_[a-z2-7]{6}\.\w+", name) for name in names)


@pytest.mark.parametrize("controller", WRITERS)
def test_lines_end_as_where_the_controller_lives(plan: Path, controller: str) -> None:
    assert run("export", plan, "--to", controller, "-o", plan.parent).exit_code == 0
    for path in plan.parent.iterdir():
        if path != plan:
            data = path.read_bytes()
            windows = controller in ("krl", "rapid", "fanuc")
            assert data.count(b"\r\n") == data.count(b"\r") == windows * data.count(b"\n")


def test_scripts_for_a_script_node(plan: Path) -> None:
    out = plan.parent / "cell.script"
    result = run("export", plan, "--to", "urscript", "-o", out, "--for-script-node")
    assert result.exit_code == 0, result.stderr
    assert "Start: choose this file in a Script node" in result.stdout.replace("\n", " ")
    assert out.read_text().endswith("\nend\ncell()\n")
    result = run("export", plan, "--to", "urscript", "-o", out)
    assert "Start: send this file to port 30002" in result.stdout.replace("\n", " ")
    assert out.read_text().splitlines()[0] == "def cell():"
    assert out.read_text().endswith("\nend\n")
    result = run("export", plan, "--to", "krl", "-o", plan.parent, "--for-script-node")
    assert (result.exit_code, "takes URScript, not krl" in result.stderr) == (2, True)


def test_what_a_program_was_made_from_is_said(plan: Path) -> None:
    """The run sheet says no study, so the study is a source of its program too."""
    digests = [hashlib.sha256(path.read_bytes()).hexdigest()[:16] for path in (plan, STUDY)]
    for study in ((), ("--study", STUDY)):
        result = run("export", plan, *study, "--to", "krl", "-o", plan.parent / "c.src", "--force")
        assert result.exit_code == 0, result.stderr
        text = (plan.parent / "c.src").read_text()
        assert f"plan sha256 {digests[0]}" in text
        assert (f"study sha256 {digests[1]}" in text) == bool(study)
        assert "as in the model" in text
        assert "converted" not in text


def test_every_ending_is_known() -> None:
    assert set(ENDINGS) == set(WRITERS)


def test_a_table_wider_than_the_terminal_is_not_cut(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table()
    for i in range(30):
        table.add_column(f"joint {i}")
    table.add_row(*[f"{i}.12345" for i in range(30)])
    whole(table)
    shown = capsys.readouterr().out
    assert all(f" {i}.12345 " in shown and f" joint {i} " in shown for i in range(30))
