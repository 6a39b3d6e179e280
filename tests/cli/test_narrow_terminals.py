"""Tables on narrow terminals: in parts that fit, each with its first column; whole in a file."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.files.campaign import STUDY_TEXT
from tests.files.measurements.test_bad_measurements import GOOD


def shown(folder: Path, columns: int | None) -> list[str]:
    """Lines of `check --measurements` on a terminal of so many columns, or in a pipe."""
    (folder / "study.yaml").write_text(STUDY_TEXT)
    (folder / "m.csv").write_text(GOOD)
    environment = {k: v for k, v in os.environ.items() if k != "COLUMNS"}
    environment |= {} if columns is None else {"COLUMNS": str(columns)}
    command = [sys.executable, "-m", "elastocal", "check", "study.yaml", "--measurements", "m.csv"]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, encoding="utf-8", check=True
    )
    return done.stdout.splitlines()


HEADERS = ("A1", "A6", "force N", "torque N·m", "deflection mm")


@pytest.mark.parametrize("columns", [40, 60, 80])
def test_no_line_is_wider_than_the_terminal(columns: int, tmp_path: Path) -> None:
    lines = shown(tmp_path, columns)
    assert max(map(len, lines)) <= columns
    heads = [line for line in lines if line.split()[:1] == ["experiment"]]
    assert len(heads) > 1
    for header in HEADERS:
        assert sum(header in head for head in heads) == 1, header
    for experiment in "123":  # its row in every part
        rows = [line for line in lines if line.split()[:1] == [experiment]]
        assert len(rows) == len(heads)


@pytest.mark.parametrize("columns", [None, 200])
def test_where_there_is_room_a_row_is_a_line(columns: int | None, tmp_path: Path) -> None:
    lines = shown(tmp_path, columns)
    (head,) = [line for line in lines if line.split()[:1] == ["experiment"]]
    assert all(header in head for header in HEADERS)
