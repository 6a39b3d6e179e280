"""What tells one robot from another: its joint axes as one short text, the same everywhere."""

from __future__ import annotations

import hashlib

import numpy as np

from elastocal.robot.chain import Robot, moved

_DIGITS = 9  # of a metre and of a direction: far below what is built, far above rounding


def geometry_hash(robot: Robot) -> str:
    """SHA-256 of the joint axes of a robot at zero, by name: as lines in space, in the base frame.

    It does not depend on how the robot was described, nor on limits, masses, shapes and tools.

    Source: ours; a line is its direction and its moment about the origin, to nine digits.
    """
    T, lines = np.eye(4), []
    follows = {follower.joint.name: follower for follower in robot.followers}
    for joint, stands in zip(robot.moving[: robot.last], robot.standing, strict=False):
        T = T @ joint.T_parent_joint
        direction = T[:3, :3] @ joint.axis
        # What slides has a direction only.
        moment = np.zeros(3) if joint.prismatic else np.cross(T[:3, 3], direction)
        numbers = np.round([*direction, *moment], _DIGITS) + 0.0  # no minus before zero
        values = " ".join(f"{v:.{_DIGITS}f}" for v in numbers)
        lines.append(f"{joint.name} {joint.kind.name} {values}\n")
        if follower := follows.get(joint.name):
            T = T @ moved(joint, float(stands))
            lines.append(f"{follower.factor:.{_DIGITS}f} of {follower.leader}\n")
    return hashlib.sha256("".join(lines).encode()).hexdigest()
