"""Files that we write: whole or not at all, and each to be known as ours.

A text that we write carries `signature(kind)` in a comment or in a header; with its digest there it
is known as ours, and as unchanged since. JSON has keys of its own instead: `kind` and `made_by`.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import tempfile
from collections.abc import Iterable
from contextvars import ContextVar
from pathlib import Path

from elastocal.errors import InputError
from elastocal.reading import bytes_of

LARGEST = 1024 * 1024 * 1024
SAME = "the same"
WRITTEN: ContextVar[list[Path] | None] = ContextVar("written", default=None)
"""Where the files that are written are noted, for messages that say what was."""
_FORMULA = frozenset("=+-@\t\r'＝＋－＠")  # what spreadsheets of some language begin one with
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", re.ASCII)
_ENDS = re.compile(r"[,;\t|\"\n\r#]")  # what ends a cell or begins a comment for some reader
_OPEN = "0" * 12
_LINE = re.compile(r"(elastocal ([a-z][a-z0-9, ]*) )([0-9a-f]{12})(?![0-9a-f])")


def signature(kind: str, more: str = "") -> str:
    """What a writer puts into a comment of a file of this kind, such as 'run sheet'.

    Args:
        kind: Small letters and spaces.
        more: What else is said of it, small letters, digits and spaces.
    """
    return f"elastocal {kind}{', ' if more else ''}{more} {_OPEN}"


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
    return kind.split(",")[0] if digest == _digest(text) else ""


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


def inert(text: str) -> str:
    """Text for a cell that no spreadsheet takes for a formula: an apostrophe before it, if need be.

    Numbers stay. Readers of tables take one apostrophe off, so it is the same text again.
    """
    return f"'{text}" if text[:1] in _FORMULA and not _NUMBER.fullmatch(text) else text


def table_row(values: Iterable[object]) -> str:
    """A line of a table (CSV)."""
    return ",".join(map(cell, values)) + "\n"


def cell(value: object) -> str:
    """A value between commas, in quotes where a reader of some country would end it before."""
    text = inert(str(value))
    return '"' + text.replace('"', '""') + '"' if _ENDS.search(text) else text


def kind_of_file(path: Path, text: str = "") -> str:
    """What we wrote a file as, such as 'run sheet'; `SAME` if it holds `text`; else empty.

    A file that cannot be read, or was changed since, is not ours.
    """
    try:
        found = bytes_of(path, LARGEST).decode("utf-8")
    except (InputError, UnicodeDecodeError):
        return ""
    return SAME if text and found == text else kind_of(found)


def write_text(path: Path, text: str) -> None:
    """Write a whole file or nothing, its signature sealed: to a file beside it, then rename.

    Raises:
        InputError: the place cannot be written to.
    """
    try:
        data = sealed(text).encode("utf-8")
    except UnicodeEncodeError as error:
        sign = f"U+{ord(error.object[error.start]):04X}"
        raise InputError(f"{path}: cannot be written ({sign} is half a character)") from None
    write_bytes(path, data)


def write_bytes(path: Path, data: bytes) -> None:
    """The same of bytes, as they are.

    Raises:
        InputError: the place cannot be written to.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(name, 0o666 & ~umask)
            os.replace(name, path)
        finally:
            # Also when it was stopped: what has its name by now is written, else it goes.
            if Path(name).exists():
                Path(name).unlink()
            elif (log := WRITTEN.get()) is not None:
                log.append(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error
