"""Every command on a small study: what it prints, writes, refuses."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from elastocal.cli import app

STUDY = """\
elastocal: 1
robot: three-link
test_poses:
  - {tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 3}
instrument: {sigma_mm: 0.1}
constraints: {collision: off, floor: off}
"""
COMMANDS = (
    "init",
    "check",
    "plan",
    "evaluate",
    "check-proof",
    "export",
    "report",
    "demo",
    "compensate",
    "simulate",
)


def run(*arguments: str | Path) -> Any:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a study and its plan."""
    path = tmp_path_factory.mktemp("campaign")
    (path / "study.yaml").write_text(STUDY, encoding="utf-8")
    result = run("plan", path / "study.yaml", "--out", path / "plan.json")
    assert result.exit_code == 0, result.stderr
    return path


def edited(folder: Path, tmp_path: Path, change: Any) -> Path:
    """The plan with a change applied to its document."""
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    change(document)
    path = tmp_path / "edited.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


@pytest.mark.parametrize("command", [(), *[(name,) for name in COMMANDS]])
def test_help_everywhere(command: tuple[str, ...]) -> None:
    result = run(*command, "--help")
    assert result.exit_code == 0
    assert "Usage: " in result.stdout
    assert all(name in result.stdout for name in (command or COMMANDS))


def test_init_writes_a_study_that_check_accepts(tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    assert run("init", study).exit_code == 0
    assert study.read_text(encoding="utf-8").count("#") > 5
    assert "\nnuisance: typical " in study.read_text(encoding="utf-8")
    shown = run("check", study)
    assert shown.exit_code == 0
    for words in ("kuka-kr270", "A6", "0 0 -2500", "milling", "Identifiable", "32.8 %", "tilt A3"):
        assert words in shown.stdout


def test_check_as_json(folder: Path) -> None:
    document = json.loads(run("check", folder / "study.yaml", "--json").stdout)
    # Stretched out and level, the arm is 2.35 m long and starts 0.75 m over the floor.
    assert document["reach_mm"] == pytest.approx(1e3 * np.hypot(2.35, 0.75), rel=0.35)
    assert document["problem"] is None


def test_plan_writes_json_and_run_sheet(folder: Path) -> None:
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    assert document["kind"] == "plan"
    assert sum(case["repeats"] for case in document["load_cases"]) == 3
    # The published optimum for three experiments, here with 1000 N and sigma 0.1 mm: the force
    # at the test pose and the calibration force are both a thousand times the paper's.
    assert document["rho0_mm"] == pytest.approx(0.1 * np.sqrt(0.495890), rel=1e-5)
    assert 0.99 < document["certificate"]["efficiency"] <= 1.0
    assert document["certificate"]["fresh_starts"] >= 600
    rows = (folder / "plan.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0].startswith("configuration,J1 [deg],J2 [deg],J3 [deg],Fx [N]")
    assert len(rows) == 1 + len(document["load_cases"])


def test_plan_as_json_prints_what_it_writes(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "again.json"
    result = run("plan", folder / "study.yaml", "--out", out, "--json")
    assert json.loads(result.stdout) == json.loads(out.read_text(encoding="utf-8"))
    assert out.read_bytes() == (folder / "plan.json").read_bytes(), "same seed, same plan"


def test_evaluate_accepts_a_plan_and_its_run_sheet(folder: Path) -> None:
    result = run(
        "evaluate", folder / "study.yaml", folder / "plan.json", folder / "plan.csv", "--json"
    )
    assert result.exit_code == 0, result.stderr
    both = json.loads(result.stdout)
    assert [entry["accepted"] for entry in both.values()] == [True, True]
    assert both["plan.csv"]["rho0_mm"] == pytest.approx(both["plan.json"]["rho0_mm"], rel=1e-6)


def test_evaluate_shows_plans_beside_random_ones(folder: Path) -> None:
    result = run("evaluate", folder / "study.yaml", folder / "plan.json", "--random", "200")
    assert "200 random feasible plans" in result.stdout
    assert "better than the random median" in result.stdout


def lift(document: Any) -> None:
    document["load_cases"][0]["q_deg"]["J2"] = 200.0


def push_harder(document: Any) -> None:
    document["load_cases"][0]["force_N"] = [0.0, 0.0, -5000.0]


def boast(document: Any) -> None:
    document["rho0_mm"] *= 0.5


def boast_at_a_pose(document: Any) -> None:
    (name,) = document["rho0_each_mm"]
    document["rho0_each_mm"][name] *= 0.9


def boast_of_errors(document: Any) -> None:
    document["standard_error"]["J1"]["value"] *= 0.5


def boast_of_the_bound(document: Any) -> None:
    document["certificate"]["rho0_lower_bound_mm"] *= 1.02


def boast_by_g(document: Any) -> None:
    document["criteria"]["G"] *= 1.001


def boast_of_efficiency(document: Any) -> None:
    document["certificate"]["efficiency"] = 1.0001


def keep_one(document: Any) -> None:
    document["load_cases"] = document["load_cases"][:1]
    document["load_cases"][0]["force_N"] = [0.0, 0.0, -1000.0]
    document["load_cases"][0]["q_deg"] = {"J1": 0.0, "J2": 30.0, "J3": -20.0}
    for claim in ("rho0_mm", "standard_error", "certificate"):
        del document[claim]


@pytest.mark.parametrize(
    ("change", "code", "words"),
    [
        (lift, 3, "breaks J2 <= 180° by 20°"),
        (push_harder, 3, "above the bound of 1000 N"),
        (boast, 2, "claims ρ0"),
        (boast_at_a_pose, 2, "at 'test pose 1' it claims"),
        (boast_of_errors, 2, "claims a standard error"),
        (boast_of_the_bound, 2, "is confirmed"),
        (boast_by_g, 2, "rad/(N·m) for criterion G but has"),
        (boast_of_efficiency, 2, "efficiency of 1.0001"),
        (keep_one, 4, "J1"),
    ],
)
def test_evaluate_says_no(change: Any, code: int, words: str, folder: Path, tmp_path: Path) -> None:
    """Negative controls: a plan that breaks a constraint or claims what does not hold."""
    plan = edited(folder, tmp_path, change)
    result = run("evaluate", folder / "study.yaml", plan, "--random", "0")
    assert result.exit_code == code, result.stderr
    assert words in result.stderr
    assert "refused" in result.stdout


BAD_PLANS = {
    "no file": (None, "no such file"),
    "no JSON": ("{", "line 1, column"),
    "another file": ("{}", "not a plan file"),
    "later version": ('{"kind": "plan", "elastocal": 2}', "version 2"),
    "no load cases": ('{"kind": "plan", "elastocal": 1}', "at least one load case"),
    "list of words": ('{"kind": "plan", "elastocal": 1, "load_cases": ["a"]}', "load case 1"),
    "joint missing": (
        '{"kind": "plan", "elastocal": 1, "load_cases": [{"q_deg": {"J1": 0}}]}',
        "joint 'J2' has no value",
    ),
    "NaN": (
        '{"kind": "plan", "elastocal": 1, "load_cases": [{"q_deg": {"J1": NaN}}]}',
        "finite number",
    ),
    "repeats": (
        '{"kind": "plan", "elastocal": 1, "load_cases": [{"q_deg": {"J1": 0, "J2": 0, "J3": 0},'
        '"force_N": [0, 0, 1], "repeats": 0}]}',
        "repeats must be a whole number",
    ),
    "deep": ("[" * 100_000, "nested too deeply"),
}


@pytest.mark.parametrize("name", BAD_PLANS)
def test_bad_plan_files(name: str, folder: Path, tmp_path: Path) -> None:
    content, words = BAD_PLANS[name]
    plan = tmp_path / "plan.json"
    if content is not None:
        plan.write_text(content, encoding="utf-8")
    result = run("evaluate", folder / "study.yaml", plan)
    assert result.exit_code == 2
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


HEADER = "configuration,J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N],repeats"
BAD_SHEETS = {
    "empty": ("", "the file is empty"),
    "unit missing": (HEADER.replace("J1 [deg]", "J1") + "\n1,0,0,0,0,0,1,1", "found none"),
    "unit wrong": (HEADER.replace("J1 [deg]", "J1 [mm]") + "\n1,0,0,0,0,0,1,1", "found [mm]"),
    "word": (HEADER + "\n1,0,zero,0,0,0,1,1", "line 2, column 'J2 [deg]'"),
    "short row": (HEADER + "\n1,0,0,0,0,0,1", "only half written, 7 of 8 cells"),
    "infinity": (HEADER + "\n1,0,inf,0,0,0,1,1", "finite"),
    "half a repeat": (HEADER + "\n1,0,0,0,0,0,1,1.5", "whole number"),
}


@pytest.mark.parametrize("name", BAD_SHEETS)
def test_bad_run_sheets(name: str, folder: Path, tmp_path: Path) -> None:
    content, words = BAD_SHEETS[name]
    plan = tmp_path / "plan.csv"
    plan.write_text(content, encoding="utf-8")
    result = run("evaluate", folder / "study.yaml", plan)
    assert result.exit_code == 2
    assert words in result.stderr


def test_report_of_a_plan(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "report.html"
    result = run("report", folder / "plan.json", "--quick", "--out", out)
    assert result.exit_code == 0, result.stderr
    assert "<html" in out.read_text(encoding="utf-8")[:200]


def test_plan_added_to_an_earlier_one(folder: Path, tmp_path: Path) -> None:
    """A plan that knows what was measured before is better than one that does not."""
    study = tmp_path / "study.yaml"
    earlier = folder / "plan.json"
    study.write_text(STUDY + f"prior: {{plan: {earlier}}}\n", encoding="utf-8")
    assert run("plan", study, "--out", tmp_path / "more.json").exit_code == 0
    more = json.loads((tmp_path / "more.json").read_text(encoding="utf-8"))
    before = json.loads(earlier.read_text(encoding="utf-8"))
    # Six experiments in all cannot beat the best plan of six, 0.247945 at unit sigma and force.
    assert 0.1 * np.sqrt(0.247945) * (1 - 1e-6) < more["rho0_mm"] < 0.75 * before["rho0_mm"]


def _wait_until_it_works(pid: int) -> None:
    """Until the process has spent most of a second computing: imports take half of that."""
    stat = Path(f"/proc/{pid}/stat")
    ticks = os.sysconf("SC_CLK_TCK")
    for _ in range(600):
        time.sleep(0.05)
        if stat.exists():
            fields = stat.read_text().rsplit(")", 1)[1].split()
            if (int(fields[11]) + int(fields[12])) / ticks > 0.9:
                return


@pytest.mark.skipif(sys.platform != "linux", reason="looks at /proc")
def test_interrupt_leaves_old_files_alone(tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    study.write_text("criterion: E\n" + STUDY.replace("count: 3", "count: 4"), encoding="utf-8")
    out = tmp_path / "plan.json"
    out.write_text("old", encoding="utf-8")
    process = subprocess.Popen(
        [sys.executable, "-m", "elastocal", "plan", study, "--out", out, "--force"],
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONWARNINGS": "error"},
        text=True,
    )
    _wait_until_it_works(process.pid)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    if process.returncode == 0:  # there was a plan already, and it was finished
        assert json.loads(out.read_text(encoding="utf-8"))["kind"] == "plan"
        return
    # Stopped in code made from a string, as a dataclass is, Python ends by the signal at last.
    assert process.returncode in (130, -signal.SIGINT), said
    # In the middle of an import Python itself warns of the file it had open.
    assert said.endswith("stopped; no file was changed\n")
    assert out.read_text(encoding="utf-8") == "old"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["plan.json", "study.yaml"]


def test_one_is_not_called_many(tmp_path: Path) -> None:
    study = tmp_path / "study.yaml"
    study.write_text(STUDY.replace("count: 3", "count: 1"), encoding="utf-8")
    said = run("plan", study, "--out", tmp_path / "plan.json").stdout
    assert said.startswith("1 experiment in 1 configuration, force")
    assert "No plan of 1 experiment has" in said


@pytest.mark.parametrize("encoding", ["ascii", "cp1252"])
def test_narrow_encodings_spell_what_they_cannot_write(folder: Path, encoding: str) -> None:
    """A pipe on Windows, a terminal over a serial line: units stay readable, nothing fails."""
    command = [sys.executable, "-m", "elastocal", "evaluate", "study.yaml", "plan.json"]
    for more in ([], ["--json"]):
        done = subprocess.run(
            [*command, "--random", "10", *more],
            cwd=folder,
            env=os.environ | {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"},
            capture_output=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        text = done.stdout.decode(encoding)
        if more:
            assert json.loads(text)["plan.json"]["experiments"] == 3
        else:
            assert "rho0" in text
            assert ("um" if encoding == "ascii" else "µm") in text or "mm" in text
    done = subprocess.run(
        [*command[:4], "stüdy.yaml", "plan.json"],
        cwd=folder,
        env=os.environ | {"PYTHONIOENCODING": "ascii"},
        capture_output=True,
        check=False,
    )
    assert b"st\\xfcdy.yaml: no such file" in done.stderr


def test_a_study_that_asks_for_g_hears_what_that_is(folder: Path, tmp_path: Path) -> None:
    """The name meant another criterion once: check and plan say so, and the unit."""
    text = STUDY.replace("count: 3", "count: 1") + "criterion: G\n"
    (tmp_path / "study.yaml").write_text(text, encoding="utf-8")
    said = "what version 0.1.0 called G is 'coordinate'"
    assert said in flat(run("check", tmp_path / "study.yaml").stdout)
    made = run("plan", tmp_path / "study.yaml", "--out", tmp_path / "plan.json")
    assert said in made.stderr
    assert "nrad/(N·m): largest standard error of a compliance" in flat(made.stdout)
    asked = ("plan", folder / "study.yaml", "--count", 1, "--criterion", "G")
    assert said in run(*asked, "--out", tmp_path / "again.json").stderr
    assert "note" not in run(*asked[:-1], "A", "--out", tmp_path / "again.json").stderr


def test_the_report_of_an_old_plan_for_g_says_what_it_judges_by(
    folder: Path, tmp_path: Path
) -> None:
    document = json.loads((folder / "plan.json").read_text("utf-8"))
    document["criterion"] = "G"
    document["criteria"]["G_mm"] = document["criteria"].pop("coordinate_mm")
    del document["criteria"]["G"]
    document["certificate"]["criterion"] = "G"
    (tmp_path / "plan.json").write_text(json.dumps(document), encoding="utf-8")
    arguments = (tmp_path / "plan.json", "--quick", "-o", tmp_path / "r.html")
    for study in ((), ("--study", folder / "study.yaml")):
        result = run("report", *arguments, *study)
        assert result.exit_code == 0, result.output
        assert "plan.json was made for what version 0.1.0 called G" in flat(result.stderr)


def flat(text: str) -> str:
    return " ".join(text.split())
