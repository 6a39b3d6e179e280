"""Compiling the core in tests: with what, and without what is set around the tests."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.test_examples import ROOT

BUILDER = ROOT / "hatch_build.py"
COMPILERS = [name for name in ("cc", "gcc", "clang") if shutil.which(name)]
needs_compiler = pytest.mark.skipif(not COMPILERS, reason="there is no C compiler")
needs_none = pytest.mark.skipif(find_spec("ziglang") is not None, reason="ziglang is a compiler")


def plain(**more: str) -> dict[str, str]:
    """The environment without wishes, nor the sanitizer under which the tests may run.

    What is compiled here need not be fast, so it is compiled quickly.
    """
    wishes = ("ELASTOCAL_CORE", "CC", "CFLAGS", "LD_PRELOAD", "PYTHONPATH")
    return {name: value for name, value in os.environ.items() if name not in wishes} | (
        {"CFLAGS": "-O0"} | more
    )


def build(
    folder: Path, *, builder: Path = BUILDER, **more: str
) -> subprocess.CompletedProcess[str]:
    """Run the program that compiles the core into a folder."""
    command = [sys.executable, str(builder), str(folder)]
    return subprocess.run(command, env=plain(**more), capture_output=True, text=True)
