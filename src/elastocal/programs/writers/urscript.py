"""Universal Robots: one URScript program. Six joints, radians.

Source: URScript manual of Universal Robots (movej, sleep, popup, set_standard_digital_out).
"""

from __future__ import annotations

import numpy as np

from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import ARM_AXES, axes, readings
from elastocal.programs.writers.names import identifier, words
from elastocal.programs.writers.settings import Settings
from elastocal.programs.writers.wording import header, wrapped

LONGEST_NAME = 32
POPUP = 200
FULL_SPEED = np.pi  # rad/s of a joint at 100 %: 180 degrees per second
FULL_ACCELERATION = 1.4  # rad/s^2, the language's default
RESERVED = words(
    """
    and break continue def elif else end False for global halt if in local loop not or pass
    return run sec thread True while xor movej movel sleep popup program main
    """
)
_LARGEST = 10.0


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One program."""
    robot = program.robot
    axes(robot, settings, "URScript", 0)
    if len(robot.joints) != ARM_AXES or robot.prismatic.any():
        sliding = int(robot.prismatic.sum())
        raise InputError(
            f"robot {robot.name!r} has {len(robot.joints)} joints, {sliding} of them sliding; "
            f"URScript takes {ARM_AXES} turning ones"
        )
    name = identifier(program.name, LONGEST_NAME, RESERVED)
    values = readings(
        program, settings, "URScript", scale=np.ones(ARM_AXES), decimals=8, largest=_LARGEST
    )
    trigger = _output(settings.trigger)
    lines = [f"# {line}" for line in header(program, settings, 100, units="rad")]
    lines += [f"# {line}" for line in wrapped(f"Axes: {', '.join(robot.joint_names)}.", 100)]
    lines.append(f"def {name}():")
    for step in program.steps:
        lines += [f"  {line}" for line in _step(step, program, values.tolist(), trigger)]
    lines.append("end")
    return {f"{name}.script": "\n".join(lines) + "\n"}


def _output(trigger: str) -> int | None:
    if not trigger:
        return None
    if not trigger.isdigit() or int(trigger) > 7:
        raise InputError(f"URScript outputs have numbers from 0 to 7, found {trigger[:40]!r}")
    return int(trigger)


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
