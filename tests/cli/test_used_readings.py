"""Validation leaves out what the model was made from, wherever it stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.campaigns import FIRST_STEP
from tests.cli.test_commands import run
from tests.cli.test_two_steps import TRUTH, done, flat


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study, a campaign of eight experiments, and a model of the first six."""
    path = tmp_path_factory.mktemp("used")
    (path / "study.yaml").write_text(FIRST_STEP.replace("count: 4", "count: 8"), encoding="utf-8")
    (path / "truth.yaml").write_text(TRUTH, encoding="utf-8")
    done("plan", path / "study.yaml", "-o", path / "plan.json")
    truth = ("--truth", path / "truth.yaml")
    done("simulate", path / "study.yaml", path / "plan.json", *truth, "-o", path / "all.csv")
    lines = (path / "all.csv").read_text("utf-8").splitlines(keepends=True)
    head = next(i for i, line in enumerate(lines) if line.startswith("experiment")) + 1
    (path / "six.csv").write_text("".join(lines[: head + 6]), encoding="utf-8")
    (path / "copy.csv").write_text("# a note\n" + "".join(lines[: head + 6]), encoding="utf-8")
    done("identify", path / "study.yaml", path / "six.csv", "-o", path / "model.json")
    return path


def test_a_file_with_more_is_judged_by_what_is_new(folder: Path) -> None:
    said = flat(done("validate", folder / "study.yaml", folder / "model.json", folder / "all.csv"))
    assert "6 of 8 experiments are left out: model.json was made from their readings" in said
    assert "2 experiments, kept aside" in said


def test_a_copy_is_not_kept_aside(folder: Path) -> None:
    result = run("validate", folder / "study.yaml", folder / "model.json", folder / "copy.csv")
    assert result.exit_code == 2
    assert "was made from all these readings" in flat(result.output)


def test_its_own_file_is_left_out_in_turn(folder: Path) -> None:
    said = flat(done("validate", folder / "study.yaml", folder / "model.json", folder / "six.csv"))
    assert "left out in turn" in said
