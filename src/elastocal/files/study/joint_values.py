"""Joint values in files: by joint name, those of joints that turn and that slide under two keys."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.files.values import Section
from elastocal.files.yaml_lines import LocatedError, Path_
from elastocal.robot.chain import Robot


def by_joint(
    entry: Section, angles: str, slides: str, robot: Robot
) -> Iterator[tuple[Path_, int, Any]]:
    """(path, place of the joint in the chain, value) of what two keys give by joint name.

    Args:
        entry: The section.
        angles: Its key for joints that turn.
        slides: Its key for joints that slide.
        robot: The robot.

    Raises:
        LocatedError: a joint is unknown, or under the wrong key.
    """
    for key, right, prismatic in ((angles, slides, False), (slides, angles, True)):
        values = getattr(entry, key)
        for name, value in values.items() if isinstance(values, dict) else ():
            if name not in robot.joint_names:
                raise LocatedError(
                    (key, name), f"no joint {name!r}; the joints are {', '.join(robot.joint_names)}"
                )
            i = robot.joint_names.index(name)
            if robot.joints[i].prismatic != prismatic:
                raise LocatedError((key, name), f"joint {name!r} belongs under {right}")
            yield (key, name), i, value


def configuration(
    robot: Robot, entry: Section, angles: str = "q_deg", slides: str = "q_mm"
) -> Array:
    """(n,) joint vector [rad or m] of a section; all angles may stand in a list.

    Raises:
        LocatedError: a joint is missing, unknown, or under the wrong key.
    """
    every = getattr(entry, angles)
    if isinstance(every, list):
        if robot.prismatic.any():
            raise LocatedError(
                (angles,), f"the robot has sliding joints: give {angles} and {slides} by name"
            )
        if len(every) != len(robot.joints):
            raise LocatedError(
                (angles,),
                f"{angles} needs {len(robot.joints)} angles ({', '.join(robot.joint_names)}), "
                f"found {len(every)}",
            )
        return np.array(every)
    values = {i: value for _, i, value in by_joint(entry, angles, slides, robot)}
    for i, joint in enumerate(robot.joints):
        if i not in values:
            key = slides if joint.prismatic else angles
            raise LocatedError((key,), f"joint {joint.name!r} has no value in {key}")
    return np.array([values[i] for i in range(len(robot.joints))])
