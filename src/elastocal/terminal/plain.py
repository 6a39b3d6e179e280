"""Output where the terminal or the pipe cannot write all signs: their nearest plain spelling.

A unit must stay readable: µm must not become ?m.
"""

from __future__ import annotations

import codecs
import io
import sys

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
