"""Approach points: where the robot comes from, so that backlash is always taken up the same way.

In: configurations, limits, constraints. Out: for every configuration a point beside it, from which
every axis turns or slides a small amount to get there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.constraints import Constraint, margins_at
from elastocal.errors import InputError
from elastocal.motion.margins import motions_free
from elastocal.motion.space import MotionSpace
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture

_ROUNDING = 1e-9  # of a joint value at its limit [rad, m]
_TOLERANCE = 1e-5  # of a margin, as in `assessment`
_TRIED = 4096  # combinations of sides: all of them up to twelve joints


@dataclass(frozen=True)
class Approach:
    """How a pose is approached and measured.

    Attributes:
        angle: How far before the pose joints that turn start [rad].
        length: The same of joints that slide [m].
        settle: Wait before every measurement [s].
    """

    angle: float = float(np.radians(0.5))
    length: float = 1e-3
    settle: float = 2.0

    def __post_init__(self) -> None:
        for value, unit in ((np.degrees(self.angle), "°"), (1e3 * self.length, " mm")):
            if not (np.isfinite(value) and value >= 0.0):
                raise InputError(
                    f"an approach distance must be finite and not negative, found {value:g}{unit}"
                )


def approaches(
    robot: Robot,
    q: Array,
    amount: Array,
    limits: Array,
    constraints: Sequence[Constraint] = (),
    space: MotionSpace | None = None,
) -> tuple[Array, bool]:
    """Approach points of configurations, within limits and constraints.

    Every axis comes from the side of smaller joint values where possible. Where a limit or a
    constraint is in the way, as few axes as possible come from the other side, the same axes for
    all configurations; only if that cannot be, each configuration has its own sides. Where a
    configuration has none, clearances are only what motions keep.

    Args:
        robot: The robot.
        q: (S, n) configurations, within the limits [rad or m].
        amount: (n,) how far away each axis starts, not negative [rad or m].
        limits: (2, n) lower and upper joint values [rad or m].
        constraints: Constraints that hold at the approach points too.
        space: Where clearances may be less, as long as the motions to the configurations are free;
            nowhere if None.

    Returns:
        The (S, n) approach points [rad or m], and whether all have the same sides.

    Raises:
        InputError: no side is free; the message names configuration, joint or constraint.
    """
    moving = np.flatnonzero(amount > 0.0).astype(np.int64)
    if not len(moving) or not len(q):
        return q.copy(), True
    own, missing = np.array(q), np.ones(len(q), dtype=bool)
    for passing in (False, True) if space and space.clearances else (False,):
        if passing:
            constraints = [constraint.on_the_way for constraint in constraints]
        for sides in _sides(len(amount), moving):
            points = q - sides * amount
            free = _free(robot, points, limits, constraints)
            if passing and space:
                free[free] = motions_free(space, points[free], q[free])
            if free.all():
                return points, True
            own[free & missing] = points[free & missing]
            missing &= ~free
        if not missing.any():
            return own, False
    i = int(missing.argmax())
    raise InputError(_obstacle(robot, i, q[i], amount, limits, constraints))


def _sides(n: int, moving: IntArray) -> Iterator[Array]:
    """(n,) +1 for axes that come from smaller values, -1 from larger; fewest -1 first."""
    tried = 0
    for flips in range(len(moving) + 1):
        for flipped in combinations(moving.tolist(), flips):
            sides = np.ones(n)
            sides[list(flipped)] = -1.0
            yield sides
            tried += 1
            if tried >= _TRIED:
                return


def _free(
    robot: Robot, points: Array, limits: Array, constraints: Sequence[Constraint]
) -> BoolArray:
    """(S,) which points are within limits and constraints."""
    over = np.maximum(limits[0] - points, points - limits[1])
    inside = np.asarray((over <= _ROUNDING).all(axis=1))
    if inside.any() and constraints:
        room = margins_at(constraints, Posture(robot, points[inside]))
        inside[inside] = (room >= -_TOLERANCE).all(axis=0)
    return inside


def _obstacle(
    robot: Robot,
    i: int,
    q: Array,
    amount: Array,
    limits: Array,
    constraints: Sequence[Constraint],
) -> str:
    """Why a configuration cannot be approached."""
    way_out = "use a smaller approach distance, 0 for none"
    for j, joint in enumerate(robot.joints):
        below, above = q[j] - limits[0, j], limits[1, j] - q[j]
        if max(below, above) < amount[j] - _ROUNDING:
            scale, unit = joint.kind.shown
            return (
                f"configuration {i + 1} cannot be approached: joint {joint.name!r} has only "
                f"{scale * max(below, above):.4g}{unit} of room for an approach of "
                f"{scale * amount[j]:.4g}{unit}; {way_out}, or plan with a joint margin"
            )
    worst, posture = "a joint limit", Posture(robot, (q - amount)[None])
    if constraints:
        room = margins_at(constraints, posture)[:, 0]
        worst = constraints[int(np.argmin(room))].names_at(posture)[0]
    return f"configuration {i + 1} cannot be approached within {worst}; {way_out}"
