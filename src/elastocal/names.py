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
    "Zl": "a line break",
    "Zp": "a line break",
}


def flaw(name: str, longest: int = LONGEST) -> str:
    """What is wrong with a name, as the end of a sentence; empty if nothing is.

    Not accepted are control characters, line and paragraph separators, signs that cannot be seen
    (zero width, direction of writing), lone surrogates, and more than `longest` characters.
    """
    if len(name) > longest:
        return f"expected a name of at most {longest} characters, found {len(name)}: {name[:40]!r}"
    if name.isprintable():
        return ""
    for place, sign in enumerate(name, 1):
        kind = _UNSEEN.get(unicodedata.category(sign))
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
