"""Pace: how long things take at the cell, and how fast the robot may move there.

In: numbers a user knows. Out: one frozen value; orders, schedules and ways around use it.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from elastocal.arrays import Array, freeze, unset
from elastocal.errors import InputError
from elastocal.robot.chain import Robot
from elastocal.robot.joint_room import outside

SPEED = float(np.radians(10.0))
"""Largest speed of a turning joint if nothing is said [rad/s]: careful, with a weight on."""
SLIDING_SPEED = 0.1
"""Largest speed of a sliding joint if nothing is said [m/s]."""


@dataclass(frozen=True)
class Pace:
    """How fast a campaign goes.

    Attributes:
        speed: (n,) largest speed of every joint [rad/s or m/s]; `SPEED` if not given.
        home: (n,) where the campaign starts and ends [rad or m]; rest if not given.
        measure: One experiment where the robot stands: unloaded and loaded reading [s].
        settle: Rest after every motion [s].
        change_load: Another wrench than before: other weights, another pull [s].
    """

    speed: Array = field(default_factory=unset)
    home: Array = field(default_factory=unset)
    measure: float = 120.0
    settle: float = 5.0
    change_load: float = 720.0

    def __post_init__(self) -> None:
        freeze(self, "speed", "home")
        for name in ("measure", "settle", "change_load"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(f"campaign: {name} must not be negative, found {value:g} s")


def for_robot(pace: Pace, robot: Robot, limits: Array) -> Pace:
    """The pace with a speed and a home value for every joint of `robot`.

    Args:
        pace: What is known.
        robot: The robot.
        limits: (2, n) lower and upper joint values allowed [rad or m].

    Raises:
        InputError: wrong number of joints, no speed, or a home outside the limits.
    """
    n = len(robot.joints)
    usual = np.where(robot.prismatic, SLIDING_SPEED, SPEED)
    speed = pace.speed if pace.speed.size else usual
    home = pace.home if pace.home.size else np.clip(np.zeros(n), limits[0], limits[1])
    if speed.shape != (n,) or home.shape != (n,):
        raise InputError(
            f"motion: speed and home need {n} numbers, found {speed.size} and {home.size}"
        )
    for joint, v, value in zip(robot.joints, speed, home, strict=True):
        scale, unit = joint.kind.shown
        if not (np.isfinite(v) and v > 0.0):
            raise InputError(
                f"motion: the speed of joint {joint.name!r} must be positive, found "
                f"{scale * v:.6g}{unit}/s"
            )
        if wrong := outside(joint, value):
            raise InputError(f"motion: home has {wrong}")
    return replace(pace, speed=speed, home=home)
