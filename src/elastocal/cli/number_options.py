"""Numbers on the command line: as in files, what everybody reads as the same number.

Python would take 1_2 for 12, and digits of any script.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, get_args, get_type_hints

import typer
from typer.core import TyperCommand

from elastocal.cli.beginning import say_what_is_read
from elastocal.cli.plain_words import take_plain_words


class Command(TyperCommand):
    """A command whose numbers are decimal."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Refuse what is no number, before the numbers are made of it."""
        given, _, _ = self.make_parser(ctx).parse_args(args=list(args))
        wanted = {} if self.callback is None else get_type_hints(self.callback)
        params: list[Any] = [*self.get_params(ctx)]
        take_plain_words(params, wanted)
        for param in params:
            kind, value = _kind(wanted.get(param.name or "")), given.get(param.name)
            if kind is None or value is None or given.get("help"):
                continue
            for word in value if isinstance(value, (list, tuple)) else [value]:
                if isinstance(word, str) and (wrong := flaw(word, whole=kind is int)):
                    raise typer.BadParameter(wrong, ctx=ctx, param=param)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        """Run it; what it reads is said at once."""
        say_what_is_read(ctx.params)
        return super().invoke(ctx)


class Application(typer.Typer):
    """An application whose commands are of that class."""

    def command(self, name: str | None = None, **settings: Any) -> Callable[[Any], Any]:
        """A decorator that makes a function a command, as that of typer does."""
        return super().command(name, cls=Command, **settings)


def flaw(word: str, *, whole: bool = False) -> str:
    """Why a word is no number as files have them, empty if it is one."""
    from elastocal.files.yaml_lines import number

    what = "whole number" if whole else "number"
    value = number(word)
    if value is None or (whole and isinstance(value, float)):
        odd = value is None and any(sign.isdigit() for sign in word)
        hint = " in decimal, without leading zeros, blanks and underscores" if odd else ""
        return f"expected a {what}{hint}, found {word[:40]!r}"
    return "" if abs(value) < 1e30 else f"expected a {what} of ordinary size, found {word[:40]!r}"


def _kind(hint: Any) -> type | None:
    """int or float where a parameter is one, or several of them."""
    parts = [hint, *get_args(hint), *(p for part in get_args(hint) for p in get_args(part))]
    return next((kind for kind in (int, float) if kind in parts), None)
