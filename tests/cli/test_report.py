"""`report` with the files of a campaign: everything is computed again, nothing is believed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.cli.test_commands import run

TRUTH = {"J1": 1.2e-6, "J2": 2.0e-6, "J3": 2.9e-6}
STUDY = """\
elastocal: 1
robot: three-link
tools:
  tip: {tcp_mm: [250, 0, 0], load_point_mm: [250, 0, 0], markers_mm: {M1: [250, 0, 0]}}
test_poses:
  - {tool: tip, q_deg: [0, 60, -45], force_N: [0, 290, -960]}
experiments: {tool: tip, max_force_N: 1000, direction: free, count: 6}
instrument: {sigma_mm: 0.02}
constraints: {collision: off, floor: off}
"""
PATH = """\
point,J1 [deg],J2 [deg],J3 [deg],Fx [N],Fy [N],Fz [N]
1,0,60,-45,0,290,-960
2,2,59,-44,0,290,-960
3,4,58,-43,0,290,-960
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A campaign: study, plan, truth, two measurement files, model, path."""
    path = tmp_path_factory.mktemp("campaign")
    (path / "study.yaml").write_text(STUDY, encoding="utf-8")
    (path / "path.csv").write_text(PATH, encoding="utf-8")
    truth = {n: {"value": v, "unit": "rad/(N·m)"} for n, v in TRUTH.items()}
    document = {"elastocal": 1, "kind": "model", "robot": "three-link", "compliance": truth}
    (path / "truth.json").write_text(json.dumps(document), encoding="utf-8")
    study, plan, true = path / "study.yaml", path / "plan.json", path / "truth.json"
    ok(run("plan", study, "-o", plan))
    ok(run("simulate", study, plan, "--truth", true, "-o", path / "m.csv"))
    ok(run("simulate", study, plan, "--truth", true, "--seed", 1, "-o", path / "v.csv"))
    ok(run("identify", study, path / "m.csv", "-o", path / "model.json"))
    return path


def ok(result: Any) -> None:
    assert result.exit_code == 0, result.stderr


def report(folder: Path, tmp_path: Path, *options: str) -> tuple[Any, str]:
    """The command in `folder`, and the page it wrote."""
    out = tmp_path / "page.html"
    named = [folder / o if (folder / o).is_file() else o for o in options]
    result = run("report", folder / "plan.json", "--quick", "-o", out, *named)
    return result, out.read_text(encoding="utf-8") if out.exists() else ""


def test_the_whole_campaign(folder: Path, tmp_path: Path) -> None:
    options = ["--measurements", "m.csv", "--model", "model.json", "--validation", "v.csv"]
    options += ["--path", "path.csv", "--truth", "truth.json", "--campaigns", "20"]
    options += ["--random", "4"]
    result, page = report(folder, tmp_path, *options)
    ok(result)
    for section in ("identification", "validation", "remaining", "monte-carlo", "run-sheet"):
        assert f'id="{section}"' in page
    assert "took no part in the identification" in page
    assert "negative control" in page
    assert "4 random plans" in page


def test_nothing_kept_aside(folder: Path, tmp_path: Path) -> None:
    result, page = report(folder, tmp_path, "--measurements", "m.csv", "--path", "path.csv")
    ok(result)
    assert "each left out in turn" in page
    assert "negative control" not in page


def test_a_model_from_elsewhere_is_judged(folder: Path, tmp_path: Path) -> None:
    result, page = report(folder, tmp_path, "--model", "truth.json", "--validation", "v.csv")
    ok(result)
    assert 'id="identification"' not in page
    assert 'id="validation"' in page


def test_settings_of_the_fit_come_from_the_model(folder: Path, tmp_path: Path) -> None:
    linear = tmp_path / "linear.json"
    ok(run("identify", folder / "study.yaml", folder / "m.csv", "--model", "linear", "-o", linear))
    result, page = report(folder, tmp_path, "--measurements", "m.csv", "--model", str(linear))
    ok(result)
    assert "Fitted by the linear model" in page


def test_numbers_in_a_model_are_not_believed(folder: Path, tmp_path: Path) -> None:
    document = json.loads((folder / "model.json").read_text(encoding="utf-8"))
    document["compliance"]["J2"]["value"] *= 1.01
    forged = tmp_path / "forged.json"
    forged.write_text(json.dumps(document), encoding="utf-8")
    result, page = report(folder, tmp_path, "--measurements", "m.csv", "--model", str(forged))
    assert result.exit_code == 2
    assert "is not the model that" in result.stderr
    assert "J2 is" in result.stderr
    assert page == ""


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--validation", "v.csv"], "validation needs --measurements or --model"),
        (["--path", "path.csv"], "a path needs --measurements or --model"),
        (["--campaigns", "10"], "--campaigns needs --truth"),
        (["--random", "10"], "--random needs --campaigns"),
        (["--measurements", "m.csv", "--validation", "m.csv"], "leave --validation out"),
        (["--measurements", "path.csv"], "path.csv"),
    ],
)
def test_what_is_missing_is_said(
    options: list[str], said: str, folder: Path, tmp_path: Path
) -> None:
    result, page = report(folder, tmp_path, *options)
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1
    assert page == ""


def test_no_input_is_written_over(folder: Path) -> None:
    before = (folder / "m.csv").read_bytes()
    result = run(
        "report", folder / "plan.json", "--quick", "--measurements", folder / "m.csv",
        "-o", folder / "m.csv",
    )  # fmt: skip
    assert result.exit_code == 2
    assert (folder / "m.csv").read_bytes() == before


def test_nothing_is_written_over_what_it_is_made_from(folder: Path, tmp_path: Path) -> None:
    """Prior, known model and mapping are inputs like the measurements."""
    study, measured, model = folder / "study.yaml", folder / "m.csv", folder / "model.json"
    before = model.read_bytes()
    for option in ("--prior", "--known"):
        result = run("identify", study, measured, option, model, "-o", model)
        assert (result.exit_code, model.read_bytes()) == (2, before)
        assert "over the file it is made from" in result.stderr
    other = tmp_path / "study.yaml"
    other.write_bytes(study.read_bytes())
    result = run("report", folder / "plan.json", "--study", other, "-o", other, "--quick")
    assert (result.exit_code, other.read_bytes()) == (2, study.read_bytes())


def test_a_confidence_is_a_probability(folder: Path) -> None:
    study, model = folder / "study.yaml", folder / "model.json"
    for wrong in ("95", "0.2", "1"):
        result = run("validate", study, model, folder / "v.csv", "--confidence", wrong)
        assert result.exit_code == 2, result.stdout
        assert "confidence must be from 0.5 to below 1" in result.stderr
    result = run("validate", study, model, folder / "v.csv", "--confidence", "nan")
    assert result.exit_code == 2, result.stdout
    assert "expected a number, found 'nan'" in result.stderr


def test_files_that_count_their_experiments_alike_are_named(folder: Path) -> None:
    text = (folder / "v.csv").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    lines[1:] = [
        ",".join([str(7 - i), *line.split(",")[1:]]) for i, line in enumerate(lines[1:], 1)
    ]
    (folder / "other.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    result = run(
        "check",
        folder / "study.yaml",
        "--measurements",
        folder / "m.csv",
        "--measurements",
        folder / "other.csv",
    )
    assert result.exit_code == 2
    assert f" of {folder / 'm.csv'}; expected one" in result.stderr
    assert "names of their own in every file" in result.stderr
