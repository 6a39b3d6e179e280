"""Every example runs, says something, and stays short."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
LONGEST = 75  # lines; the formulas of 09 fill as many


def quietly() -> dict[str, str]:
    """Environment of a subprocess: one thread, UTF-8, warnings are errors."""
    return os.environ | {
        "PYTHONWARNINGS": "error",
        "PYTHONIOENCODING": "utf-8",
        "OPENBLAS_NUM_THREADS": "1",
        "OMP_NUM_THREADS": "1",
    }


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_example_runs(path: Path, tmp_path: Path) -> None:
    """From another folder: an example must find its study by itself, and write where it is told."""
    folder = tmp_path / "deep" / "folder"
    writes = "sys.argv" in path.read_text("utf-8")
    command = [sys.executable, str(path), *([str(folder)] if writes else [])]
    done = subprocess.run(
        command, cwd=tmp_path, env=quietly(), capture_output=True, encoding="utf-8", timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) >= 3
    assert "nan" not in done.stdout.lower()
    if writes:
        assert {p.name for p in folder.iterdir()} == {"plan.json", "plan.csv", "report.html"}
    else:
        assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_example_is_short_and_has_a_title(path: Path) -> None:
    text = path.read_text("utf-8")
    assert len(text.splitlines()) <= LONGEST
    title = (ast.get_docstring(ast.parse(text)) or "").splitlines()[0]
    assert 20 < len(title) < 100
    assert path.stem[:2].isdigit()


def test_the_package_carries_the_files_of_the_kr270_example() -> None:
    """One text in two places, because the package must carry its own: they may not drift apart."""
    for own in sorted((ROOT / "src" / "elastocal" / "demo").iterdir()):
        example = ROOT / "examples" / "kr270" / own.name
        assert own.read_text(encoding="utf-8") == example.read_text(encoding="utf-8")
