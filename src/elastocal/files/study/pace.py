"""Motion and times of a campaign, as its pace."""

from __future__ import annotations

import numpy as np

from elastocal.arrays import Array, unset
from elastocal.files.sections import Section, fields_of
from elastocal.files.study.joint_values import by_joint, configuration
from elastocal.files.values import (
    Degrees,
    ListOrByName,
    Millimetres,
    Minutes,
    Name,
    Number,
    OneOrByName,
    PositiveDegrees,
    PositiveMillimetres,
)
from elastocal.files.yaml_lines import LocatedError, at
from elastocal.motion.pace import SLIDING_SPEED, SPEED, Pace, for_robot
from elastocal.robot.chain import Robot


class MotionFile(Section):
    """How fast the robot moves between experiments, and where it starts and ends."""

    max_speed_deg_s: OneOrByName[PositiveDegrees] | None = None
    max_speed_mm_s: OneOrByName[PositiveMillimetres] | None = None
    home_deg: ListOrByName[Degrees] | None = None
    home_mm: dict[Name, Millimetres] | None = None


class CampaignFile(Section):
    """How long things take."""

    measure_min: Minutes | None = None
    settle_s: Number | None = None
    change_load_min: Minutes | None = None


def pace_of(
    motion: MotionFile | None, times: CampaignFile | None, robot: Robot, limits: Array
) -> Pace:
    """How long things take at the cell; times that are not said have their usual values.

    Errors have the path from the top of the file: `motion` or `campaign`.
    """
    motion, times = motion or MotionFile(), times or CampaignFile()
    for key in fields_of(CampaignFile):
        value = getattr(times, key)
        if value is not None and value < 0.0:
            shown = value / 60.0 if key.endswith("_min") else value
            raise LocatedError(
                ("campaign", key), f"campaign: {key} must not be negative, found {shown:g}"
            )
    usual = Pace()
    with at("motion"):
        pace = Pace(
            speed=_speed(motion, robot),
            home=_home(motion, robot),
            measure=usual.measure if times.measure_min is None else times.measure_min,
            settle=usual.settle if times.settle_s is None else times.settle_s,
            change_load=(
                usual.change_load if times.change_load_min is None else times.change_load_min
            ),
        )
        for_robot(pace, robot, limits)  # for its errors
        _refuse_held(pace.home, robot, limits)
        return pace


def _refuse_held(home: Array, robot: Robot, limits: Array) -> None:
    """Refuse a home (n,) where a joint is elsewhere than the study holds it."""
    for joint, value, low, high in zip(robot.joints, home, *limits, strict=False):
        if low == high and abs(value - low) > 1e-9:
            scale, unit = joint.kind.shown
            raise LocatedError(
                (f"home_{joint.kind.key}",),
                f"motion: home has {joint.name} at {scale * value:.6g}{unit}, but "
                f"joint_limits_{joint.kind.key} holds it at {scale * low:.6g}{unit}",
            )


def _speed(motion: MotionFile, robot: Robot) -> Array:
    """(n,) speeds, of all joints of a kind or by name."""
    turning, sliding = motion.max_speed_deg_s, motion.max_speed_mm_s
    speed = np.where(
        robot.prismatic,
        sliding if isinstance(sliding, float) else SLIDING_SPEED,
        turning if isinstance(turning, float) else SPEED,
    )
    for _, i, value in by_joint(robot, motion, "max_speed_{}_s"):
        speed[i] = value
    return speed


def _home(motion: MotionFile, robot: Robot) -> Array:
    if motion.home_deg is None and motion.home_mm is None:
        return unset()
    return configuration(robot, motion, "home_{}")
