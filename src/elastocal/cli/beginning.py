"""How every command begins: it says what it reads before it loads what it needs for that."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

_READ_FIRST = ("study_file", "plan_file")
"""Parameters that name what a command reads first."""


def say_what_is_read(given: Mapping[str, Any]) -> None:
    """A line on standard error, for people alone: not off a terminal, not beside JSON.

    Args:
        given: The parameters of the command.
    """
    if sys.stderr is None or not sys.stderr.isatty() or given.get("as_json"):
        return
    for name in _READ_FIRST:
        if given.get(name) is not None:
            print(f"reading {given[name]}", file=sys.stderr, flush=True)
            return
