"""Output as it is safe to show, and as terminal and pipe can take it.

What is printed has words of strangers in it: names, file names, messages of libraries. Signs that
would steer the terminal are shown as escapes. Where the terminal or the pipe cannot write all
signs they get their nearest plain spelling: µm must not become ?m. A reader that left, as `head`
does, takes nothing from the work that is done.
"""

from __future__ import annotations

import codecs
import io
import os
import re
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

_STEERING = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters but for tab and line feed
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # direction of writing
    "\u2028\u2029\ufeff\ufff9-\ufffb\ud800-\udfff]"  # line breaks, marks, half characters
)

_PLAIN = {
    "µ": "u",
    "σ": "sigma",
    "ρ": "rho",
    "χ": "chi",
    "φ": "phi",
    "²": "2",
    "₀": "0",
    "±": "+/-",
    "°": "deg",
    "·": ".",
    "×": "x",
    "√": "sqrt",
    "≥": ">=",
    "≤": "<=",
    "→": "->",
    "–": "-",
    "−": "-",
    "…": "...",
    "∞": "inf",
    "─": "-",
    "│": "|",
    "●": "o",
    "’": "'",
}


def _spelt(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    signs = error.object[error.start : error.end]
    return "".join(_PLAIN.get(sign) or _escaped(sign) for sign in signs), error.end


def _escaped(sign: str) -> str:
    """As in Python strings: a file name must stay the name of one file."""
    return sign.encode("ascii", "backslashreplace").decode("ascii")


def spell_what_cannot_be_written() -> None:
    """From now on, output in a narrow encoding never fails."""
    codecs.register_error("elastocal-plain", _spelt)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="elastocal-plain")


def visible(text: str) -> str:
    """The text with signs that would steer the terminal as escapes, such as \\u001b."""
    if text.isascii() and text.isprintable():
        return text
    return _STEERING.sub(lambda found: f"\\u{ord(found[0]):04x}", text)


class _Screen:
    """A stream of the program: what is written to it is shown, or lost in silence.

    Attributes:
        lost: Why it could not be written to, None if nobody listens any more or nothing failed.
        rich_proxied_file: The same stream for rich, which steers the terminal with reason.
    """

    def __init__(self, stream: TextIO, shown: Callable[[str], str] = visible) -> None:
        self._stream, self._shown = stream, shown
        self.lost: OSError | None = None
        self.rich_proxied_file = self if shown is not visible else _Screen(stream, str)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write the text; all of it is taken."""
        self._try(lambda: self._stream.write(self._shown(text)))
        return len(text)

    def flush(self) -> None:
        """Hand on what was written."""
        self._try(self._stream.flush)

    def why_lost(self) -> OSError | None:
        """Why something could not be written, None if all was, or if nobody listened."""
        self.flush()
        return self.lost or self.rich_proxied_file.lost

    def _try(self, do: Callable[[], object]) -> None:
        try:
            do()
        except OSError as error:
            if not isinstance(error, BrokenPipeError):
                self.lost = self.lost or error
            # What is in the buffer would fail again at the end: there it goes.
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)


@contextmanager
def safe_output() -> Iterator[Callable[[], OSError | None]]:
    """Within it, output is safe to show; gives a function that tells why some was lost."""
    before = sys.stdout, sys.stderr
    screens = [None if stream is None else _Screen(stream) for stream in before]
    sys.stdout, sys.stderr = cast(list[TextIO], screens)
    try:
        yield lambda: screens[0].why_lost() if screens[0] is not None else None
    finally:
        for screen in screens:
            if screen is not None:
                screen.flush()
        sys.stdout, sys.stderr = before
