"""Robot programs as files, for the commands that write them."""

from __future__ import annotations

from pathlib import Path

from elastocal.cli.common import replaceable, writable
from elastocal.cli.ending import undisturbed
from elastocal.errors import InputError
from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers import Settings, export
from elastocal.writing import write_text


def write_program(
    program: RobotProgram,
    to: str,
    settings: Settings,
    folder: Path,
    name: str,
    *inputs: Path,
    force: bool,
) -> list[Path]:
    """Write a program for a controller; refuse a file name that the controller does not take."""
    files = {folder / file: text for file, text in export(program, to, settings).items()}
    made = next(iter(files)).stem
    if name and made != name:
        raise InputError(f"{folder / name}: not a program name for {to}, {made!r} would be one")
    for path in files:
        writable(path, *inputs)
        replaceable(path, "program", force=force)
    with undisturbed():
        for path, text in files.items():
            write_text(path, text)
    return list(files)
