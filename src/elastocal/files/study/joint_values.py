"""Joint values in files: by joint name, those of joints that turn and that slide under two keys."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.files.sections import Section
from elastocal.files.yaml_lines import LocatedError, Path_
from elastocal.robot.chain import Robot
from elastocal.robot.joint_kinds import KINDS


def by_joint(robot: Robot, entry: Section, keys: str) -> Iterator[tuple[Path_, int, Any]]:
    """(path, place of the joint in the chain, value) of what two keys give by joint name.

    Args:
        robot: The robot.
        entry: The section.
        keys: Its keys, with {} for "deg" of joints that turn and "mm" of those that slide.

    Raises:
        LocatedError: a joint is unknown, or under the wrong key.
    """
    for kind in KINDS:
        key = keys.format(kind.key)
        values = getattr(entry, key)
        for name, value in values.items() if isinstance(values, dict) else ():
            if name not in robot.joint_names:
                raise LocatedError(
                    (key, name), f"no joint {name!r}; the joints are {', '.join(robot.joint_names)}"
                )
            i = robot.joint_names.index(name)
            own = robot.joints[i].kind
            if own is not kind:
                right = keys.format(own.key)
                raise LocatedError((key, name), f"joint {name!r} belongs under {right}")
            yield (key, name), i, value


def configuration(robot: Robot, entry: Section, keys: str = "q_{}") -> Array:
    """(n,) joint vector [rad or m] of a section; all angles may stand in a list.

    Raises:
        LocatedError: a joint is missing, unknown, or under the wrong key.
    """
    angles, slides = (keys.format(kind.key) for kind in KINDS)
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
    values = {i: value for _, i, value in by_joint(robot, entry, keys)}
    for i, joint in enumerate(robot.joints):
        if i not in values:
            key = keys.format(joint.kind.key)
            raise LocatedError((key,), f"joint {joint.name!r} has no value in {key}")
    return np.array([values[i] for i in range(len(robot.joints))])
