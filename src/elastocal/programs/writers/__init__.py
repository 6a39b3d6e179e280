"""Robot programs in the languages of controllers: one file per controller, one line here."""

from __future__ import annotations

from elastocal.errors import InputError
from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers import fanuc, joint_table, krl, rapid, ros, urscript
from elastocal.programs.writers.settings import Settings, Writer

__all__ = ["ENDINGS", "WRITERS", "Settings", "Writer", "export"]

_CONTROLLERS: dict[str, tuple[Writer, str]] = {  # name: (writer, ending of the file to start)
    "krl": (krl.write, ".src"),
    "rapid": (rapid.write, ".mod"),
    "fanuc": (fanuc.write, ".ls"),
    "urscript": (urscript.write, ".script"),
    "ros": (ros.write, ".yaml"),
    "csv": (joint_table.write, ".csv"),
}
WRITERS = {name: writer for name, (writer, _) in _CONTROLLERS.items()}
ENDINGS = {name: ending for name, (_, ending) in _CONTROLLERS.items()}


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
