"""Numbers on the command line are decimal, in every option of every command."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, get_args, get_type_hints

import pytest
import typer.main

from elastocal.cli import app
from elastocal.cli.inputs import joint_values
from elastocal.cli.number_options import flaw
from elastocal.errors import InputError
from elastocal.robot.sources import load
from tests.cli.test_commands import run

ODD = ("1_2", " 12", "１２", "012", "0x1", "1,5", "nan", "", "1e30", "-inf", "²")


def options() -> Iterator[tuple[str, str, int]]:
    """Command, option and how many numbers it takes, of all that take numbers."""
    commands: Any = typer.main.get_command(app)
    for name, command in commands.commands.items():
        hints = get_type_hints(command.callback)
        for param in command.params:
            hint = hints.get(param.name)
            parts = [p for part in (hint, *get_args(hint)) for p in (part, *get_args(part))]
            if {int, float} & {part for part in parts if isinstance(part, type)}:
                yield name, param.opts[0], param.nargs


@pytest.mark.parametrize(("command", "option", "count"), [*options()])
def test_odd_numbers_are_refused(command: str, option: str, count: int) -> None:
    for word in ODD:
        result = run(command, option, *(count - 1) * ["1"], word)
        said = " ".join(result.stderr.split())
        assert result.exit_code == 2, (word, said)
        assert f"Invalid value for '{option}'" in said, said
        assert "expected a" in said, said


def test_all_kinds_of_options_are_looked_at() -> None:
    found = {(command, option) for command, option, _ in options()}
    assert {("plan", "--count"), ("plan", "--seed"), ("compensate", "--force-n")} <= found
    assert {("view", "--port"), ("identify", "--confidence")} <= found
    assert len(found) > 25


@pytest.mark.parametrize("word", ["12", "+12", "-3", "0"])
def test_whole_numbers_are_taken(word: str) -> None:
    assert not flaw(word, whole=True)


@pytest.mark.parametrize("word", ["12", "1e1", ".5", "5.", "-2500", "+1.5E-3"])
def test_numbers_are_taken(word: str) -> None:
    assert not flaw(word)


@pytest.mark.parametrize("word", ["1e1", "1.0", "1."])
def test_counts_are_whole(word: str) -> None:
    assert flaw(word, whole=True) == f"expected a whole number, found {word!r}"


@pytest.mark.parametrize("word", ["1_0", "010", "٣", "..", "1.2.3"])
def test_joint_values_are_decimal(word: str) -> None:
    with pytest.raises(InputError, match="start: joint 'J2': expected a number"):
        joint_values(f"J1=0deg J2={word}deg J3=1e1deg", load("three-link"), "start")
