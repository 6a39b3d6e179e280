"""Robot programs as files, for the commands that write them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from elastocal.cli.common import replaceable, writable
from elastocal.cli.ending import undisturbed
from elastocal.errors import InputError
from elastocal.files.texts import read_text
from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers import NEWLINES, Settings, export, start, too_long
from elastocal.robot.controller_axes import Coupling
from elastocal.study.absolute import AbsoluteStudy
from elastocal.study.study import Study
from elastocal.writing import write_text

_SOURCE = re.compile(r"\b([a-z]+) sha256 ([0-9a-f]{16})\b")
_PARTS = 2  # files of a program of one page, at most
_SHOWN = 4  # files that are named one by one


def converted(study: Study | AbsoluteStudy) -> Coupling | None:
    """What the controller shows, if that is something else than the model has."""
    coupling = study.controller
    return None if coupling is None or coupling.is_identity else coupling


def write_program(
    program: RobotProgram,
    to: str,
    settings: Settings,
    folder: Path,
    *inputs: Path,
    force: bool,
) -> dict[Path, str]:
    """Write a program for a controller, whole or not at all; its files and what is in them.

    Raises:
        InputError: the controller cannot take it or its name, or another file stands there: one
            that is read, that is not ours, or that is the program of something else.
    """
    made = export(program, to, settings)
    files = {folder / file: text.replace("\n", NEWLINES[to]) for file, text in made.items()}
    for path in files:
        writable(path, *inputs)
        replaceable(path, "program", force=force)
    if not force:
        _refuse_others(files, folder)
    with undisturbed():
        for path, text in files.items():
            write_text(path, text)
    return files


def _refuse_others(files: dict[Path, str], folder: Path) -> None:
    """Refuse to take the place of a program made from something else, or its name at a controller.

    Names that differ in the case of letters are one name to controllers and to Windows.
    """
    names = {path.name.lower(): path for path in files}
    for other in folder.iterdir():
        path = names.get(other.name.lower())
        if path is None or not other.is_file():
            continue
        if other.name != path.name:
            raise InputError(
                f"{path}: {other.name} is there, which is the same name to controllers and to "
                "Windows; choose another name, or write it all the same with --force"
            )
        if _sources(read_text(other)) != _sources(files[path]):
            raise InputError(
                f"{path}: {other.name} is a program that was made from something else; choose "
                "another name, or write it all the same with --force"
            )


def _sources(text: str) -> set[tuple[str, str]]:
    """What a program says it was made from."""
    return {(found[1], found[2]) for found in _SOURCE.finditer(text)}


def said(files: Mapping[Path, str], to: str, settings: Settings) -> list[str]:
    """What to tell of a program that was written: where it is, how long, how it is started."""
    named = [str(file) for file in files]
    if len(named) > _SHOWN:
        named = [named[0], f"{len(named) - 1} files more"]
    paged = f"All its {len(files)} files are needed, in their order." * (len(files) > _PARTS)
    lines = [
        start(to, settings, next(iter(files)).stem),
        paged,
        too_long(to, files),
        "wrote " + " and ".join(named),
    ]
    return [line for line in lines if line]
