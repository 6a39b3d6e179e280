"""Universal Robots: one URScript program, to be sent to the robot. Six joints, radians.

A script that is sent begins with `def` in the first column of its first line and ends with `end`
in that of its last; all between is indented. One for a Script node calls its function besides. A
long program is several scripts, each complete.

Source: URScript manual of Universal Robots (movej, sleep, popup, set_standard_digital_out;
"Connecting to URControl").
"""

from __future__ import annotations

import numpy as np

from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import ARM_AXES, ELSEWHERE, axes, readings
from elastocal.programs.writers.names import program_name
from elastocal.programs.writers.pages import page_names, paged, room
from elastocal.programs.writers.settings import Settings, output_number
from elastocal.programs.writers.urscript_words import FUNCTIONS, LANGUAGE
from elastocal.programs.writers.wording import header, wrapped

LONGEST_NAME = 32
MOST_MOVES = 1000  # of a script
POPUP = 200
FULL_SPEED = np.pi  # rad/s of a joint at 100 %: 180 degrees per second
FULL_ACCELERATION = 1.4  # rad/s^2, the language's default
RESERVED = LANGUAGE | FUNCTIONS
_LARGEST = 10.0


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One script, or one for each page."""
    robot = program.robot
    axes(robot, settings, "URScript", 0)
    if len(robot.joints) != ARM_AXES or robot.prismatic.any():
        sliding = int(robot.prismatic.sum())
        raise InputError(
            f"robot {robot.name!r} has {len(robot.joints)} joints, {sliding} of them sliding; "
            f"URScript takes {ARM_AXES} turning ones{ELSEWHERE}"
        )
    parts = paged(program.steps, MOST_MOVES)
    longest = LONGEST_NAME - room(len(parts))
    names = page_names(program_name(program, settings, "urscript", longest, RESERVED), len(parts))
    values = readings(
        program, settings, "URScript", scale=np.ones(ARM_AXES), decimals=8, largest=_LARGEST
    ).tolist()
    trigger = output_number(settings, "URScript", 0, 7)
    axis_names = wrapped(f"Axes: {', '.join(robot.joint_names)}.", 100)
    files = {}
    for number, (name, part) in enumerate(zip(names, parts, strict=True), 1):
        start = (START_NODE if settings.script_node else START).format(name=name)
        if len(parts) > 1:
            start += f" Script {number} of {len(parts)}: each starts when the one before is done."
        head = [*header(program, settings, 100, units="rad", start=start), *axis_names]
        lines = [f"def {name}():", *(f"  # {line}" for line in head)]
        lines += [f"  {line}" for step in part for line in _step(step, program, values, trigger)]
        lines += ["end", *([f"{name}()"] if settings.script_node else [])]
        files[f"{name}.script"] = "\n".join(lines) + "\n"
    return files


START = "Start: send this file to port 30002 of the robot. A Script node takes another form of it."
START_NODE = "Start: choose this file in a Script node; it ends with the call of its function."


def _step(
    step: Step, program: RobotProgram, values: list[list[float]], trigger: int | None
) -> list[str]:
    if isinstance(step, Move):
        q = ", ".join(f"{value:.8f}" for value in values[step.target])
        a, v = FULL_ACCELERATION * program.speed, FULL_SPEED * program.speed
        label = program.target_names[step.target]
        return [f"movej([{q}], a={a:.4f}, v={v:.4f})  # {label}"]
    if isinstance(step, Settle):
        return [f"sleep({step.seconds:.2f})"]
    assert isinstance(step, Ask | Measure)
    lines = []
    if isinstance(step, Measure) and trigger is not None:
        lines += [
            f"set_standard_digital_out({trigger}, True)",
            "sleep(0.5)",
            f"set_standard_digital_out({trigger}, False)",
        ]
    said = wrapped(step.text, POPUP)
    return lines + [f'popup("{line}", title="elastocal", blocking=True)' for line in said]
