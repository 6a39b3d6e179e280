"""The readings of the second example are those that its script makes."""

from __future__ import annotations

import csv
import runpy
from pathlib import Path

import pytest

from tests.test_examples import ROOT

FOLDER = ROOT / "examples" / "absolute"


def cells(path: Path) -> list[str | float]:
    """Every cell, as a number where it is one."""
    found: list[str | float] = []
    for row in csv.reader(path.read_text("utf-8").splitlines()):
        for cell in row:
            try:
                found.append(float(cell))
            except ValueError:
                found.append(cell)
    return found


def test_the_script_makes_the_files_of_the_folder(tmp_path: Path) -> None:
    runpy.run_path(str(FOLDER / "make_data.py"))["main"](tmp_path)
    made = sorted(path.name for path in tmp_path.iterdir())
    assert made == sorted(path.name for path in FOLDER.glob("*.csv"))
    for name in made:
        ours, theirs = cells(tmp_path / name), cells(FOLDER / name)
        assert [c for c in ours if isinstance(c, str)] == [c for c in theirs if isinstance(c, str)]
        numbers = [c for c in ours if isinstance(c, float)]
        assert numbers == pytest.approx([c for c in theirs if isinstance(c, float)], abs=2e-4)
