"""The extra is imported where solids need it, and nowhere else."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.test_bad_cells import TABLE
from tests.cli.test_bad_studies import GOOD

POST = "{name: post, cylinder_mm: {radius: 100, length: 900}, center_mm: [3000, 0, 0]}"


@pytest.mark.parametrize(
    ("obstacles", "needed"),
    [("", "none"), (f"  obstacles: [{TABLE}]\n", "none"), (f"  obstacles: [{POST}]\n", "coal")],
)
def test_coal_is_imported_for_what_has_no_closed_form(
    obstacles: str, needed: str, tmp_path: Path
) -> None:
    (tmp_path / "study.yaml").write_text(GOOD + obstacles, encoding="utf-8")
    code = (
        "import sys\n"
        "from elastocal.planning.study_check import check\n"
        "from elastocal.files.study.study_file import read_study\n"
        f"check(read_study({str(tmp_path / 'study.yaml')!r}))\n"
        "print(' '.join(m for m in ('coal', 'trimesh') if m in sys.modules) or 'none')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == needed


def test_a_missing_extra_is_said(tmp_path: Path) -> None:
    (tmp_path / "study.yaml").write_text(GOOD + f"  obstacles: [{POST}]\n", encoding="utf-8")
    code = (
        "import sys\n"
        "sys.modules['coal'] = None\n"
        "from elastocal.cli import app\n"
        f"app(['check', {str(tmp_path / 'study.yaml')!r}])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 2
    assert "pip install 'elastocal[collision]'" in done.stderr
    assert done.stderr.count("\n") == 1
