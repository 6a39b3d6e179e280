"""The sections of a study file on motion and time, as a pace in SI units."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, unset
from elastocal.files.schema import CampaignFile, MotionFile
from elastocal.files.study.joint_values import configuration
from elastocal.files.yaml_lines import LocatedError
from elastocal.motion.pace import SLIDING_SPEED, SPEED, Pace, for_robot
from elastocal.robot.chain import Robot

_USUAL = Pace()


def pace_of(
    motion: MotionFile | None, times: CampaignFile | None, robot: Robot, limits: Array
) -> Pace:
    """How long things take at the cell; what is not said has its usual value.

    Errors have the path from the top of the file: `motion` or `campaign`.
    """
    motion, times = motion or MotionFile(), times or CampaignFile()
    for key in CampaignFile.model_fields:
        value = getattr(times, key)
        if value is not None and value < 0.0:
            raise LocatedError(
                ("campaign", key), f"campaign: {key} must not be negative, found {value:g}"
            )
    found = Pace(
        speed=_speed(motion, robot),
        home=_home(motion, robot),
        measure=_seconds(times.measure_min, 60.0, _USUAL.measure),
        settle=_seconds(times.settle_s, 1.0, _USUAL.settle),
        change_load=_seconds(times.change_load_min, 60.0, _USUAL.change_load),
    )
    return for_robot(found, robot, limits)


def _seconds(value: float | None, unit: float, usual: float) -> float:
    return usual if value is None else unit * value


def _speed(motion: MotionFile, robot: Robot) -> Array:
    """(n,) speeds, of all joints of a kind or by name."""
    speed = np.where(robot.prismatic, SLIDING_SPEED, SPEED)
    for key, prismatic, scale in (
        ("max_speed_deg_s", False, np.pi / 180.0),
        ("max_speed_mm_s", True, 1e-3),
    ):
        given = getattr(motion, key)
        if given is None:
            continue
        if isinstance(given, float):
            speed = np.where(robot.prismatic == prismatic, scale * given, speed)
            continue
        for name, value in given.items():
            if name not in robot.joint_names:
                raise LocatedError(
                    ("motion", key, name),
                    f"no joint {name!r}; the joints are {', '.join(robot.joint_names)}",
                )
            i = robot.joint_names.index(name)
            if robot.joints[i].prismatic != prismatic:
                right = "max_speed_deg_s" if prismatic else "max_speed_mm_s"
                raise LocatedError(("motion", key, name), f"joint {name!r} belongs under {right}")
            speed[i] = scale * value
    return np.asarray(speed)


def _home(motion: MotionFile, robot: Robot) -> Array:
    if motion.home_deg is None and motion.home_mm is None:
        return unset()
    try:
        return configuration(robot, motion.home_deg, motion.home_mm, keys=("home_deg", "home_mm"))
    except LocatedError as error:
        raise LocatedError(("motion", *error.path), str(error)) from None
