"""Ctrl-C at any time: old output stays whole, nothing half-written is left behind."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.test_examples import ROOT

EXAMPLE = ROOT / "examples" / "kr270"
OLD = "made before"
STUDY, TRUTH = str(EXAMPLE / "study.yaml"), str(EXAMPLE / "truth.json")
COMMANDS = {
    "plan": ["plan", STUDY, "-o", "out.json"],
    "simulate": ["simulate", STUDY, "plan.csv", "--truth", TRUTH, "-o", "out.csv"],
    "campaigns": [
        "simulate", STUDY, "plan.csv", "--truth", TRUTH, "--campaigns", "20000", "-o", "out.json",
    ],
    "identify": ["identify", STUDY, "measured.csv", "-o", "out.json"],
    "compensate": ["compensate", STUDY, TRUTH, str(EXAMPLE / "path.csv"), "-o", "out.csv"],
    "report": ["report", "plan.json", "-o", "out.html"],
    "export": ["export", "plan.json", "--to", "krl", "-o", "out.src"],
}  # fmt: skip
STOPPED = "stopped; no file was changed\n"
MOMENTS = (
    ("elastocal", 0.0), ("elastocal.cli", 0.05),  # the program is loading
    ("numpy", 0.0), ("numpy", 0.6),  # a command is at work
)  # fmt: skip
"""When to interrupt: the module that must have been imported, and how long after that [s]."""


def started(arguments: list[str], folder: Path, log: Path) -> subprocess.Popen[str]:
    """A command that logs its imports, the signs of its life, with what else it says."""
    with log.open("w", encoding="utf-8") as stream:
        return subprocess.Popen(
            [sys.executable, "-X", "importtime", "-m", "elastocal", *arguments],
            cwd=folder,
            env=os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
            stdout=subprocess.DEVNULL,
            stderr=stream,
            text=True,
        )


def said(log: Path) -> str:
    """What a program wrote besides its imports."""
    lines = log.read_text(encoding="utf-8").splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith("import time:"))


def stopped(
    arguments: list[str], folder: Path, log: Path, module: str, delay: float
) -> tuple[int, str]:
    """Exit code and words of a command that is interrupted once it lives, if it still runs."""
    process = started(arguments, folder, log)
    sign = re.compile(rf"\| *{re.escape(module)}$", re.MULTILINE)
    while process.poll() is None and not sign.search(log.read_text(encoding="utf-8")):
        time.sleep(0.01)
    time.sleep(delay)
    process.send_signal(signal.SIGINT)
    return process.wait(timeout=120), said(log)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan and measurements to work on."""
    folder = tmp_path_factory.mktemp("made")
    simulated = ["simulate", STUDY, "plan.csv", "--truth", TRUTH, "-o", "measured.csv"]
    for arguments in (["plan", STUDY, "-o", "plan.json"], simulated):
        assert started(arguments, folder, folder.with_suffix(".log")).wait(timeout=120) == 0
    return folder


@pytest.mark.parametrize("name", COMMANDS)
def test_old_output_stays_whole(name: str, made: Path, tmp_path: Path) -> None:
    for file in made.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    arguments = [*COMMANDS[name], "--force"]
    out = tmp_path / COMMANDS[name][-1]
    before = {path.name for path in tmp_path.iterdir()} | {out.name, "out.csv", "out.dat"}
    log = tmp_path.with_suffix(".log")
    for module, delay in MOMENTS:
        out.write_text(OLD, encoding="utf-8")
        code, errors = stopped(arguments, tmp_path, log, module, delay)
        text = out.read_text(encoding="utf-8")
        assert "elastocal/" not in errors, errors  # no frame of ours in any traceback
        # Python itself, when it is done with us, may end in any way. Stopped in code made from a
        # string, as a dataclass is, it ends by the signal at last, whoever caught that.
        assert code in (0, 130, -signal.SIGINT) or "Traceback" in errors, errors
        assert errors == STOPPED or "Traceback" in errors or text != OLD or module != "numpy"
        assert code != 130 or "stopped; " in errors or "Traceback" in errors, "without a word"
        if "stopped; " in errors:
            assert ("no file was changed" in errors) == (text == OLD)
        assert (text == OLD) or code == 0 or text.endswith(("\n", ">")), text[-200:]
        left = {path.name for path in tmp_path.iterdir()} - before
        assert not {name for name in left if name.startswith(".")}, left
