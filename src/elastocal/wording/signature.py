"""The words by which a file is known as ours, and as unchanged since it was written.

A text that we write carries `signature(kind)` in a comment or in a header; `sealed` puts the
digest of the whole text there. JSON has keys of its own instead: `kind` and `made_by`.
"""

from __future__ import annotations

import hashlib
import json
import re

_OPEN = "0" * 12
_LINE = re.compile(r"(elastocal ([a-z][a-z0-9, ]*) )([0-9a-f]{12})(?![0-9a-f])")


def signature(kind: str) -> str:
    """What a writer puts into a comment of a file of this kind, such as 'run sheet'."""
    return f"elastocal {kind} {_OPEN}"


def sealed(text: str) -> str:
    """The text with its digest in its signature; a text that has none is left as it is."""
    if _OPEN not in text:
        return text
    digest = _digest(text)
    return _LINE.sub(lambda found: found[1] + digest if found[3] == _OPEN else found[0], text)


def kind_of(text: str) -> str:
    """What we wrote this text as, such as 'run sheet' or 'plan'; empty if we did not.

    A text that was changed after it was written is not ours any more.
    """
    if text.startswith("{"):
        return _kind_of_json(text)
    found = {(line[2], line[3]) for line in _LINE.finditer(text)}
    if len(found) != 1:
        return ""
    kind, digest = found.pop()
    return kind if digest == _digest(text) else ""


def _digest(text: str) -> str:
    """Of a text in which every signature is open."""
    blank = _LINE.sub(lambda found: found[1] + _OPEN, text)
    return hashlib.sha256(blank.encode("utf-8", "replace")).hexdigest()[: len(_OPEN)]


def _kind_of_json(text: str) -> str:
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        return ""
    made_by = document.get("made_by")
    ours = isinstance(made_by, str) and made_by.startswith("elastocal ")
    return str(document.get("kind", "")) if ours else ""
