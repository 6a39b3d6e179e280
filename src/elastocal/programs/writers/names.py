"""Names that a controller takes: letters, digits and underscores, short enough, not reserved."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable

_SPELT = str.maketrans(
    {"ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "Æ": "Ae", "ł": "l", "Ł": "L", "°": " deg "}
)


def ascii_text(text: str) -> str:
    """Text on one line in printable ASCII: accents taken off, the rest replaced by '?'."""
    plain = unicodedata.normalize("NFKD", text.translate(_SPELT))
    plain = "".join(c for c in plain if not unicodedata.combining(c))
    plain = re.sub(r"[–—−]", "-", plain).replace("·", ".").replace("×", "x")
    return " ".join(
        "".join(c if " " <= c <= "~" else "?" if c.isprintable() else " " for c in plain).split()
    )


def identifier(text: str, longest: int, reserved: Iterable[str] = ()) -> str:
    """A name made of any text, at most `longest` characters, first a letter.

    Reserved words are compared without regard to case and get an underscore and a number.
    """
    words = re.findall(r"[A-Za-z0-9]+", ascii_text(text))
    name = "_".join(words) or "PROGRAM"
    if not name[0].isalpha():
        name = f"P_{name}"
    name = name[:longest].rstrip("_")
    taken = {word.upper() for word in reserved}
    base, number = name, 1
    while name.upper() in taken:
        tail = f"_{number}"
        name = base[: longest - len(tail)].rstrip("_") + tail
        number += 1
    return name


def words(text: str) -> frozenset[str]:
    """The words of a text, as a set."""
    return frozenset(text.split())
