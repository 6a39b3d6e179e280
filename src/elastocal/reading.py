"""Files that people name, opened: ordinary ones only, and no more of them than is read at most.

A name may come from a file of a stranger. A device, a pipe or a socket under it would fill the
memory or wait for ever, so what it is is asked before it is opened, and once more of what is open.
"""

from __future__ import annotations

import codecs
import os
import stat
from pathlib import Path

from elastocal.errors import InputError

_NO_CHARACTER_SETS = {"idna", "punycode", "unicode-escape", "raw-unicode-escape", "undefined"}
"""Encodings that Python has for other things than the texts of files."""
_AT_ONCE = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def is_character_set(name: str) -> bool:
    """Whether texts of files may be in the encoding `name`: rot13, hex or idna are for others."""
    try:
        "a".encode(name)
        return codecs.lookup(name).name not in _NO_CHARACTER_SETS
    except (LookupError, ValueError):
        return False


def bytes_of(path: Path, largest: int, error: type[InputError] = InputError) -> bytes:
    """All bytes of an ordinary file.

    Args:
        path: The file; links are followed.
        largest: How many bytes are read at most, whatever the file system says of its size.
        error: What to raise.

    Raises:
        InputError: of the type `error`: no such file, a name that no file can have, a folder, a
            device, a pipe or a socket, too large, or not to be read.
    """
    try:
        _refuse(path, os.stat(path).st_mode, error)
        with open(path, "rb", opener=lambda name, _: os.open(name, _AT_ONCE)) as file:
            now = os.fstat(file.fileno())
            _refuse(path, now.st_mode, error)
            data = file.read(largest + 1)
    except (FileNotFoundError, NotADirectoryError):
        raise error(f"{path}: no such file") from None
    except OSError as wrong:
        raise error(f"{path}: cannot be read ({wrong.strerror})") from None
    except InputError:
        raise
    except ValueError:  # a null character, or a surrogate that the file system cannot have
        raise error(f"{path}: not a file name") from None
    if len(data) > largest:
        size = max(now.st_size, len(data))
        raise error(f"{path}: {size} bytes, more than the {largest} that are read")
    return data


def _refuse(path: Path, mode: int, error: type[InputError]) -> None:
    """Refuse what is no ordinary file."""
    if stat.S_ISDIR(mode):
        raise error(f"{path}: cannot be read (it is a folder)")
    if not stat.S_ISREG(mode):
        raise error(f"{path}: is not an ordinary file")
