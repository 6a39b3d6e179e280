"""Places: where the springs of unknowns are in an arm that stands at zero, to be held beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, freeze
from elastocal.elastic.unknowns import Unknowns
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture


@dataclass(frozen=True)
class SpringPlace:
    """Where one unknown gives way; base frame, all joints at zero.

    Attributes:
        name: The unknown.
        slides: Whether its springs slide; else they turn.
        behind: Joint whose body carries them; empty for the base.
        axes: (s, 3) axes of its s springs, unit vectors.
        origin: (3,) point that they go through [m].
    """

    name: str
    slides: bool
    behind: str
    axes: Array
    origin: Array

    def __post_init__(self) -> None:
        freeze(self, "axes", "origin")


def places_of(robot: Robot, unknowns: Unknowns) -> tuple[SpringPlace, ...]:
    """Where each unknown gives way, by the first of its springs."""
    springs, found = unknowns.springs, []
    posture = Posture(robot, np.zeros((1, len(robot.joints))))
    for name, column in zip(unknowns.names, unknowns.make.T, strict=True):
        own = np.flatnonzero(column).tolist()
        first = own[0]
        body = int(springs.body[first])
        axes = [posture.direction(springs.axis[s], int(springs.body[s]))[:, 0] for s in own]
        found.append(
            SpringPlace(
                name,
                bool(springs.prismatic[first]),
                "" if body == 0 else robot.moving[body - 1].name,
                np.array(axes),
                posture.point(springs.origin[first], body)[:, 0],
            )
        )
    return tuple(found)
