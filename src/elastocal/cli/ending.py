"""How every command ends: a sentence and an exit code, whatever happens."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from typer.core import TyperGroup

from elastocal.cli.plain_words import take_plain_words
from elastocal.errors import ElastocalError
from elastocal.terminal.plain import safe_output
from elastocal.writing import WRITTEN

STOPPED = 130
TRACEBACK = "ELASTOCAL_TRACEBACK"
"""Environment variable that asks for the traceback of a fault of ours."""
_LISTED = 6


class Commands(TyperGroup):
    """All commands; what they say is safe to show, and how they end is said truly."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Take what stands before the name of the command."""
        take_plain_words([*self.get_params(ctx)], {})
        return super().parse_args(ctx, args)

    def main(self, *args: Any, **kwargs: Any) -> Any:
        """Run one command; ends the program."""
        written: list[Path] = []
        token = WRITTEN.set(written)
        try:
            with safe_output() as why_lost:
                code = _ended(lambda: super(Commands, self).main(*args, **kwargs), written)
                if code == STOPPED:
                    print(f"stopped; {_so_far(written)}", file=sys.stderr)
                elif lost := why_lost():
                    _say(f"standard output cannot be written ({lost.strerror}); {_so_far(written)}")
                    code = code or 2
        finally:
            WRITTEN.reset(token)
        sys.exit(code)


@contextmanager
def undisturbed() -> Iterator[None]:
    """Within it Ctrl-C waits: files that belong together are written together."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: asked.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if asked:
        signal.raise_signal(signal.SIGINT)


def _ended(run: Callable[[], object], written: list[Path]) -> int:
    """The exit code of a command, after what there is to say about it."""
    try:
        run()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0
    except ElastocalError as error:
        _say(f"{error}{'; ' + _so_far(written) if written else ''}")
        return error.exit_code
    except KeyboardInterrupt:
        return STOPPED
    except OSError as error:
        about = f"{error.filename}: " if error.filename else ""
        _say(f"{about}{error.strerror or error}; {_so_far(written)}")
        return 2
    except MemoryError:
        _say(f"not enough memory for this; {_so_far(written)}")
        return 1
    except Exception as error:
        _say_fault(error, written)
        return 1
    return 0


def _say(sentence: str) -> None:
    """A sentence on one line of standard error."""
    print("error: " + sentence.replace("\n", "\\n"), file=sys.stderr)


def _say_fault(error: Exception, written: list[Path]) -> None:
    """What only a fault of ours can be."""
    shown = os.environ.get(TRACEBACK)
    if shown:
        import traceback

        traceback.print_exception(error, file=sys.stderr)
    reason = next(iter(str(error).splitlines()), "")[:200]
    what = f"{type(error).__name__}{': ' if reason else ''}{reason}"
    hint = "" if shown else f"; with {TRACEBACK}=1 it says where"
    _say(f"this is a fault of elastocal: {what}; {_so_far(written)}{hint}")


def _so_far(written: list[Path]) -> str:
    """What was written, as the end of a sentence."""
    names = list(dict.fromkeys(map(str, written)))
    if not names:
        return "no file was changed"
    more = [f"{len(names) - _LISTED} more"] if len(names) > _LISTED else []
    names = names[:_LISTED] + more
    listed = ", ".join(names[:-1]) + " and " + names[-1] if len(names) > 1 else names[0]
    return f"{listed} {'were' if len(names) > 1 else 'was'} written"
