"""Joints that follow other joints (mimic): from which joint that moves on its own, and how.

In: the joints of a URDF. Out: for each that follows, the joint at the end of its line of leaders,
with factor and offset: value = factor · leader + offset.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from elastocal.errors import InputError
from elastocal.robot.sources.urdf_elements import UrdfJoint


class Following(NamedTuple):
    """How the value of a joint follows from that of another: factor · leader + offset."""

    leader: str
    factor: float
    offset: float


def followings(joints: Sequence[UrdfJoint]) -> dict[str, Following]:
    """By name of those joints that follow another: which one in the end, and how.

    Raises:
        InputError: a leader is not there, or follows in a circle.
    """
    by_name = {joint.name: joint for joint in joints}
    found: dict[str, Following] = {}
    for joint in joints:
        line = _line(joint, by_name, found)
        for follower in reversed(line):
            leader, factor, offset = follower.follows
            if leader in found:
                leader, more, shift = found[leader]
                factor, offset = factor * more, factor * shift + offset
            if not (np.isfinite(factor) and np.isfinite(offset)):
                raise InputError(f"{follower.at} follows {leader!r} beyond all numbers")
            found[follower.name] = Following(leader, factor, offset)
    return found


def _line(
    joint: UrdfJoint, by_name: Mapping[str, UrdfJoint], known: Mapping[str, Following]
) -> list[UrdfJoint]:
    """The joint and its leaders, as far as they follow themselves and are not known yet."""
    line: list[UrdfJoint] = []
    passed: set[str] = set()
    while joint.follows.leader and joint.name not in known:
        if joint.name in passed:
            raise InputError(f"{line[0].at} follows in a circle, through joint {joint.name!r}")
        line.append(joint)
        passed.add(joint.name)
        leader = joint.follows.leader
        if leader not in by_name:
            raise InputError(f"{joint.at} follows joint {leader!r} (mimic), which is not there")
        joint = by_name[leader]
    return line
