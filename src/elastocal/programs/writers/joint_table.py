"""Joint targets as a table (CSV): for RoboDK's Python, for other post-processors, for people.

One row for each step. Cells hold no commas, quotes or bars, so that the simplest reader can split
them; comment lines start with #. Degrees and millimetres, arm first, then external axes.

Source: RoboDK's public Python module for files: numbers where a cell is one, text elsewhere.
"""

from __future__ import annotations

from elastocal.errors import InputError
from elastocal.programs.robot_program import Measure, Move, RobotProgram, Settle
from elastocal.programs.writers.axes import axes, readings
from elastocal.programs.writers.names import plain, program_name
from elastocal.programs.writers.settings import Settings
from elastocal.programs.writers.wording import header
from elastocal.writing import inert

LONGEST_NAME = 64
MOST_AXES = 99
_LARGEST = 1e6


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One table."""
    if settings.trigger:
        raise InputError("a table cannot set outputs; leave the trigger out")
    robot = program.robot
    layout = axes(robot, settings, "a table", MOST_AXES, MOST_AXES)
    values = readings(
        program, settings, "CSV", scale=robot.shown_scale, decimals=6, largest=_LARGEST
    )
    columns = ["step", "do", "target", "experiment", "loaded", "seconds"]
    columns += [f"{_cell(robot.joints[i].name)} [{robot.joints[i].kind.key}]" for i in layout.order]
    head = header(program, settings, 98, units="deg, mm", start=START)
    lines = [f"# {_split_by_nobody(line)}".rstrip() for line in head]
    lines.append(",".join([*columns, "text"]))
    here, label = [""] * len(robot.joints), ""
    for number, step in enumerate(program.steps, 1):
        do, experiment, loaded, seconds, text = "ask", "", "", "", ""
        if isinstance(step, Move):
            do, label = "move", program.target_names[step.target]
            here = [f"{values[step.target, i]:.6f}" for i in layout.order]
        elif isinstance(step, Settle):
            do, seconds = "wait", f"{step.seconds:.2f}"
        else:
            text = _cell(step.text)
            if isinstance(step, Measure):
                do, experiment, loaded = "measure", str(step.experiment), str(int(step.loaded))
        lines.append(",".join([str(number), do, label, experiment, loaded, seconds, *here, text]))
    name = program_name(program, settings, "csv", LONGEST_NAME)
    return {f"{name}.csv": "\n".join(lines) + "\n"}


START = "Start: this is a table for a program that moves the robot."


def _cell(text: str) -> str:
    """Text without what splits cells; what a spreadsheet would compute is text to it."""
    return inert(_split_by_nobody(text))


def _split_by_nobody(text: str) -> str:
    return plain(text).replace(", ", "; ").replace(",", "; ").replace("|", "/").strip()
