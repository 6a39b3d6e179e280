"""Files as text and as JSON documents, their hashes."""

from __future__ import annotations

import hashlib
import json
import math
from functools import cache
from pathlib import Path
from typing import Any

from elastocal.errors import InputError
from elastocal.reading import bytes_of

_LARGEST = 64 * 1024 * 1024


def read_text(path: Path, *, largest: int = _LARGEST) -> str:
    """The text of a UTF-8 file.

    Raises:
        InputError: missing, no ordinary file, too large, or not UTF-8.
    """
    data = bytes_of(path, largest)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(
            f"{path}, line {line}: byte 0x{data[error.start]:02x} is not UTF-8; save the file "
            "with UTF-8 encoding"
        ) from None


def file_hash(path: Path) -> str:
    """SHA-256 of a file.

    Raises:
        InputError: it cannot be read.
    """
    return hashlib.sha256(bytes_of(path, _LARGEST)).hexdigest()


def text_hash(text: str) -> str:
    """SHA-256 of a text in UTF-8, as of the file it came from."""
    return hashlib.sha256(text.encode()).hexdigest()


def json_document(text: str, path: Path, error: type[InputError]) -> Any:
    """The document in a JSON text.

    Args:
        text: The text.
        path: Its file, for messages.
        error: What to raise.

    Raises:
        InputError: of the type `error`: not JSON, nested without measure, a key twice in one
            section, a number that is none or beyond all measure, or text that no file can hold.
    """
    try:
        document = json.loads(
            text,
            object_pairs_hook=_each_once,
            parse_constant=_no_number,
            parse_float=_decimal,
            parse_int=_whole,
        )
        if "\\ud" in text.lower():  # half of a pair of escapes is no sign
            json.dumps(document, ensure_ascii=False).encode()
    except json.JSONDecodeError as wrong:
        place = f"line {wrong.lineno}, column {wrong.colno}"
        raise error(f"{path}, {place}: not valid JSON: {wrong.msg}") from None
    except RecursionError:
        raise error(f"{path}: nested too deeply") from None
    except UnicodeEncodeError as wrong:
        sign = ascii(wrong.object[wrong.start])
        raise error(f"{path}: not valid JSON: {sign} is half of a sign") from None
    except ValueError as wrong:
        raise error(f"{path}: not valid JSON: {wrong}") from None
    return document


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    section: dict[str, Any] = {}
    for key, value in pairs:
        if key in section:
            raise ValueError(f"key {key!r:.80} appears twice in one section")
        section[key] = value
    return section


def _no_number(word: str) -> Any:
    raise ValueError(f"expected a finite number, found {word}")


def _decimal(digits: str) -> float:
    return float(digits) if math.isfinite(float(digits)) else _no_number(f"{digits:.40}")


def _whole(digits: str) -> int:
    return int(digits) if len(digits) <= _MOST_DIGITS else _no_number(f"{digits:.40}…")


_MOST_DIGITS = 40  # of a whole number; what is called large in files ends at 1e30


def is_version(value: Any, version: int = 1) -> bool:
    """Whether what a file says of its format is this version: a whole number, not 1.0 or true."""
    return type(value) is int and value == version


def finite(value: Any) -> Any:
    """The same document with null for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def json_text(document: Any) -> str:
    """The document as JSON of two spaces a level, a file's end of line, `finite`.

    As the library writes it, but what holds no further lists is written in one go.
    """
    return _indented(document, 0) + "\n"


def _indented(value: Any, depth: int) -> str:
    entries = value.values() if isinstance(value, dict) else value
    if not isinstance(value, (dict, list, tuple)) or not value:
        return _encoder(depth).encode(finite(value))
    open_, close = "{}" if isinstance(value, dict) else "[]"
    line = "\n" + "  " * (depth + 1)
    if not any(isinstance(entry, (dict, list, tuple)) for entry in entries):
        try:
            flat = _encoder(depth).encode(value)[1:-1]
        except ValueError:  # a number that JSON does not have
            flat = _encoder(depth).encode(finite(value))[1:-1]
    elif isinstance(value, dict):
        quoted = _encoder(depth).encode
        flat = ("," + line).join(
            f"{quoted(str(key))}: {_indented(entry, depth + 1)}" for key, entry in value.items()
        )
    else:
        flat = ("," + line).join(_indented(entry, depth + 1) for entry in value)
    return f"{open_}{line}{flat}{line[:-2]}{close}"


@cache
def _encoder(depth: int) -> json.JSONEncoder:
    """That puts what is in a list of this depth on lines of its own."""
    separators = (",\n" + "  " * (depth + 1), ": ")
    return json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=separators)
