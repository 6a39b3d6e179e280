"""Reading and writing files safely."""

from __future__ import annotations

import hashlib
import json
import math
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from elastocal.errors import InputError

_LARGEST = 64 * 1024 * 1024


def read_text(path: Path, *, largest: int = _LARGEST) -> str:
    """The text of a UTF-8 file.

    Raises:
        InputError: missing, a folder, too large, or not UTF-8.
    """
    try:
        size = path.stat().st_size
        if size > largest:
            raise InputError(f"{path}: {size} bytes, more than the {largest} that are read")
        data = path.read_bytes()
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from error
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise InputError(
            f"{path}, line {line}: byte 0x{data[error.start]:02x} is not UTF-8; save the file "
            "with UTF-8 encoding"
        ) from None


def file_hash(path: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def json_document(
    text: str,
    path: Path,
    error: type[InputError],
    hook: Callable[[list[tuple[str, Any]]], Any] | None = None,
) -> Any:
    """The document in a JSON text.

    Args:
        text: The text.
        path: Its file, for messages.
        error: What to raise.
        hook: What makes a section of its keys and values, a dict if not given; a ValueError of it
            is said.

    Raises:
        InputError: of the type `error`: not JSON, or nested without measure.
    """
    try:
        return json.loads(text, object_pairs_hook=hook)
    except json.JSONDecodeError as wrong:
        place = f"line {wrong.lineno}, column {wrong.colno}"
        raise error(f"{path}, {place}: not valid JSON: {wrong.msg}") from None
    except RecursionError:
        raise error(f"{path}: nested too deeply") from None
    except ValueError as wrong:
        raise error(f"{path}: not valid JSON: {wrong}") from None


def finite(value: Any) -> Any:
    """The same document with null for numbers that JSON does not have."""
    if isinstance(value, dict):
        return {key: finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_text(path: Path, text: str) -> None:
    """Write a whole file or nothing: to a temporary file beside it, then rename.

    Raises:
        InputError: the place cannot be written to.
    """
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(handle, "w", encoding="utf-8", newline="\n") as file:
                file.write(text)
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(name, 0o666 & ~umask)
            os.replace(name, path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error
