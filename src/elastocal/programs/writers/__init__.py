"""Robot programs in the languages of controllers: one file per controller, one line here."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from elastocal.errors import InputError
from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers import fanuc, joint_table, krl, rapid, ros, urscript
from elastocal.programs.writers.settings import Settings, Writer
from elastocal.robot.chain import Robot

__all__ = [
    "ENDINGS",
    "NEWLINES",
    "WRITERS",
    "Settings",
    "Writer",
    "export",
    "shows",
    "start",
    "too_long",
]

_CONTROLLERS: dict[str, tuple[Writer, str, str, str]] = {
    # name: (writer, ending of the file to start, end of a line on disk, how it is started)
    "krl": (krl.write, ".src", "\r\n", krl.START),
    "rapid": (rapid.write, ".mod", "\r\n", rapid.START),
    "fanuc": (fanuc.write, ".ls", "\r\n", fanuc.START),
    "urscript": (urscript.write, ".script", "\n", urscript.START),
    "ros": (ros.write, ".yaml", "\n", ros.START),
    "csv": (joint_table.write, ".csv", "\n", joint_table.START),
}
WRITERS = {name: entry[0] for name, entry in _CONTROLLERS.items()}
ENDINGS = {name: entry[1] for name, entry in _CONTROLLERS.items()}
NEWLINES = {name: entry[2] for name, entry in _CONTROLLERS.items()}
"""Controllers of KUKA, ABB and FANUC, and what loads their files, live on Windows."""
LARGE = 1_000_000
"""Size from which one should ask whether a controller has room for a program [bytes]."""
_SHOWS = {"rapid": rapid.shows, "fanuc": fanuc.shows}
_ROOM = {"krl": "; a KR C4 is said to have room for 4 to 8 MB"}


def export(
    program: RobotProgram, controller: str, settings: Settings | None = None
) -> dict[str, str]:
    """Text by file name for the controller called `controller`; the file to start comes first.

    Raises:
        InputError: no such controller, or it cannot hold the robot or the program.
    """
    if controller not in WRITERS:
        raise InputError(f"no export to {controller!r}; there are {', '.join(WRITERS)}")
    settings = settings or Settings()
    if settings.script_node and controller != "urscript":
        raise InputError(f"a Script node takes URScript, not {controller}")
    return WRITERS[controller](program, settings)


def start(controller: str, settings: Settings, name: str) -> str:
    """A sentence on how a program called `name` is started."""
    how = urscript.START_NODE if settings.script_node else _CONTROLLERS[controller][3]
    return how.format(name=name)


def shows(controller: str, robot: Robot, settings: Settings) -> str:
    """What a controller may show otherwise than the model; empty if nothing, or if it is said."""
    return _SHOWS[controller](robot, settings) if controller in _SHOWS else ""


def too_long(controller: str, files: Mapping[Any, str]) -> str:
    """A sentence on the size of a program that may be too large; empty if it is not."""
    size = sum(map(len, files.values()))
    if size <= LARGE:
        return ""
    return (
        f"The program has {size / 1e6:.1f} MB in {len(files)} files: see whether the controller "
        f"has room for it{_ROOM.get(controller, '')}, or leave points out."
    )
