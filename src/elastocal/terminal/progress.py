"""What is said while something runs: a bar on a terminal, now and then a line off one.

Written here and not with rich, which takes longer to load than short work takes.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Event, Lock, Thread
from time import monotonic
from typing import IO

from elastocal.planning.certificate import Progress as Tell
from elastocal.terminal.plain import visible

SILENCE = 5.0
"""How long something may run without a word where there is no terminal [s]."""
_PAUSE = 0.1
"""Between two bars [s]; what is done sooner gets none."""
_BAR = 30
"""Signs of a bar."""


@contextmanager
def progress(title: str) -> Iterator[Tell]:
    """A bar on standard error while something runs; a line every few seconds off a terminal."""
    with progress_and_lines(title) as (tell, _):
        yield tell


@contextmanager
def progress_and_lines(title: str) -> Iterator[tuple[Tell, Callable[[str], None]]]:
    """The same, and what says a line that stays."""
    # What steers the terminal here is our own; what others say is made visible below.
    stream: IO[str] = getattr(sys.stderr, "rich_proxied_file", sys.stderr)
    terminal = stream.isatty()
    begun, ended, now, shown = monotonic(), Event(), [(title, 0.0)], False
    lock, last = Lock(), [monotonic()]

    def speak() -> None:
        nonlocal shown
        while not ended.wait(_PAUSE if terminal else min(SILENCE, _left())):
            if not terminal and _left() > 0.0:
                continue
            (what, share), seconds = now[0], monotonic() - begun
            what = visible(what)
            with lock:
                line = _bar(what, share, seconds) if terminal else f"{what} ({seconds:.0f} s)\n"
                _say(line, stream)
                shown, last[0] = True, monotonic()

    def _left() -> float:
        """Seconds until something has to be said."""
        return max(SILENCE - (monotonic() - last[0]), 0.0)

    def clear() -> None:
        if terminal and shown:
            _say("\r" + " " * _room() + "\r", stream)

    def stay(line: str) -> None:
        with lock:
            clear()
            _say(f"{visible(line)}\n", stream)
            last[0] = monotonic()

    speaker = Thread(target=speak, daemon=True)
    speaker.start()
    try:
        yield lambda what, share: now.__setitem__(0, (f"{title}: {what}", share)), stay
    finally:
        ended.set()
        speaker.join()
        clear()


def _say(text: str, stream: IO[str]) -> None:
    with suppress(OSError, ValueError):  # a log that is full or closed stops nothing
        stream.write(text)
        stream.flush()


def _bar(what: str, share: float, seconds: float) -> str:
    """A bar over the one that is there: as long as the line, and cut if need be."""
    done, room = round(_BAR * min(max(share, 0.0), 1.0)), _room()
    bar = f" [{'#' * done}{'.' * (_BAR - done)}] {seconds:.0f} s"
    return "\r" + f"{what[: max(room - len(bar), 10)]}{bar}"[:room].ljust(room)


def _room() -> int:
    """Signs of a line that the terminal does not break."""
    return shutil.get_terminal_size().columns - 1
