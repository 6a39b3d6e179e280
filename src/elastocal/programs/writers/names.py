"""Texts and names that a controller takes: ASCII that ends nothing, and names of one program each.

`plain` is what every text goes through that lands in a program, wherever it stands there.
"""

from __future__ import annotations

import base64
import hashlib
import re
import unicodedata
from collections.abc import Iterable

from elastocal.errors import InputError
from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers.settings import Settings

_SPELT = str.maketrans(
    {"ß": "ss", "ø": "o", "Ø": "O", "æ": "ae", "Æ": "Ae", "ł": "l", "Ł": "L", "°": " deg "}
)

_HARMLESS = str.maketrans({'"': "'", "\\": "/", ";": ",", "[": "(", "]": ")", "{": "(", "}": ")"})
DEVICES = frozenset(
    ["CON", "PRN", "AUX", "NUL", *(f"{port}{i}" for port in ("COM", "LPT") for i in range(10))]
)
"""Names that no file has on Windows, whatever its ending."""
_BEFORE_A_STOP = re.compile(r"\b(deg|percent) (?=[.,:)])")
_DIGEST = 6  # signs of the digest that a made name ends in: 30 bits


def ascii_text(text: str) -> str:
    """Text on one line in printable ASCII: accents taken off, the rest replaced by '?'."""
    plain = unicodedata.normalize("NFKD", text.translate(_SPELT))
    plain = "".join(c for c in plain if not unicodedata.combining(c))
    plain = re.sub(r"[–—−]", "-", plain).replace("·", ".").replace("×", "x")
    return " ".join(
        "".join(c if " " <= c <= "~" else "?" if c.isprintable() else " " for c in plain).split()
    )


def plain(text: str) -> str:
    """Text on one line of ASCII without any sign that ends a string, a comment or an instruction.

    Quotes end strings, backslashes change what follows, brackets end messages and semicolons
    instructions of FANUC; percent signs in messages of KUKA stand for what is not there.
    """
    line = " ".join(ascii_text(text).translate(_HARMLESS).replace("%", " percent ").split())
    return _BEFORE_A_STOP.sub(r"\1", line)


def program_name(
    program: RobotProgram,
    settings: Settings,
    controller: str,
    longest: int,
    reserved: Iterable[str] = (),
) -> str:
    """The name of a program at its controller and on disk.

    A name that is made ends in a digest of the program's name and of what it was made from, so
    two programs never have one name, also where letters of both cases are the same.

    Raises:
        InputError: `settings.name` is not a name there.
    """
    taken = {*reserved, *DEVICES}
    if settings.name:
        made = identifier(settings.name, longest, taken)
        if made != settings.name:
            raise InputError(
                f"{settings.name}: not a program name for {controller}, {made!r} would be one"
            )
        return made
    base = identifier(program.name, longest - _DIGEST - 1)
    content = repr((program.name, program.provenance.sources)).encode("utf-8", "backslashreplace")
    digest = base64.b32encode(hashlib.sha256(content).digest())[:_DIGEST].decode().lower()
    return f"{base}_{digest}"


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
