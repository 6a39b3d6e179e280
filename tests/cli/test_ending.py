"""How commands end: one sentence, the right exit code, and nothing said that is not true."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.table import Table
from rich.text import Text

import elastocal.planning.study_check as study_check
from elastocal.cli.common import print_json
from elastocal.cli.ending import undisturbed
from elastocal.errors import InfeasibleError
from elastocal.terminal.console import out, whole
from elastocal.terminal.plain import safe_output, visible
from tests.cli.test_commands import STUDY, run
from tests.cli.test_overwriting import PATH, TRUTH

HOSTILE = "\x1b]0;x\x07\x1b[31m\x9b31m\x7f\x08\r\u202e\u2066\u2028\udce4"
FULL = Path("/dev/full")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in (("study.yaml", STUDY), ("truth.json", TRUTH), ("path.csv", PATH)):
        (tmp_path / name).write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def program(*arguments: str, **options: Any) -> subprocess.Popen[bytes]:
    """The program as a process of its own."""
    return subprocess.Popen(
        [sys.executable, "-m", "elastocal", *arguments],
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "PYTHONUTF8": "1"},
        stderr=subprocess.PIPE,
        **options,
    )


FAULTS = {
    "linear algebra": (np.linalg.LinAlgError("not positive definite"), 1, "LinAlgError: not pos"),
    "without words": (AssertionError(), 1, "fault of elastocal: AssertionError; no file"),
    "many lines": (ValueError("one\ntwo"), 1, "fault of elastocal: ValueError: one; no file"),
    "steering": (ValueError(HOSTILE), 1, "\\u001b]0;x\\u0007\\u001b[31m\\u009b31m\\u007f"),
    "memory": (MemoryError(), 1, "not enough memory for this; no file was changed"),
    "depth": (RecursionError("maximum recursion depth exceeded"), 1, "RecursionError"),
    "half a character": (
        UnicodeEncodeError("utf-8", "\ud800", 0, 1, "no"),
        1,
        "UnicodeEncodeError",
    ),
    "stopped": (KeyboardInterrupt(), 130, "stopped; no file was changed"),
    "of the system": (
        OSError(5, "Input/output error", "x.csv"),
        2,
        "x.csv: Input/output error; no file",
    ),
    "ours": (InfeasibleError("nothing goes"), 3, "error: nothing goes"),
    "ours in lines": (InfeasibleError("a\nb"), 3, "error: a\\nb"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_whatever_happens_is_one_sentence(
    name: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fault, code, sentence = FAULTS[name]

    def fail(*_: object, **__: object) -> None:
        raise fault

    monkeypatch.setattr(study_check, "check", fail)
    monkeypatch.delenv("ELASTOCAL_TRACEBACK")
    result = run("check", "study.yaml")
    assert result.exit_code == code
    assert sentence in result.stderr
    assert result.stderr.count("\n") == 1
    assert ("ELASTOCAL_TRACEBACK=1" in result.stderr) == ("fault" in result.stderr)
    assert result.stdout == ""


def test_a_traceback_is_shown_on_request(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ValueError(HOSTILE)

    monkeypatch.setattr(study_check, "check", fail)
    monkeypatch.setenv("ELASTOCAL_TRACEBACK", "1")
    result = run("check", "study.yaml")
    assert result.exit_code == 1
    assert "Traceback" in result.stderr
    assert "test_ending.py" in result.stderr
    assert result.stderr.endswith("no file was changed\n")
    assert "\x1b" not in result.stderr


@pytest.mark.parametrize(
    ("fault", "code"), [(KeyboardInterrupt(), 130), (ValueError("odd"), 1), (MemoryError(), 1)]
)
def test_what_was_written_before_is_said(
    fault: BaseException, code: int, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import elastocal.terminal.plans as shown

    def fail(*_: object) -> None:
        raise fault

    monkeypatch.setattr(shown, "show_plan", fail)
    result = run("plan", "study.yaml")
    assert result.exit_code == code
    assert "plan.json and plan.csv were written" in result.stderr
    assert "no file was changed" not in result.stderr
    monkeypatch.undo()
    os.chdir(folder)
    again = run("check", "study.yaml", "--picture", "nowhere/a.svg")
    assert "written" not in again.stderr


def test_one_command_does_not_tell_what_another_wrote(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run("init", "new.yaml").exit_code == 0

    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(study_check, "check", stop)
    assert run("check", "study.yaml").stderr == "stopped; no file was changed\n"


def test_a_stop_before_any_command(monkeypatch: pytest.MonkeyPatch) -> None:
    """While arguments are read, too: it ended without a word."""
    import typer.core

    def stop(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(typer.core.TyperGroup, "make_context", stop)
    result = run("check", "study.yaml")
    assert (result.exit_code, result.stderr) == (130, "stopped; no file was changed\n")


def test_files_that_belong_together_are_not_parted() -> None:
    done = []

    def write() -> None:
        with undisturbed():
            signal.raise_signal(signal.SIGINT)
            done.append("first")
            done.append("second")
        done.append("after")

    with pytest.raises(KeyboardInterrupt):
        write()
    assert done == ["first", "second"]
    with pytest.raises(ValueError, match="of its own"), undisturbed():
        raise ValueError("of its own")

    def aside() -> None:
        with undisturbed():
            done.append("aside")

    thread = threading.Thread(target=aside)
    thread.start()
    thread.join()
    assert done[-1] == "aside"


@pytest.mark.skipif(sys.platform == "win32", reason="pipes of POSIX")
@pytest.mark.parametrize(
    ("arguments", "made"),
    [
        (["check", "study.yaml"], None),
        (["compensate", "study.yaml", "truth.json", "path.csv"], "corrected.csv"),
        (["compensate", "study.yaml", "truth.json", "path.csv", "--json"], "corrected.csv"),
        (["--help"], None),
    ],
)
def test_a_reader_that_leaves_takes_nothing_away(
    arguments: list[str], made: str | None, folder: Path
) -> None:
    read, write = os.pipe()
    os.close(read)
    process = program(*arguments, stdout=write)
    os.close(write)
    _, said = process.communicate(timeout=60)
    assert (process.returncode, said) == (0, b"")
    assert made is None or (folder / made).is_file()


@pytest.mark.skipif(not FULL.exists(), reason="no /dev/full")
@pytest.mark.parametrize(
    ("arguments", "so_far"),
    [
        (["check", "study.yaml"], "no file was changed"),
        (["compensate", "study.yaml", "truth.json", "path.csv"], "corrected.csv was written"),
        (["init"], "study.yaml was written"),
    ],
)
def test_a_full_standard_output_is_said(arguments: list[str], so_far: str, folder: Path) -> None:
    if arguments == ["init"]:
        (folder / "study.yaml").unlink()
    with FULL.open("w") as full:
        process = program(*arguments, stdout=full)
        _, said = process.communicate(timeout=60)
    sentence = f"error: standard output cannot be written (No space left on device); {so_far}\n"
    assert (process.returncode, said.decode()) == (2, sentence)


@pytest.mark.skipif(not FULL.exists(), reason="no /dev/full")
def test_where_nothing_can_be_said_the_exit_code_is_right(folder: Path) -> None:
    with FULL.open("w") as full:
        for arguments, code in ((["check", "study.yaml"], 2), (["check", "nowhere.yaml"], 2)):
            command = [sys.executable, "-m", "elastocal", *arguments]
            assert subprocess.run(command, stdout=full, stderr=full, check=False).returncode == code


def test_a_write_that_fails_leaves_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a full disk; the old file stays."""

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    assert run("compensate", "study.yaml", "truth.json", "path.csv").exit_code == 0
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    monkeypatch.setattr(os, "replace", full)
    result = run("compensate", "study.yaml", "truth.json", "path.csv")
    assert result.exit_code == 2
    assert "corrected.csv: cannot be written (No space left on device)" in result.stderr
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_half_a_pair_is_said(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole, calls = os.replace, []

    def full(name: str, path: Path) -> None:
        calls.append(path)
        if len(calls) > 1:
            raise OSError(28, "No space left on device")
        whole(name, path)

    monkeypatch.setattr(os, "replace", full)
    result = run("plan", "study.yaml")
    assert result.exit_code == 2
    assert result.stderr == (
        "error: plan.csv: cannot be written (No space left on device); plan.json was written\n"
    )


def test_signs_that_steer_are_escapes() -> None:
    shown = visible(f"µ a\tb\n{HOSTILE}")
    assert shown.startswith("µ a\tb\n\\u001b]0;x\\u0007")
    assert shown.isprintable() or set(shown) - set("\t\n") == {c for c in shown if c.isprintable()}
    assert visible("σ = 3 µm, 中文, \U0001f600") == "σ = 3 µm, 中文, \U0001f600"


def test_tables_do_not_steer(capsys: pytest.CaptureFixture[str]) -> None:
    table = Table(f"head {HOSTILE}")
    table.add_row(Text(f"cell {HOSTILE}"))
    out.print(f"text {HOSTILE}", table, markup=False)
    whole(table)
    shown = capsys.readouterr().out
    assert not [c for c in shown if not c.isprintable() and c != "\n"]
    assert shown.count("\\u001b") >= 3


def test_nothing_named_on_the_command_line_steers(folder: Path) -> None:
    name = f"a{HOSTILE.replace(chr(0), '')}"
    for arguments in (["check", name], [name], ["check", f"--{name}"], ["plan", "x", "-o", name]):
        result = run(*arguments)
        assert result.exit_code == 2
        assert not [c for c in result.output if not c.isprintable() and c != "\n"], result.output


def test_files_with_odd_names_are_written_and_said(folder: Path) -> None:
    odd = "\x1b[2Jµ\u202e.csv"
    result = run("compensate", "study.yaml", "truth.json", "path.csv", "-o", odd)
    assert result.exit_code == 0, result.stderr
    assert "\\u001b[2Jµ\\u202e.csv" in result.stdout
    assert (folder / odd).is_file()


@pytest.mark.skipif(sys.platform != "linux", reason="names of files are bytes there")
def test_a_name_that_is_no_text(folder: Path) -> None:
    raw = os.fsencode(folder) + b"/caf\xe9.yaml"
    Path(os.fsdecode(raw)).write_text(STUDY, encoding="utf-8")
    process = program("check", os.fsdecode(raw), stdout=subprocess.PIPE)
    shown, said = process.communicate(timeout=60)
    assert (process.returncode, said) == (0, b"")
    assert b"three-link" in shown
    missing = program("check", os.fsdecode(raw).replace("caf", "the"), stdout=subprocess.PIPE)
    _, said = missing.communicate(timeout=60)
    assert (missing.returncode, b"\\udce9.yaml: no such file" in said) == (2, True)


def test_json_stays_json(capsys: pytest.CaptureFixture[str]) -> None:
    """Its own escapes are those that output is given."""
    with safe_output():
        print_json({HOSTILE: "µ"})
    shown = capsys.readouterr().out
    assert shown.isprintable() or set(shown) == {c for c in shown if c.isprintable()} | {"\n"}
    assert json.loads(shown) == {HOSTILE: "µ"}
