"""From the bytes of a measurement file to its text: encodings of the field, nothing else."""

from __future__ import annotations

import codecs
import hashlib
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastocal.errors import InputError
from elastocal.reading import bytes_of

LARGEST = 1024 * 1024 * 1024
"""Bytes; a file of a million readings has about a tenth of it."""

_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),  # before UTF-16: its mark begins with that of UTF-16
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_CONTROL = re.compile("[\x00-\x08\x0e-\x1f\x7f]")
_BLOCK = 1 << 18  # bytes looked at together; what stays in the cache
_USUAL = set("µμ°·²³−–\xa0")
"""Characters beyond ASCII that units and numbers use; others make the encoding a question."""


@dataclass(frozen=True)
class FileText:
    """The text of a file.

    Attributes:
        path: Where it is.
        text: Its text, lines ended by a newline.
        sha256: Hash of its bytes.
        error: What to raise if something is wrong with it.
        remark: What is odd about its encoding, empty if nothing is.
    """

    path: Path
    text: str
    sha256: str
    error: type[InputError]
    remark: str = ""


def decoded(path: Path, error: type[InputError], encoding: str | None = None) -> FileText:
    """The text of a file in UTF-8, UTF-16 with a byte order mark, or Windows-1252.

    Args:
        path: The file.
        error: What to raise.
        encoding: Encoding to use; None to find out.

    Raises:
        InputError: of the type `error`: missing, a folder, too large, empty, or not text.
    """
    data = bytes_of(path, LARGEST, error)
    if not data or data.isspace():
        raise error(f"{path}: the file is empty")
    if data.startswith((b"PK\x03\x04", b"\xd0\xcf\x11\xe0")):
        raise error(f"{path}: this is an Excel workbook, not text; save the sheet as CSV")
    text, used = _text(data, path, error, encoding)
    # To look at bytes is a hundred times as fast as the search that it saves.
    suspect = not used.startswith(("utf-8", "cp1252")) or _has_control_bytes(data)
    found = _CONTROL.search(text) if suspect else None
    if found:
        line = text.count("\n", 0, found.start()) + 1
        raise error(
            f"{path}, line {line}: character 0x{ord(found[0]):02x} does not occur in text; "
            "expected a table as CSV in UTF-8, UTF-16 with byte order mark or Windows-1252"
        )
    if "\ufeff" in text or text.startswith("ï»¿"):
        # A second byte order mark, of a program that took the first for text; or one inside.
        text = text.replace("\ufeff", "").removeprefix("ï»¿")
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    remark = ""
    if used == "cp1252" and encoding is None:
        odd = sorted({c for c in text if ord(c) > 127} - _USUAL)
        if odd:
            remark = (
                f"{path.name} is not UTF-8 and was read as Windows-1252; check names with "
                f"{' '.join(odd[:5])}"
            )
    return FileText(path, text, hashlib.sha256(data).hexdigest(), error, remark)


def _has_control_bytes(data: bytes) -> bool:
    whole = np.frombuffer(data, dtype=np.uint8)
    blocks = (whole[i : i + _BLOCK] for i in range(0, len(whole), _BLOCK))
    return any(bool((((b < 0x20) & ((b < 0x09) | (b > 0x0D))) | (b == 0x7F)).any()) for b in blocks)


def _text(
    data: bytes, path: Path, error: type[InputError], encoding: str | None
) -> tuple[str, str]:
    marked = next((name for mark, name in _MARKS if data.startswith(mark)), None)
    for name in [encoding or marked] if encoding or marked else ["utf-8", "cp1252"]:
        assert name is not None
        try:
            return data.decode(name), name
        except UnicodeError as wrong:
            at = getattr(wrong, "start", 0)
            problem = f"{path}, line {data[:at].count(10) + 1}: not readable as {name}"
    raise error(f"{problem}; save the file as CSV with UTF-8 encoding")
