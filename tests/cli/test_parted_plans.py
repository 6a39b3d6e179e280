"""A run sheet beside the plan of another campaign is noticed, whichever of them is read."""

from __future__ import annotations

from pathlib import Path

import pytest

from elastocal.files.plans.pair import parted
from tests.cli.test_commands import STUDY, run
from tests.cli.test_overwriting import TRUTH


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    (folder / "study.yaml").write_text(STUDY, encoding="utf-8")
    (folder / "truth.json").write_text(TRUTH, encoding="utf-8")
    for count in (3, 4):
        out = folder / f"of_{count}.json"
        assert run("plan", folder / "study.yaml", "--count", count, "-o", out).exit_code == 0
    return folder


def test_what_belongs_together(made: Path, tmp_path: Path) -> None:
    for name in ("of_3.json", "of_3.csv", "study.yaml"):
        assert parted(made / name) is None
    lonely = tmp_path / "plan.json"
    lonely.write_bytes((made / "of_3.json").read_bytes())
    assert parted(lonely) is None
    sheet = tmp_path / "plan.csv"
    sheet.write_text("J1 [deg],repeats\n1,2\n", encoding="utf-8")  # by hand
    assert parted(lonely) is None
    noted = (made / "of_3.csv").read_text(encoding="utf-8").replace("J1 <=", "windy; J1 <=")
    sheet.write_text(noted, encoding="utf-8")  # with notes of the operator
    assert parted(lonely) is None


@pytest.mark.parametrize("read", ["plan.json", "plan.csv"])
def test_every_command_says_it(
    read: str, made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("study.yaml", "truth.json"):
        (tmp_path / name).write_bytes((made / name).read_bytes())
    (tmp_path / "plan.json").write_bytes((made / "of_3.json").read_bytes())
    (tmp_path / "plan.csv").write_bytes((made / "of_4.csv").read_bytes())
    other = {"plan.json": "plan.csv", "plan.csv": "plan.json"}[read]
    commands = [
        ["evaluate", "study.yaml", read, "--random", "0"],
        ["simulate", "study.yaml", read, "--truth", "truth.json"],
        ["export", read, "--study", "study.yaml", "--to", "krl"],
        ["report", read, "--study", "study.yaml", "--quick"],
    ]
    for arguments in commands:
        result = run(*arguments)
        assert f"note: {other} beside {read} belongs to another plan" in result.stderr, arguments
