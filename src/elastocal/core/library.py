"""The shared library of the core: which one is used, and why none.

It is compiled from `source/` when the package is built or installed (`hatch_build.py`), for
several levels of instructions in one file. The machine decides which level is used, unless the
environment variable `ELASTOCAL_CORE` does.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from elastocal.errors import InputError

VERSION = 11
"""What `core_version` in `source/core.c` must say: raised there and here with the interface."""
SWITCH = "ELASTOCAL_CORE"
"""Environment variable: `numpy`, or the level to use."""
FOLDER = Path(__file__).parent
LANES = {"baseline": 2, "v3": 4}
"""Load cases that a level works on side by side; the widest level comes last."""
_SHOWN = {"baseline": "baseline", "v3": "x86-64-v3"}


@dataclass(frozen=True)
class Library:
    """The functions of one level.

    Attributes:
        level: `baseline`, for every machine, or `v3`, for x86-64 with AVX2, FMA and BMI2.
        lanes: Load cases that are worked on side by side.
    """

    level: str
    lanes: int
    _loaded: ctypes.CDLL

    def function(self, name: str) -> Any:
        """The exported C function of this name; the caller says once what it takes and returns.

        Raises:
            AttributeError: there is none.
        """
        return getattr(self._loaded, f"{name}_{self.level}")


def library() -> Library | None:
    """What is used here, always the same one; None where NumPy does the work.

    Raises:
        InputError: `ELASTOCAL_CORE` asks for what is not there.
    """
    return _chosen(os.environ.get(SWITCH, ""))


def levels() -> Mapping[str, Library]:
    """Every level that runs on this machine, the widest last; empty if there is no library."""
    return _found()[0]


def described() -> str:
    """What is used, and why no library if there is none, in a few words.

    Raises:
        InputError: `ELASTOCAL_CORE` asks for what is not there.
    """
    used = library()
    if used is not None:
        return f"compiled core ({_SHOWN[used.level]})"
    why = f"{SWITCH} is numpy" if os.environ.get(SWITCH) == "numpy" else _found()[1]
    return f"without compiled core: NumPy ({why})"


@lru_cache
def _chosen(wanted: str) -> Library | None:
    if wanted == "numpy":
        return None
    found, why = _found()
    if not wanted:
        return list(found.values())[-1] if found else None
    if wanted not in LANES:
        raise InputError(f"{SWITCH} is {wanted!r}, expected numpy, {' or '.join(LANES)}")
    if wanted not in found:
        raise InputError(f"{SWITCH} is {wanted!r}, which cannot be used here: {why}")
    return found[wanted]


@lru_cache(maxsize=1)
def _found() -> tuple[Mapping[str, Library], str]:
    """The levels that run here, and why there are not more."""
    path = next(iter(sorted(FOLDER.glob("libcore.*"))), None)
    if path is None:
        return {}, "none was built"
    try:
        loaded = ctypes.CDLL(str(path))
        built = [level for level in LANES if hasattr(loaded, f"core_version_{level}")]
        versions = {loaded[f"core_version_{level}"]() for level in built}
        usable = [level for level in built if level != "v3" or loaded.core_has_v3()]
    except (OSError, AttributeError) as error:
        return {}, f"the one built cannot be loaded: {error}"
    if versions != {VERSION}:
        return {}, "the one built is out of date"
    here = {level: Library(level, LANES[level], loaded) for level in usable}
    return MappingProxyType(here), "this machine does not have its instructions"
