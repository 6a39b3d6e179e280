"""What the user says of the controller, and what a writer is."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from elastocal.errors import InputError
from elastocal.programs.robot_program import RobotProgram
from elastocal.robot.controller_axes import Coupling


@dataclass(frozen=True)
class Settings:
    """What a writer must know besides the program.

    Attributes:
        coupling: From joint values of the model to those of the controller; None if they agree.
        external: Names of the joints that are external axes; None for the leading sliding ones of
            a robot with more than six joints.
        trigger: Output that starts a measurement: a number, or a signal name for RAPID; empty if
            the operator does it.
        name: What the program has to be called; empty to make a name of the program's own and of
            what it was made from, which no other program has.
        script_node: Whether URScript is for a Script node, which calls nothing by itself.
    """

    coupling: Coupling | None = None
    external: tuple[str, ...] | None = None
    trigger: str = ""
    name: str = ""
    script_node: bool = False

    @property
    def converted(self) -> bool:
        """Whether the controller shows other joint values than the model has."""
        return self.coupling is not None and not self.coupling.is_identity


Writer = Callable[[RobotProgram, Settings], dict[str, str]]
"""Program and settings → text by file name. The first file is the one to start."""


def output_number(settings: Settings, language: str, least: int, most: int) -> int | None:
    """The output that starts a measurement, None if the operator does.

    Raises:
        InputError: it is no number from `least` to `most`, in the digits 0 to 9.
    """
    written = settings.trigger
    if not written:
        return None
    if not re.fullmatch("[0-9]{1,6}", written) or not least <= int(written) <= most:
        raise InputError(
            f"{language} outputs have numbers from {least} to {most}, found {written[:40]!r}"
        )
    return int(written)
