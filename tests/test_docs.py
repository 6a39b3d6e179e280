"""What the documents say is true where a test can tell: code runs, links lead somewhere."""

from __future__ import annotations

import contextlib
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from shutil import copyfile
from typing import NamedTuple

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

import elastocal as ec
from elastocal.cli import app
from elastocal.files.measurements.mapping import MappingFile
from elastocal.files.plans.plan_file import plan_document
from elastocal.files.plans.proved_section import proved_section
from elastocal.files.problems import sections_of
from elastocal.files.sections import Section, fields_of
from elastocal.files.study.study_file import StudyFile, parse_study
from elastocal.planning.proved import Proved
from elastocal.proof.plain_data import as_data
from elastocal.robot.sources import BUILTIN
from elastocal.study.criteria import CRITERIA
from tests.proof.statements import chance
from tests.test_examples import ROOT, quietly

DOCS = ROOT / "docs"
DOCUMENTS = sorted(
    [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), ROOT / "benchmarks" / "README.md"]
)
RECORDS = sorted((DOCS / "decisions").glob("*.md"))
COMMANDS = typer.main.get_command(app).commands  # type: ignore[attr-defined]
MODELS = list(dict.fromkeys(m for file in (StudyFile, MappingFile) for m in sections_of(file)))
LIVES_LATER = {"demo", "dist", "results"}  # folders that commands make


class Block(NamedTuple):
    """A fenced block."""

    file: Path
    line: int
    language: str
    text: str

    @property
    def name(self) -> str:
        return f"{name_of(self.file)}:{self.line}"


def name_of(path: Path) -> str:
    """Path in the repository, for the names of tests."""
    return path.relative_to(ROOT).as_posix()


def blocks(language: str) -> list[Block]:
    """All fenced blocks of a language; "python no-run" is another one than "python"."""
    return [b for path in DOCUMENTS for b in _blocks(path) if b.language == language]


def _blocks(path: Path) -> Iterator[Block]:
    lines = path.read_text("utf-8").splitlines()
    start: int | None = None
    for number, line in enumerate(lines):
        if not line.startswith("```"):
            continue
        if start is None:
            start = number
        else:
            text = "\n".join(lines[start + 1 : number]) + "\n"
            yield Block(path, start + 1, lines[start][3:].strip(), text)
            start = None
    assert start is None, f"{path}: a block is not closed"


def quoted(path: Path) -> list[str]:
    """What stands between backticks, and indented or fenced lines of code."""
    fenced = [line for block in _blocks(path) for line in block.text.splitlines()]
    indented = re.findall(r"^    (\S.*)$", path.read_text("utf-8"), re.MULTILINE)
    return spans(path) + fenced + indented


def spans(path: Path) -> list[str]:
    """What stands between backticks in the running text."""
    text = re.sub(r"^```.*?^```", "", path.read_text("utf-8"), flags=re.DOTALL | re.MULTILINE)
    return [" ".join(span.split()) for span in re.findall(r"`([^`]+)`", text)]


def words(path: Path) -> set[str]:
    """Words between backticks in the running text."""
    return {word for span in spans(path) for word in re.findall(r"[\w-]+", span)}


@pytest.mark.parametrize("block", blocks("python"), ids=lambda block: block.name)
def test_python_runs(block: Block) -> None:
    """In the root of the repository, as a reader would; "python no-run" is left out."""
    done = subprocess.run(
        [sys.executable, "-c", block.text],
        cwd=ROOT,
        env=quietly(),
        capture_output=True,
        encoding="utf-8",
        timeout=300,
    )
    assert done.returncode == 0, done.stderr


def test_the_commands_of_two_campaigns_run(tmp_path: Path) -> None:
    """In a copy of the example; where people measure, the truth is bent by the plan before."""
    for name in ("study.yaml", "study_a1.yaml", "truth.json"):
        copyfile(ROOT / "examples" / "kr270" / name, tmp_path / name)
    (block,) = (b for b in blocks("sh") if "--known" in b.text)
    lines = [line.split()[1:] for line in block.text.splitlines()]
    assert [line[0] for line in lines] == ["plan", "identify", "plan", "identify"]
    for i, line in enumerate(lines):
        if line[0] == "identify":
            _, study, measured, *_ = line
            plan = lines[i - 1][-1]
            _elastocal(tmp_path, "simulate", study, plan, "--truth", "truth.json", "-o", measured)
        _elastocal(tmp_path, *line)
    first, found = (
        json.loads((tmp_path / name).read_text("utf-8")) for name in ("plan.json", "model.json")
    )
    assert first["doubts"][0]["code"] == "rigid-at-test-pose"
    truth = json.loads((tmp_path / "truth.json").read_text("utf-8"))["compliance"]
    assert list(found["compliance"]) == list(truth)
    for name, entry in found["compliance"].items():
        assert abs(entry["value"] - truth[name]["value"]) < 4.0 * entry["standard_error"]
    # What the second plan promised is what its fit says: the whole error of both campaigns.
    second = json.loads((tmp_path / "plan_a1.json").read_text("utf-8"))
    (pose,) = found["diagnostics"]["test_poses"]
    assert pose["rho0_mm"] == pytest.approx(second["rho0_mm"], rel=0.01)


def _elastocal(folder: Path, *arguments: str) -> None:
    """A command in a folder."""
    with contextlib.chdir(folder):
        done = CliRunner().invoke(app, [*arguments])
    assert done.exit_code == 0, done.output


STUDIES = [
    block for block in blocks("yaml") if "elastocal: 1" in block.text and "\nrobot:" in block.text
]


@pytest.mark.parametrize("block", STUDIES, ids=lambda block: block.name)
def test_a_study_can_be_read_and_identified(block: Block) -> None:
    study = parse_study(block.text, block.file)
    assert ec.check(study).problem is None


def test_there_are_examples_of_studies_and_code() -> None:
    assert len(STUDIES) >= 2
    assert len(blocks("python")) >= 2


def anchors(path: Path) -> set[str]:
    """Names under which the headings of a document can be reached."""
    headings = re.findall(r"^#+ (.*)$", path.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", h.lower()).strip().replace(" ", "-") for h in headings}


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_links_lead_somewhere(path: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", path.read_text("utf-8")):
        if re.match(r"[a-z]+:", target):
            continue
        file, _, anchor = target.partition("#")
        goal = (path.parent / file).resolve() if file else path
        assert goal.exists(), f"{target} does not exist"
        assert goal.is_relative_to(ROOT), f"{target} leaves the repository"
        if anchor:
            assert anchor in anchors(goal), f"no heading for {target}"


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_named_files_exist(path: Path) -> None:
    for code in quoted(path):
        for name in re.findall(r"(?<![\w/.])(?:src|tests|docs|examples|benchmarks)/[\w./-]+", code):
            found = ROOT / name.rstrip(".")
            missing = not found.exists() and not LIVES_LATER & set(found.parts)
            assert not missing, f"{name} does not exist"


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_files_named_by_their_room_exist(path: Path) -> None:
    """`room/file.py` is a file of the package."""
    rooms = "|".join(p.name for p in (ROOT / "src" / "elastocal").iterdir() if p.is_dir())
    for span in spans(path):
        for name in re.findall(rf"^(?:{rooms})/[\w/]+\.py$", span):
            assert (ROOT / "src" / "elastocal" / name).exists(), f"{name} does not exist"


@pytest.mark.parametrize("path", DOCUMENTS, ids=name_of)
def test_commands_exist_with_their_options(path: Path) -> None:
    for code in quoted(path):
        line = code.split("#")[0]
        for command in re.findall(r"^elastocal ([a-z][a-z-]*)", line):
            assert command in COMMANDS, line
            known = {option for p in COMMANDS[command].params for option in p.opts}
            assert set(re.findall(r"--[a-z-]+", line)) <= known | {"--help"}, line
        for target in re.findall(r"^make ([a-z-]+)", line):
            assert re.search(rf"^{target}:", (ROOT / "Makefile").read_text("utf-8"), re.M), line


def test_every_equation_has_a_number_of_its_own() -> None:
    text = (DOCS / "math.md").read_text("utf-8")
    numbers = re.findall(r"^\| (\d+[a-z]?) \|", text, re.MULTILINE)
    assert len(numbers) > 50
    assert len(numbers) == len(set(numbers))


def test_every_command_is_in_the_readme() -> None:
    named = {
        c for code in quoted(ROOT / "README.md") for c in re.findall(r"elastocal ([\w-]+)", code)
    }
    assert set(COMMANDS) - {"demo"} <= named  # `make demo` is


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.__name__)
def test_every_key_of_a_study_is_documented(model: type[Section]) -> None:
    known = words(DOCS / "file-formats.md")
    assert set(fields_of(model)) <= known


def test_every_key_of_a_plan_is_documented() -> None:
    robot = ec.load_robot("three-link")
    springs, tip = ec.joint_springs(robot), robot.tools["tip"]
    case = ec.LoadCases(np.ones((1, 3)), np.eye(6)[:1])
    pose = ec.test_pose(ec.ElasticArm(robot, springs, tip), case, 1.0, "task")
    experiments = ec.Experiments(tip, ec.FixedVector(np.array([0.0, 1.0, 1.0])), 2)
    study = ec.Study(robot, springs, (pose,), experiments, ec.Isotropic(1.0))
    document = plan_document(ec.plan(study))
    keys = {*document, *document["certificate"], *document["load_cases"][0]}
    keys |= {*document["certificate"]["peak"], *document["certificate"]["continuous_design"][0]}
    keys |= {*document["schedule"]}
    keys |= {*document["study"], *document["load_cases"][0]["nearest_constraint"]}
    assert keys <= words(DOCS / "file-formats.md")


def test_every_key_of_a_proof_is_documented() -> None:
    certificate = ec.Certificate("test-pose", "rigorous", 1.0)
    proved = Proved(0.9, 1.0, 2.0, 3, 4.0, "reached", (), "plan.proof", "0", 0.8)
    keys = {*proved_section(replace(certificate, proved=proved))["proved"]}
    keys |= {*as_data(chance(np.random.default_rng(0)))} | {"study_sha256", "version"}
    assert keys <= words(DOCS / "file-formats.md")


def test_every_criterion_and_robot_is_documented() -> None:
    assert set(CRITERIA) <= words(DOCS / "how-to-choose.md")
    assert set(BUILTIN) <= words(DOCS / "file-formats.md")


@pytest.mark.parametrize("path", RECORDS, ids=lambda path: path.stem)
def test_decision_records_have_their_form(path: Path) -> None:
    lines = path.read_text("utf-8").splitlines()
    assert len(lines) <= 60
    number = RECORDS.index(path) + 1
    assert path.name.startswith(f"{number:04d}-")
    assert lines[0].startswith(f"# {number}. ")
    assert re.fullmatch(r"\d{4}-\d{2}-\d{2}", lines[2])
    headings = [line for line in lines if line.startswith("## ")]
    assert headings == ["## Context", "## Decision", "## Consequences"]
