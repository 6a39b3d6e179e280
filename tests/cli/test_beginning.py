"""What commands say first, and how plain words become values."""

from __future__ import annotations

import io
from contextlib import redirect_stderr
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import pytest

from elastocal.cli.beginning import say_what_is_read
from elastocal.cli.plain_words import PlainWord


class Terminal(io.StringIO):
    """A stream that is a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(
    ("stream", "given", "said"),
    [
        (Terminal(), {"study_file": Path("study.yaml"), "as_json": False}, "reading study.yaml\n"),
        (Terminal(), {"plan_file": Path("plan.json")}, "reading plan.json\n"),
        (Terminal(), {"study_file": None, "plan_file": Path("p.csv")}, "reading p.csv\n"),
        (Terminal(), {"study_file": Path("study.yaml"), "as_json": True}, ""),
        (Terminal(), {"path": Path("study.yaml")}, ""),
        (io.StringIO(), {"study_file": Path("study.yaml")}, ""),
    ],
)
def test_what_is_read_is_said_on_a_terminal(
    stream: io.StringIO, given: dict[str, Any], said: str
) -> None:
    with redirect_stderr(stream):
        say_what_is_read(given)
    assert stream.getvalue() == said


def param(**asked: Any) -> Any:
    """A parameter as typer has them, that says "typer" to whatever it converts itself."""
    info = SimpleNamespace(**({"min": None, "max": None} | asked))
    return SimpleNamespace(
        multiple=False,
        nargs=1,
        type_descriptor=SimpleNamespace(parameter_info=info),
        get_runtime_param=lambda: SimpleNamespace(coerce=lambda *_, **__: "typer"),
    )


@pytest.mark.parametrize(
    ("hint", "word", "value"),
    [
        (int, "12", 12),
        (int | None, None, None),
        (float | None, "1e1", 10.0),
        (Path, "no/such/file", Path("no/such/file")),
        (list[Path] | None, ("a", "b"), [Path("a"), Path("b")]),
        (tuple[float, float] | None, ("1", "-2"), (1.0, -2.0)),
        (Literal["known", "estimated"], "known", "known"),
        (Literal["known", "estimated"], "Known", "typer"),
        (str | None, "word", "word"),
        (bool, True, True),
        (int, "1.5", "typer"),
        (int, "-1", "typer"),
        (int, True, "typer"),
        (tuple[float, float], ("1",), "typer"),
        (dict, "a", "typer"),
    ],
)
def test_plain_words_are_taken_and_others_left_to_typer(hint: Any, word: Any, value: Any) -> None:
    assert PlainWord(hint).coerce(word, param(min=-0.5 if hint is int else None), None) == value
