"""Compiles the core: a build hook for wheels and editable installs, and a program for `make`.

    python hatch_build.py [folder]      exit code 0: compiled, 1: the compiler refuses something,
                                        2: nothing to compile with

The C code is compiled once for every level of instructions, and all of it is one library. `$CC`
and `$CFLAGS` are asked first. Without a compiler the package is complete: NumPy does the work.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

try:
    from hatchling.builders.hooks.plugin.interface import BuildHookInterface
except ImportError:  # `make` compiles before anything is installed
    BuildHookInterface = object  # type: ignore[assignment, misc]

CORE = Path(__file__).parent / "src" / "elastocal" / "core"
UNITS = ("core", "boxes")  # each compiled for every level
FLAGS = ["-O3", "-std=c11", "-fPIC", "-fvisibility=hidden", "-fno-math-errno"]
FLAGS += ["-ffp-contract=off"]  # products and sums are rounded as the source says
BASELINE = ["-DLEVEL=baseline", "-DLANES=2"]
V3 = ["-DLEVEL=v3", "-DLANES=4", "-mavx2", "-mfma", "-mbmi2"]  # what machine.c asks for


class NotCompiledError(Exception):
    """There is no library: why, in a few words."""

    exit_code = 1


class NoCompilerError(NotCompiledError):
    """... because there is nothing to compile with, or nobody wants it."""

    exit_code = 2


class CoreHook(BuildHookInterface):  # type: ignore[type-arg]
    """Puts the library into a wheel, or beside its sources if the install is editable."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile; where that cannot be done the wheel is for every machine."""
        self.folder = TemporaryDirectory()
        try:
            library = compiled(CORE if version == "editable" else Path(self.folder.name))
        except NotCompiledError as why:
            self.app.display_warning(sentence(why))
            return
        if version == "editable":
            return
        from packaging.tags import platform_tags

        # How old a system may be is not known, so it is for those like this one: no manylinux.
        tags = (tag for tag in platform_tags() if not tag.startswith(("manylinux", "musllinux")))
        build_data["tag"] = f"py3-none-{next(tags)}"
        build_data["pure_python"] = False
        build_data["force_include"][str(library)] = f"elastocal/core/{library.name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Leave nothing behind."""
        self.folder.cleanup()


def compiled(folder: Path) -> Path:
    """Compile the core; what was in the folder before is gone, whatever happens.

    Returns:
        The library.

    Raises:
        NotCompiledError: there is no compiler, or it refuses something.
    """
    if os.environ.get("ELASTOCAL_CORE") == "numpy":
        raise NoCompilerError("ELASTOCAL_CORE is numpy")
    for old in folder.glob("libcore.*"):
        old.unlink()
    compiler = [*found_compiler(), *FLAGS, *shlex.split(os.environ.get("CFLAGS", ""))]
    source = CORE / "source"
    # The machine that it is for need not be this one.
    target = set(run([*compiler, "-E", "-dM", str(source / "export.h")]).split())
    levels = {"baseline": BASELINE} | ({"v3": V3} if "__x86_64__" in target else {})
    objects = {"machine.o": ["machine.c"]}
    for level, flags in levels.items():
        objects |= {f"{unit}-{level}.o": [f"{unit}.c", *flags] for unit in UNITS}
    ending = "dll" if "_WIN32" in target else "dylib" if "__APPLE__" in target else "so"
    with TemporaryDirectory() as made:
        commands = [
            [*compiler, *flags, "-c", str(source / file), "-o", f"{made}/{name}"]
            for name, (file, *flags) in objects.items()
        ]
        with ThreadPoolExecutor() as at_once:
            list(at_once.map(run, commands))
        library = Path(made) / f"libcore.{ending}"
        parts = [f"{made}/{name}" for name in objects]
        run([*compiler, "-shared", *parts, "-lm", "-o", str(library)])
        return Path(shutil.copy(library, folder))


def found_compiler() -> list[str]:
    """The command that compiles C here."""
    if named := shlex.split(os.environ.get("CC", "")):
        return named
    for name in ("cc", "gcc", "clang"):
        if shutil.which(name):
            return [name]
    if find_spec("ziglang"):  # which compiles for this very machine if not told otherwise
        return [sys.executable, "-m", "ziglang", "cc", "-mcpu=baseline", "-g0"]
    raise NoCompilerError("there is no C compiler (cc, gcc, clang or the Python package ziglang)")


def run(command: list[str]) -> str:
    """What a compiler prints; what it complains about is shown."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace")
    except OSError as error:
        raise NoCompilerError(f"{command[0]} cannot be run ({error.strerror})") from error
    sys.stderr.write(done.stderr)
    if done.returncode:
        raise NotCompiledError(f"the compiler refuses {shlex.join(command)}")
    return done.stdout


def sentence(why: NotCompiledError) -> str:
    """What to tell those who build."""
    return f"elastocal is built without compiled core, NumPy does its work: {why}"


if __name__ == "__main__":
    try:
        into = Path(sys.argv[1]) if len(sys.argv) > 1 else CORE
        into.mkdir(parents=True, exist_ok=True)
        sys.stdout.write(f"{compiled(into)}\n")
    except NotCompiledError as why:
        sys.stderr.write(f"{sentence(why)}\n")
        sys.exit(why.exit_code)
