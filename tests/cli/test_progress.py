"""What is said while something runs, where there is no terminal."""

from __future__ import annotations

import io
import time
from contextlib import redirect_stderr

import numpy as np
import pytest

import elastocal as ec
from elastocal.design.exact import Effort
from elastocal.planning.certificate import lower_bound
from elastocal.terminal import progress
from tests.test_examples import ROOT


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> io.StringIO:
    monkeypatch.setattr(progress, "SILENCE", 0.02)
    return io.StringIO()


def waited(stream: io.StringIO, text: str) -> str:
    """What was said until `text` was."""
    for _ in range(500):
        if text in stream.getvalue():
            break
        time.sleep(0.01)
    return stream.getvalue()


def test_a_line_comes_when_nothing_was_said_for_long(lines: io.StringIO) -> None:
    with redirect_stderr(lines), progress.progress("planning") as tell:
        assert waited(lines, "s)\n").startswith("planning (0 s)\n")
        tell("trying the \x1b[2Jbound", 0.3)
        found = waited(lines, "bound")
    assert found.splitlines()[-1] == "planning: trying the \\u001b[2Jbound (0 s)"
    said = lines.getvalue()
    time.sleep(0.1)
    assert lines.getvalue() == said


def test_lines_that_stay_come_between(lines: io.StringIO, monkeypatch: pytest.MonkeyPatch) -> None:
    """And what is said so counts as a word: the next one need not come sooner."""
    monkeypatch.setattr(progress, "SILENCE", 0.3)
    with redirect_stderr(lines), progress.progress_and_lines("proof") as (tell, stay):
        tell("to 1 %", 0.3)
        for _ in range(8):
            time.sleep(0.05)
            stay("proved: \x1b[2Ja bit")
        assert lines.getvalue().splitlines() == 8 * ["proved: \\u001b[2Ja bit"]
        assert "proof: to 1 % (" in waited(lines, "to 1 %")


def test_nothing_is_said_of_what_is_soon_done(
    lines: io.StringIO, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(progress, "SILENCE", 5.0)
    begun = time.monotonic()
    with redirect_stderr(lines), progress.progress("planning") as tell:
        tell("exact plan", 0.5)
    assert time.monotonic() - begun < 4.0
    assert not lines.getvalue()


def test_a_log_that_takes_nothing_stops_nothing(lines: io.StringIO) -> None:
    with redirect_stderr(lines), progress.progress("planning"):
        lines.close()
        time.sleep(0.1)


def test_a_search_tells_what_there_is_to_gain_at_most() -> None:
    """Against the bound: of the plan that comes out no more than the last that was told."""
    study = ec.read_study(ROOT / "examples" / "three-link" / "study.yaml")
    bound = lower_bound(study, np.random.default_rng(0))
    told: list[tuple[str, float]] = []
    effort = Effort(batch=12, generations=4, islands=1)
    found = ec.plan(study, effort=effort, bound=bound, progress=lambda *what: told.append(what))
    gains = [
        float(what.removesuffix(" % to gain at most").split(": ")[1])
        for what, _ in told
        if "gain" in what
    ]
    assert gains
    assert gains == sorted(gains, reverse=True)
    end = 100.0 * (1.0 - np.sqrt(found.certificate.efficiency))
    assert end <= gains[-1] * 1.05 + 1e-6
    shares = [share for _, share in told]
    assert shares == sorted(shares)
