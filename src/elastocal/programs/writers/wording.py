"""The same words in every controller's file: header, and messages in lines that fit a display."""

from __future__ import annotations

import textwrap

from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers.names import plain
from elastocal.programs.writers.settings import Settings
from elastocal.writing import signature

SAFETY = "SAFETY: check this program at low speed in manual mode first."
UNWATCHED = "Motions between the points are not checked for collisions by this file."
WATCHED = (
    "Motions from point to point were checked for collisions with what the study names, in this "
    "order and from home; the way to home was not."
)
LOAD_DATA = (
    "Set the payload of the empty calibration tool and leave it so, loaded and unloaded: "
    "the controller must not compensate what is to be measured."
)
CARRIED = (
    "The robot moves with what it carries: set the load data of what is mounted each time. If the "
    "controller then shows other joint values, note those."
)


def header(
    program: RobotProgram,
    settings: Settings,
    width: int,
    *,
    units: str,
    start: str = "",
    shows: str = "",
) -> list[str]:
    """Lines of a file's header without comment signs, none longer than `width` >= 32.

    `shows` says what this controller may show otherwise than the model.
    """
    source = program.provenance
    whose = "converted for the controller" if settings.converted else "as in the model"
    sentences = [
        program.purpose,
        f"Made by {source.made_by}{f' from {source.study}' if source.study else ''}.",
        *(f"{what} sha256 {digest[:16]}" for what, digest in source.sources),
        start,
        f"Robot: {program.robot.name}. Joint values: {units}, {whose}.",
        shows,
        *program.notes,
        f"{SAFETY} {WATCHED if program.watched else UNWATCHED}",
    ]
    if program.experiments:
        sentences.append(CARRIED if program.carries else LOAD_DATA)
    lines = [line for sentence in sentences for line in wrapped(sentence, width) if line]
    return [*lines, signature("program")]


def wrapped(text: str, width: int) -> list[str]:
    """Harmless text, see `names.plain`, in lines of at most `width` characters."""
    return textwrap.wrap(plain(text), width, break_on_hyphens=False) or [""]
