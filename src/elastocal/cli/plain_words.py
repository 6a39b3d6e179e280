"""Plain words of the command line as values, without what typer loads to convert them.

From 0.28 on typer has pydantic convert every word, which takes longer to load than all else that
is needed before a command runs. Words that are plainly of their type are taken here; all others,
and what is said of them, are left to typer.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal, get_args, get_origin


class PlainWord:
    """Stands in for what converts the words of one parameter.

    Attributes:
        hint: The type of the parameter.
    """

    def __init__(self, hint: Any) -> None:
        self.hint = hint

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """The value of words, as typer asks for it."""
        if value is None:
            return () if param.multiple or param.nargs == -1 else None
        try:
            return _value(value, self.hint, param.type_descriptor.parameter_info)
        except ValueError:
            param._runtime_param = None
            return param.get_runtime_param().coerce(value, param=param, ctx=ctx)


def take_plain_words(params: list[Any], hints: dict[str, Any]) -> None:
    """Convert plain words here, where this version of typer has a place for it.

    Args:
        params: Parameters of a command.
        hints: Their types, by name; all others are flags.
    """
    for param in params:
        if getattr(param, "_runtime_param", param) is None:
            param._runtime_param = PlainWord(hints.get(param.name, bool))


def _value(word: Any, hint: Any, asked: Any) -> Any:
    """One word, or several.

    Raises:
        ValueError: it is not plain, or not as it is asked for.
    """
    kinds = [kind for kind in get_args(hint) if kind is not type(None)]
    if type(None) in get_args(hint) and len(kinds) == 1:
        return _value(word, kinds[0], asked)
    origin = get_origin(hint)
    if origin is list and isinstance(word, (list, tuple)):
        return [_value(one, kinds[0], asked) for one in word]
    if origin is tuple and isinstance(word, (list, tuple)):
        return tuple(_value(one, kind, asked) for one, kind in zip(word, kinds, strict=True))
    if (origin is Literal and word in kinds) or (hint in (bool, str) and isinstance(word, hint)):
        return word
    if hint is Path and isinstance(word, (str, Path)):
        path = Path(word)
        if os.access(path, os.R_OK) or not path.exists():
            return path
    if hint in (int, float) and isinstance(word, (str, int, float)) and not isinstance(word, bool):
        number = hint(word)
        if (asked.min is None or number >= asked.min) and (
            asked.max is None or number <= asked.max
        ):
            return number
    raise ValueError
