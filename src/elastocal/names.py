"""What may be a name: one line of signs that can be seen.

Names come from files of strangers and end in robot programs, tables, pages and on screens, where a
line break, an escape sequence or text that runs backwards would be more than a name.
"""

from __future__ import annotations

import unicodedata

LONGEST = 200
"""Longest name [characters]."""
_UNSEEN = {
    "Cc": "a control character",
    "Cf": "a sign that cannot be seen",
    "Cs": "half a character (a lone surrogate)",
    "Cn": "no character",
    "Co": "a sign of private use",
    "Zl": "a line break",
    "Zp": "a line break",
}
_BLANK = {
    *map(chr, (0x34F, 0x115F, 0x1160, 0x17B4, 0x17B5, 0x2800, 0x3164, 0xFFA0)),
    *map(chr, (*range(0x180B, 0x1810), *range(0xFE00, 0xFE10), *range(0xE0100, 0xE01F0))),
}
"""Letters and marks without ink. Source: Unicode, Default_Ignorable_Code_Point; braille blank."""


def flaw(name: str, longest: int = LONGEST) -> str:
    """What is wrong with a name, as the end of a sentence; empty if nothing is.

    Not accepted are control characters, line and paragraph separators, signs that cannot be seen
    (zero width, blank letters, direction of writing), lone surrogates, what is no character, and
    more than `longest` characters.
    """
    if len(name) > longest:
        return f"expected a name of at most {longest} characters, found {len(name)}: {name[:40]!r}"
    if name.isascii() and name.isprintable():
        return ""
    for place, sign in enumerate(name, 1):
        kind = _UNSEEN.get("Cf" if sign in _BLANK else unicodedata.category(sign))
        if kind:
            return (
                f"expected a name on one line of visible signs, found {kind}, U+{ord(sign):04X}, "
                f"at place {place} of {name[:60]!a}"
            )
    return ""


def shown(text: str) -> str:
    """What is meant to be a name, for messages: one line, signs unseen as escapes, cut."""
    plain = " ".join(text.split())
    return ascii(plain[:60])[1:-1] if flaw(plain) else plain
