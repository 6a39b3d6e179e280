"""Joint values as a controller has them: which axis is which, in its units, rounded within limits.

In: a program and settings. Out: axes of the arm and external ones, and numbers ready to print.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.programs.robot_program import RobotProgram
from elastocal.programs.writers.settings import Settings
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import uncoupled

ARM_AXES = 6
ELSEWHERE = "; ros and csv take any robot"
"""What a refusal of a robot that a controller cannot hold ends with."""


@dataclass(frozen=True)
class Axes:
    """Which joints of the chain are axes of the arm, which are external; by position."""

    arm: tuple[int, ...]
    external: tuple[int, ...]

    @property
    def order(self) -> list[int]:
        """Joints in the order of the controller: the arm, then the external axes."""
        return [*self.arm, *self.external]


def axes(
    robot: Robot, settings: Settings, controller: str, external: int, inside: int = ARM_AXES
) -> Axes:
    """Axes of a controller that holds `inside` axes of the arm and `external` more.

    Raises:
        InputError: the robot has more joints than the controller, or it is not clear which are
            external.
    """
    n = len(robot.joints)
    if settings.external is not None:
        outside = robot.index(settings.external)
        if len(set(outside)) != len(outside):
            raise InputError("an external axis is named twice")
    elif n > ARM_AXES:
        turning = np.flatnonzero(~robot.prismatic)
        outside = list(range(int(turning[0]) if len(turning) else 0))
    else:
        outside = []
    arm = tuple(i for i in range(n) if i not in outside)
    if len(arm) > inside:
        hint = "; name the external axes with --external" if external else ""
        hint += ELSEWHERE if inside == ARM_AXES else ""
        raise InputError(
            f"robot {robot.name!r} has {len(arm)} joints in its arm, {controller} takes at most "
            f"{inside}{hint}"
        )
    if len(outside) > external:
        takes = f"at most {external}" if external else "none"
        raise InputError(
            f"robot {robot.name!r} has {len(outside)} external axes "
            f"({', '.join(robot.joint_names[i] for i in outside)}), {controller} takes {takes}"
            f"{ELSEWHERE if inside == ARM_AXES else ''}"
        )
    return Axes(arm, tuple(outside))


def readings(
    program: RobotProgram,
    settings: Settings,
    controller: str,
    *,
    scale: Array,
    decimals: int,
    largest: float,
) -> Array:
    """(T, n) targets as the controller shows them, rounded to `decimals`, in model order.

    A value that rounding would carry over a joint limit is rounded to the inside.

    Args:
        program: The program.
        settings: With the coupling.
        controller: Its name for messages.
        scale: (n,) from rad and m to the controller's units.
        decimals: Decimals that will be printed.
        largest: Values from here on do not fit the controller's format.

    Raises:
        InputError: a value does not fit, or the coupling belongs to another robot.
    """
    robot = program.robot
    coupling = settings.coupling or uncoupled(robot)
    if coupling.joint_names != robot.joint_names:
        raise InputError(
            f"the coupling is for joints {', '.join(coupling.joint_names)}, the robot has "
            f"{', '.join(robot.joint_names)}"
        )
    exact = coupling.to_controller(program.targets) * scale
    values = np.round(exact, decimals)
    step = 10.0**-decimals
    single = (coupling.matrix != 0.0).sum(axis=1) == 1
    for j in np.flatnonzero(single).tolist():
        i = int(np.flatnonzero(coupling.matrix[j])[0])
        ends = coupling.matrix[j, i] * np.array([robot.lower[i], robot.upper[i]])
        lower, upper = np.sort(scale[j] * (ends + coupling.offset[j]))
        low = np.round(np.ceil(lower / step - 1e-6) * step, decimals)
        high = np.round(np.floor(upper / step + 1e-6) * step, decimals)
        values[:, j] = np.clip(values[:, j], low, high)
    far = np.abs(values - exact) > 1.001 * step + 1e-12 * np.abs(exact)
    for i, j in np.argwhere(far).tolist():
        raise InputError(
            f"target {program.target_names[i]}: joint {robot.joint_names[j]!r} is at "
            f"{exact[i, j]:.9g} at the controller, and would be written as {values[i, j]:.9g}"
        )
    for j, joint in enumerate(robot.joints):
        if np.abs(values[:, j]).max(initial=0.0) >= largest:
            raise InputError(
                f"joint {joint.name!r} reaches {np.abs(values[:, j]).max():.6g} at the "
                f"controller; {controller} takes values below {largest:g}"
            )
    return values + 0.0  # no minus zero
