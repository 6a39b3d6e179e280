"""The same words in every controller's file: header, and messages in lines that fit a display."""

from __future__ import annotations

import textwrap

from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers.names import ascii_text
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


def header(program: RobotProgram, settings: Settings, width: int, *, units: str) -> list[str]:
    """Lines of a file's header without comment signs, none longer than `width` >= 32."""
    source = program.provenance
    origin = f"Made by {source.made_by} from {source.study or program.name!r}"
    if source.digest:
        origin += f", plan sha256 {source.digest[:16]}"
    whose = "as in the model" if settings.coupling is None else "converted for the controller"
    sentences = [
        program.purpose,
        f"{origin}.",
        f"Robot: {program.robot.name}. Joint values: {units}, {whose}.",
        *program.notes,
        f"{SAFETY} {WATCHED if program.watched else UNWATCHED}",
    ]
    if program.experiments:
        sentences.append(LOAD_DATA)
    lines = [line for sentence in sentences for line in wrapped(sentence, width)]
    return [*lines, signature("program")]


def wrapped(text: str, width: int) -> list[str]:
    """ASCII text in lines of at most `width` characters; no quotes, which end strings."""
    plain = ascii_text(text).replace('"', "'").replace("\\", "/")
    return textwrap.wrap(plain, width, break_on_hyphens=False) or [""]
