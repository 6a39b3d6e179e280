"""Ctrl-C at any time: old output stays whole, nothing half-written is left behind."""

from __future__ import annotations

import os
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
DELAYS = (0.05, 0.25, 0.6, 1.2)


def run(arguments: list[str], folder: Path, stop_after: float | None = None) -> int:
    """Exit code of a command that is interrupted after some seconds, if it still runs then."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    process = subprocess.Popen(
        [sys.executable, "-m", "elastocal", *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    if stop_after is not None:
        time.sleep(stop_after)
        process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=120)
    # Before Python itself has started there is nobody to catch a signal.
    assert "Traceback" not in errors or "site.py" in errors or "frozen" in errors, errors
    return process.returncode


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan and measurements to work on."""
    folder = tmp_path_factory.mktemp("made")
    assert run(["plan", STUDY, "-o", "plan.json"], folder) == 0
    simulated = ["simulate", STUDY, "plan.csv", "--truth", TRUTH, "-o", "measured.csv"]
    assert run(simulated, folder) == 0
    return folder


@pytest.mark.parametrize("name", COMMANDS)
def test_old_output_stays_whole(name: str, made: Path, tmp_path: Path) -> None:
    for file in made.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    arguments = COMMANDS[name]
    out = tmp_path / arguments[-1]
    before = {path.name for path in tmp_path.iterdir()} | {out.name, "out.csv", "out.dat"}
    for delay in DELAYS:
        out.write_text(OLD, encoding="utf-8")
        code = run(arguments, tmp_path, delay)
        text = out.read_text(encoding="utf-8")
        assert code in (0, 130, -signal.SIGINT), code
        assert (text == OLD) or code == 0 or text.endswith(("\n", ">")), text[-200:]
        left = {path.name for path in tmp_path.iterdir()} - before
        assert not {name for name in left if name.startswith(".")}, left
