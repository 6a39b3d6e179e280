"""Paths as test poses of study files: what is read, what is refused, and changed files noticed."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.errors import PlanFileError, StudyError
from elastocal.files.plans.plan_file import plan_document, read_with_study, write_plan
from elastocal.files.plans.proposal_file import read_proposal
from elastocal.files.study.study_file import parse_study
from elastocal.planning.assessment import Assessment
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath
from tests.cli.test_commands import run

KR270 = Path(__file__).parents[3] / "examples" / "kr270"
POSE = "q_deg: [0, -56.9, 89.3, 45.1, 76, 57.2]"
HEAD = """\
elastocal: 1
robot: kuka-kr270
identify: [A2, A3, A4, A5, A6]
tools:
  milling: {tcp_mm: [986, 0, 0]}
  calibration: {load_point_mm: [611.5, 0, -460], markers_mm: {M1: [611.5, 0, -460]}}
test_poses:
"""
TAIL = """
experiments: {tool: calibration, force_N: [0, 0, -2500], count: 2}
instrument: {sigma_mm: 0.03}
constraints: {collision: off, floor: off}
"""
PLAIN = f"  - {{name: milling, tool: milling, {POSE}, force_N: [0, 280, -180]}}"


def study_with(*poses: str, folder: Path = KR270) -> Study:
    return parse_study(HEAD + "\n".join(poses) + TAIL, folder / "study.yaml")


def path_of(study: Study) -> TestPath:
    path = study.test_poses[-1]
    assert isinstance(path, TestPath)
    return path


def test_a_path_is_that_of_its_file() -> None:
    study = study_with(f"  - {{path: path.csv, tool: milling, {POSE}}}")
    path, tool = path_of(study), study.test_poses[0].tool
    assert tool is not None
    task = ec.read_path(
        KR270 / "path.csv", study.robot, tool, np.radians([0, -56.9, 89.3, 45.1, 76, 57.2])
    )
    assert path.name == "path.csv"
    assert (path.source, path.sha256, path.points) == ("path.csv", task.sha256, task.names)
    assert np.array_equal(path.cases.q, task.cases.q)
    assert np.array_equal(path.cases.wrench, task.cases.wrench)
    assert path.weight == 1.0


def test_every_takes_each_kth_point() -> None:
    study = study_with(PLAIN, "  - {name: P, path: path.csv, tool: milling, every: 7, weight: 0.5}")
    path = path_of(study)  # started from the test pose before it, which has the same tool
    assert path.points == tuple(str(i) for i in range(1, 201, 7))
    whole = path_of(study_with(PLAIN, "  - {path: path.csv, tool: milling}"))
    assert np.array_equal(path.cases.q, whole.cases.q[::7])
    assert (path.name, path.weight) == ("P", 0.5)


def joints_csv(folder: Path, count: int, loads: bool = True) -> Path:
    """A path of configurations."""
    path = folder / "joints.csv"
    names = ec.load_robot("kuka-kr270").joint_names
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow([f"{n} [deg]" for n in names] + ["Fx [N]", "Fy [N]", "Fz [N]"] * loads)
        for i in range(count):
            q = [0.01 * i, -56.9, 89.3, 45.1, 76, 57.2]
            out.writerow([*q, *[0, 280, -180] * loads])
    return path


def test_one_load_for_all_points(tmp_path: Path) -> None:
    joints_csv(tmp_path, 3, loads=False)
    entry = "  - {path: joints.csv, tool: milling, force_N: [0, 280, -180]}"
    path = path_of(study_with(entry, folder=tmp_path))
    assert path.cases.wrench.tolist() == [[0, 280, -180, 0, 0, 0]] * 3


BAD = {
    "no file": ("path: gone.csv, tool: milling", "line 8: .*gone.csv: no such file"),
    "no tool": ("path: path.csv", "line 8: path.csv: key 'tool' is missing"),
    "unknown tool": ("path: path.csv, tool: mill", "line 8: tool 'mill' is not defined"),
    "every without path": (f"tool: milling, {POSE}, force_N: [0, 1, 0], every: 2", "every takes"),
    "every zero": ("path: path.csv, tool: milling, every: 0", "every: .*whole number from 1"),
    "every a half": ("path: path.csv, tool: milling, every: 0.5", "every: .*whole number"),
    "two loads": (
        f"path: path.csv, tool: milling, {POSE}, force_N: [0, 0, 1]",
        "line 8: .*path.csv, line 1: the file has loads .* and one for all points is given too",
    ),
    "with a matrix": (
        "path: path.csv, tool: milling, regressor_Nm2: [[1, 0, 0, 0, 0]]",
        "give either path or regressor_Nm2",
    ),
    "not a path": ("path: study.yaml, tool: milling", "line 8: .*study.yaml"),
    "a folder": ("path: ., tool: milling", "line 8: "),
    "negative weight": ("path: path.csv, tool: milling, weight: -1", "0 or a positive number"),
    "nothing to plan for": (
        f"path: path.csv, tool: milling, {POSE}, weight: 0",
        "line 7: every test pose has weight 0, so there is nothing to plan for",
    ),
    "far from its start": (
        "path: path.csv, tool: milling, q_deg: [150, -10, -100, 0, 0, 0]",
        "line 8: .*path.csv, line 2: .*name a configuration near it: --start, in a study q_deg",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_what_is_wrong_is_said_in_one_sentence(what: str) -> None:
    entry, sentence = BAD[what]
    with pytest.raises(StudyError, match=sentence) as found:
        study_with(f"  - {{{entry}}}")
    assert "\n" not in str(found.value)


def test_a_point_beyond_the_limits_is_named(tmp_path: Path) -> None:
    path = joints_csv(tmp_path, 3)
    path.write_text(path.read_text("utf-8").replace("0.02,-56.9", "0.02,56.9"), encoding="utf-8")
    with pytest.raises(StudyError, match=r"line 8: .*joints.csv, line 4, column 'A2': 56.9°"):
        study_with("  - {path: joints.csv, tool: milling}", folder=tmp_path)


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, ec.Plan]:
    """A folder with a study, its path and a plan of it."""
    folder = tmp_path_factory.mktemp("planned")
    joints_csv(folder, 40)
    text = HEAD + "  - {name: cut, path: joints.csv, tool: milling}\n" + TAIL
    (folder / "study.yaml").write_text(text, encoding="utf-8")
    study = ec.read_study(folder / "study.yaml")
    plan = ec.plan(study, effort=ec.Effort(12, 2, 1, 1))
    write_plan(plan, folder / "plan.json")
    return folder, plan


def test_a_plan_says_what_it_is_worth_along_the_path(planned: tuple[Path, ec.Plan]) -> None:
    _, plan = planned
    document, worth = plan_document(plan), plan.assessment
    assert document["study"]["paths_sha256"] == plan.study.path_hashes
    entry = document["paths"]["cut"]
    worst = worth.worst_points[0]
    assert worst is not None
    assert entry == {"points": 40, "worst_mm": 1e3 * worst.rho0, "worst_point": worst.name}
    covariance = np.linalg.inv(worth.information)
    each = [np.trace(a @ covariance @ a.T) for a in plan.study.test_poses[0].regressors]
    assert worst.index == int(np.argmax(each))
    assert worst.rho0 == pytest.approx(np.sqrt(max(each)), rel=1e-9)
    assert worth.rho0 == pytest.approx(np.sqrt(np.mean(each)), rel=1e-9)
    assert worth.criteria["worst"] == pytest.approx(worst.rho0, rel=1e-9)


def test_no_plan_without_a_path_speaks_of_one(planned: tuple[Path, ec.Plan]) -> None:
    _, plan = planned
    plain = study_with(PLAIN)
    worth: Assessment = ec.assess(plain, plan.load_cases, plan.repeats)
    document = plan_document(replace(plan, study=plain, assessment=worth))
    assert "paths" not in document
    assert "paths_sha256" not in document["study"]


def changed(folder: Path, to: Path) -> Path:
    """The same folder with another path."""
    for name in ("study.yaml", "plan.json", "joints.csv"):
        (to / name).write_bytes((folder / name).read_bytes())
    other = (to / "joints.csv").read_text("utf-8").replace("280", "281")
    (to / "joints.csv").write_text(other, encoding="utf-8")
    return to


def test_a_changed_path_is_noticed(planned: tuple[Path, ec.Plan], tmp_path: Path) -> None:
    """Where the study of the plan is used it is refused; beside a study it is said."""
    folder, plan = planned
    assert read_with_study(folder / "plan.json")[1].path_hashes == plan.study.path_hashes
    other = changed(folder, tmp_path)
    with pytest.raises(PlanFileError, match=r"path 'joints.csv' has changed since this plan"):
        read_with_study(other / "plan.json")
    proposal = read_proposal(other / "plan.json", plan.study)
    assert proposal.path_hashes == plan.study.path_hashes
    refused = run("export", other / "plan.json", "--to", "csv", "--out", other)
    assert refused.exit_code == 2
    assert "joints.csv' has changed" in refused.stderr
    options = ("--to", "csv", "--out", other, "--study", other / "study.yaml")
    said = run("export", other / "plan.json", *options)
    assert said.exit_code == 0
    assert "plan.json was made for another content of joints.csv" in said.stderr
    unchanged = run("export", folder / "plan.json", "--to", "csv", "--out", other)
    assert "another content" not in unchanged.stderr


def test_plans_are_judged_along_another_path(planned: tuple[Path, ec.Plan], tmp_path: Path) -> None:
    """Named on the command line: rms, worst point and who is better where, by hand."""
    folder, plan = planned
    study = plan.study
    worse = replace(
        plan,
        repeats=np.ones_like(plan.repeats),
        load_cases=ec.LoadCases(plan.load_cases.q + 0.05, plan.load_cases.wrench),
    )
    document = plan_document(plan) | {"criteria": {}}
    entries = plan_document(worse)["load_cases"]
    kept = {"elastocal": 1, "kind": "plan"}
    (tmp_path / "a.json").write_text(json.dumps(kept | {"load_cases": document["load_cases"]}))
    (tmp_path / "b.json").write_text(json.dumps(kept | {"load_cases": entries}))
    options = ("--path", KR270 / "path.csv", "--random", "0", "--json")
    done = run(
        "evaluate", folder / "study.yaml", tmp_path / "a.json", tmp_path / "b.json", *options
    )
    found = json.loads(done.stdout)
    tool = study.test_poses[0].tool
    assert tool is not None
    first = study.test_poses[0].case
    assert first is not None
    task = ec.read_path(KR270 / "path.csv", study.robot, tool, first.q[0])
    rows = ec.regressor(replace(study.arm, tool=tool.at_tcp), task.cases)
    each = {}
    for name, one in (("a.json", plan), ("b.json", worse)):
        information = ec.assess(study, one.load_cases, one.repeats).information
        covariance = np.linalg.inv(information)
        each[name] = np.sqrt(np.einsum("nij,jk,nik->n", rows, covariance, rows))
        entry = found[name]["paths"]["path.csv"]
        assert entry["worst_mm"] == pytest.approx(1e3 * each[name].max(), rel=1e-6)
        assert entry["worst_point"] == task.names[int(each[name].argmax())]
        rms = 1e3 * np.sqrt(np.mean(each[name] ** 2))
        assert found[name]["rho0_each_mm"]["path.csv"] == pytest.approx(rms, rel=1e-6)
    share = float(np.mean(each["a.json"] < each["b.json"]))
    assert found["a.json"]["paths"]["path.csv"]["better_than"] == {"b.json": share}
    assert share > 0.0
    assert found["a.json"]["paths"].keys() == {"cut", "path.csv"}
    boast = plan_document(plan)
    boast["paths"]["cut"]["worst_mm"] *= 0.9
    (tmp_path / "boast.json").write_text(json.dumps(boast))
    refused = run("evaluate", folder / "study.yaml", tmp_path / "boast.json", "--random", "0")
    assert refused.exit_code == 2
    assert "at the worst point of 'cut' it claims" in refused.stderr


def test_options_of_a_path_need_one(planned: tuple[Path, ec.Plan]) -> None:
    folder, _ = planned
    done = run("evaluate", folder / "study.yaml", folder / "plan.json", "--tool", "milling")
    assert done.exit_code == 2
    assert "--tool belongs to --path, which is not given" in done.stderr
