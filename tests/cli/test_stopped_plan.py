"""Ctrl-C and --seconds while `plan` searches: the best so far is written, and says what it is."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import elastocal.cli.planning as planning
from elastocal.cli.stopping import SearchEnd
from tests.cli.test_commands import STUDY, run

NOW = planning.plan


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A study to plan; Ctrl-C works, also where tests run in the background."""
    (tmp_path / "study.yaml").write_text(STUDY, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield tmp_path
    signal.signal(signal.SIGINT, before)


def interrupted(monkeypatch: pytest.MonkeyPatch, *moments: int | str) -> None:
    """Ctrl-C when the planner asks for that time, or when it tells of that."""

    def plan(*args: Any, progress: Any, stop: Any, **options: Any) -> Any:
        asked: list[bool] = []

        def tell(what: str, share: float) -> None:
            progress(what, share)
            if any(isinstance(moment, str) and moment in what for moment in moments):
                signal.raise_signal(signal.SIGINT)

        def enough() -> bool:
            asked.append(stop())
            if len(asked) in moments:
                signal.raise_signal(signal.SIGINT)
            return stop()

        return NOW(*args, progress=tell, stop=enough, **options)

    monkeypatch.setattr(planning, "plan", plan)


def test_the_best_so_far_is_written(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupted(monkeypatch, 3)
    result = run("plan", "study.yaml")
    assert result.exit_code == 0, result.stderr
    assert "Weak: the search was stopped before its end, after 1 generation of plans" in (
        said := " ".join(result.stdout.split())
    )
    assert "No certificate: the search was stopped before its bound had been tried" in said
    assert "wrote plan.json and plan.csv" in said
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    assert document["searches"]["stopped_after"] == 1
    assert document["certificate"]["kind"] == "none"
    assert "search-stopped" in {doubt["code"] for doubt in document["doubts"]}
    monkeypatch.undo()
    monkeypatch.chdir(folder)
    judged = run("evaluate", "study.yaml", "plan.json", "--random", "0")
    assert judged.exit_code == 0, judged.stderr
    assert "the search was stopped before its end" in " ".join(judged.stdout.split())
    document["searches"]["stopped_after"] = -1
    (folder / "odd.json").write_text(json.dumps(document), encoding="utf-8")
    refused = run("evaluate", "study.yaml", "odd.json")
    assert refused.exit_code == 2
    assert "stopped_after" in refused.stderr


def test_before_there_is_a_plan_nothing_is_written(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    interrupted(monkeypatch, "first plans")
    result = run("plan", "study.yaml")
    assert (result.exit_code, result.stderr) == (130, "stopped; no file was changed\n")
    assert not (folder / "plan.json").exists()


def test_a_second_one_stops_at_once(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupted(monkeypatch, 3, "ways between configurations")
    result = run("plan", "study.yaml")
    assert (result.exit_code, result.stderr) == (130, "stopped; no file was changed\n")
    assert not (folder / "plan.json").exists()


def test_one_that_comes_when_all_is_found_changes_nothing(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run("plan", "study.yaml", "-o", "whole.json").exit_code == 0
    interrupted(monkeypatch, "ways between configurations")
    assert run("plan", "study.yaml").exit_code == 0
    assert (folder / "plan.json").read_bytes() == (folder / "whole.json").read_bytes()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_time_to_search(folder: Path) -> None:
    """However short it is there is a plan; a long one changes nothing."""
    for seconds in ("0", "1000"):
        assert run("plan", "study.yaml", "--seconds", seconds, "-o", f"{seconds}.json")
    assert run("plan", "study.yaml").exit_code == 0
    short, long, whole = (
        json.loads((folder / name).read_text(encoding="utf-8"))
        for name in ("0.json", "1000.json", "plan.json")
    )
    assert short["searches"]["stopped_after"] == 1
    assert long == whole
    refused = run("plan", "study.yaml", "--seconds", "-1")
    assert refused.exit_code == 2


def test_an_interrupt_that_is_not_ours_is_left_alone(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    interrupted(monkeypatch, 3)
    assert run("plan", "study.yaml").exit_code == 0
    document = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    assert "stopped_after" not in document["searches"]


def test_what_is_told_after_the_first_one() -> None:
    told: list[str] = []
    end = SearchEnd(lambda what, _: told.append(what))
    end.tell("first plans", 0.0)
    with pytest.raises(KeyboardInterrupt):
        end.interrupt()
    assert not end()
    end.interrupt()
    assert end()
    assert told == ["first plans", "finishing, Ctrl-C again drops it: first plans"]
    with pytest.raises(KeyboardInterrupt):
        end.interrupt()
