"""Plans that were edited after they were written: noticed wherever a plan is read."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from elastocal.cli.view import _subject
from elastocal.errors import PlanFileError
from elastocal.files.study.study_file import read_study
from tests.cli.test_commands import STUDY, run

TRUTH = '{"compliance": {"J1": {"value": 1e-6, "unit": "rad/(N.m)"}}}'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a study, its plan, a truth, and studies that name the edited plan."""
    path = tmp_path_factory.mktemp("campaign")
    (path / "study.yaml").write_text(STUDY, encoding="utf-8")
    (path / "truth.json").write_text(TRUTH, encoding="utf-8")
    (path / "prior.yaml").write_text(STUDY + "prior: {plan: edited.json}\n", encoding="utf-8")
    (path / "known.yaml").write_text(
        STUDY + "identify: [J1]\nknown: edited.json\n", encoding="utf-8"
    )
    result = run("plan", path / "study.yaml", "--out", path / "plan.json")
    assert result.exit_code == 0, result.stderr
    return path


def edit(folder: Path, change: Callable[[dict[str, Any]], None]) -> Path:
    """The plan with a change applied to its document."""
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    change(document)
    path = folder / "edited.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def better_instrument(document: dict[str, Any]) -> None:
    text = document["study"]["text"]
    document["study"]["text"] = text.replace("sigma_mm: 0.1", "sigma_mm: 0.01")


def smaller_load(document: dict[str, Any]) -> None:
    text = document["study"]["text"]
    document["study"]["text"] = text.replace("max_force_N: 1000", "max_force_N: 100")


def other_hash(document: dict[str, Any]) -> None:
    document["study"]["sha256"] = "0" * 64


def no_hash_at_all(document: dict[str, Any]) -> None:
    document["study"]["sha256"] = 5


READERS = {
    "evaluate": ("evaluate", "study.yaml", "edited.json", "--random", "0"),
    "report": ("report", "edited.json", "--quick"),
    "report by a study": ("report", "edited.json", "--quick", "--study", "study.yaml"),
    "report beside another": ("report", "plan.json", "--quick", "--vs", "edited.json"),
    "export": ("export", "edited.json", "--to", "csv"),
    "export by a study": ("export", "edited.json", "--to", "csv", "--study", "study.yaml"),
    "simulate": ("simulate", "study.yaml", "edited.json", "--truth", "truth.json"),
    "as a prior": ("check", "prior.yaml"),
    "as what is known": ("check", "known.yaml"),
}


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize("change", [better_instrument, smaller_load, other_hash, no_hash_at_all])
def test_a_study_edited_inside_a_plan_is_refused(
    folder: Path, change: Callable[[dict[str, Any]], None], reader: str, monkeypatch: Any
) -> None:
    edit(folder, change)
    monkeypatch.chdir(folder)
    before = {path.name for path in folder.iterdir()}
    result = run(*READERS[reader])
    assert (result.exit_code, result.stdout) == (2, "")
    assert "edited.json: the text of the study in it is not the one its sha256" in result.stderr
    assert result.stderr.count("\n") == 1
    assert {path.name for path in folder.iterdir()} == before


def test_the_live_view_refuses_it_too(folder: Path) -> None:
    plan = edit(folder, better_instrument)
    with pytest.raises(PlanFileError, match="is not the one its sha256 stands for"):
        _subject(read_study(folder / "study.yaml"), plan)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"seed": 0', '"seed": 0, "seed": 1', "key 'seed' appears twice"),
        ('"elastocal": 1', '"elastocal": 1.0', "format version 1.0 is not known"),
        ('"elastocal": 1', '"elastocal": true', "format version True is not known"),
        ('"seed": 0', '"seed": NaN', "expected a finite number, found NaN"),
        ('"seed": 0', '"seed": -Infinity', "expected a finite number, found -Infinity"),
        ('"seed": 0', '"seed": 1e999', "expected a finite number, found 1e999"),
        ('"seed": 0', '"seed": ' + 5000 * "9", "expected a finite number, found 9999"),
        ('"seed": 0', '"seed": "\\ud800"', "is half of a sign"),
    ],
)
def test_json_is_read_strictly(folder: Path, old: str, new: str, words: str) -> None:
    text = (folder / "plan.json").read_text(encoding="utf-8")
    assert old in text
    (folder / "odd.json").write_text(text.replace(old, new, 1), encoding="utf-8")
    result = run("evaluate", folder / "study.yaml", folder / "odd.json", "--random", "0")
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
