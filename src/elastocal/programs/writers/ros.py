"""ROS 2: trajectory_msgs/msg/JointTrajectory messages as YAML documents. Radians, metres, seconds.

A trajectory cannot wait for an operator, so there is one document for each motion from stop to
stop; what to do there is in the comments before the next one. Long motions are several documents,
since each point is one of rest.

Source: definition of trajectory_msgs/JointTrajectory and JointTrajectoryPoint.
"""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.programs.robot_program import Ask, Measure, Move, RobotProgram, Settle, Step
from elastocal.programs.writers.axes import readings
from elastocal.programs.writers.names import program_name
from elastocal.programs.writers.settings import Settings
from elastocal.programs.writers.wording import header, wrapped

LONGEST_NAME = 64
MOST_POINTS = 1000  # of a document
FULL_SPEED = np.pi  # rad/s at 100 %
FULL_SLIDING_SPEED = 1.0  # m/s at 100 %
SHORTEST = 0.1  # s
_LARGEST = 1e6
_PEAK = 1.5  # largest over mean speed of a cubic from rest to rest


def write(program: RobotProgram, settings: Settings) -> dict[str, str]:
    """One file with one document for each motion."""
    if settings.trigger:
        raise InputError("a ROS trajectory cannot set outputs; leave the trigger out")
    robot = program.robot
    name = program_name(program, settings, "ros", LONGEST_NAME)
    ones = np.ones(len(robot.joints))
    values = readings(program, settings, "ROS", scale=ones, decimals=9, largest=_LARGEST)
    full = np.where(robot.prismatic, FULL_SLIDING_SPEED, FULL_SPEED) * program.speed
    head = header(program, settings, 98, units="rad, m", start=START)
    lines = [f"# {line}" for line in head]
    here: Array | None = None
    for motion, said in _motions(program.steps):
        if motion:
            lines += ["---", "header: {frame_id: ''}"]
            lines += [f"joint_names: [{', '.join(map(_quoted, robot.joint_names))}]", "points:"]
            here = _points(program, values, full, motion, here, lines)
        lines += [f"# {line}" for text in said for line in wrapped(text, 98)]
    return {f"{name}.yaml": "\n".join(lines) + "\n"}


START = (
    "Start: send one document after the other, in this order. Do what the comment after a document "
    "says before the next one is sent. Each motion starts and ends at rest. Have it retimed if the "
    "robot's limits are lower."
)


def _quoted(name: str) -> str:
    """The very name, in ASCII, as YAML escapes it."""
    signs = (c if " " <= c <= "~" and c not in '"\\' else f"\\U{ord(c):08X}" for c in name)
    return f'"{"".join(signs)}"'


def _motions(steps: tuple[Step, ...]) -> list[tuple[list[Move | Settle], list[str]]]:
    """Motions without a stop in between, each with the texts that follow it."""
    found: list[tuple[list[Move | Settle], list[str]]] = [([], [])]
    for step in steps:
        if isinstance(step, Ask | Measure):
            found[-1][1].append(step.text)
        elif isinstance(step, Settle) and found[-1][1]:
            found[-1][1].append(f"Wait {step.seconds:g} s.")
        else:
            if found[-1][1] or len(found[-1][0]) >= MOST_POINTS:
                found.append(([], []))
            found[-1][0].append(step)
    return found


def _points(
    program: RobotProgram,
    values: Array,
    full: Array,
    motion: list[Move | Settle],
    here: Array | None,
    lines: list[str],
) -> Array:
    """Adds the points of one motion; returns where it ends."""
    time = 0.0
    robot = program.robot
    rest = ", ".join(["0.0"] * len(robot.joints))
    if here is None:  # from anywhere: as long as the longest motion there can be
        span = robot.upper - robot.lower
        usual = np.where(robot.prismatic, 1.0, 4.0 * np.pi)
        distance = np.where(np.isfinite(span), span, usual)
    for step in motion:
        if isinstance(step, Move):
            if here is not None:
                distance = np.abs(values[step.target] - here)
            here = values[step.target]
            time += max(SHORTEST, float(np.max(_PEAK * distance / full)))
            label = f"  # {program.target_names[step.target]}"
        else:
            if step.seconds == 0.0:
                continue
            time += step.seconds
            label = "  # settle"
        assert here is not None
        nanoseconds = round(time * 1e9)
        q = ", ".join(f"{value:.9f}" for value in here)
        lines += [
            f"- positions: [{q}]{label}",
            f"  velocities: [{rest}]",
            f"  time_from_start: {{sec: {nanoseconds // 10**9}, nanosec: {nanoseconds % 10**9}}}",
        ]
    assert here is not None
    return here
