"""Robot programs in the languages of controllers: one file per controller, one line here."""

from __future__ import annotations

from elastocal.errors import InputError
from elastocal.io.exports import fanuc, joint_table, krl, rapid, ros, urscript
from elastocal.io.exports.settings import Settings, Writer
from elastocal.robot_program import RobotProgram

__all__ = ["WRITERS", "Settings", "Writer", "export"]

WRITERS: dict[str, Writer] = {
    "krl": krl.write,
    "rapid": rapid.write,
    "fanuc": fanuc.write,
    "urscript": urscript.write,
    "ros": ros.write,
    "csv": joint_table.write,
}


def export(
    program: RobotProgram, controller: str, settings: Settings | None = None
) -> dict[str, str]:
    """Text by file name for the controller called `controller`; the file to start comes first.

    Raises:
        InputError: no such controller, or it cannot hold the robot or the program.
    """
    if controller not in WRITERS:
        raise InputError(f"no export to {controller!r}; there are {', '.join(WRITERS)}")
    return WRITERS[controller](program, settings or Settings())
