"""Rest: where a campaign starts and ends if nobody says so."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import margins_at
from elastocal.motion.space import MotionSpace
from elastocal.robot.posture import Posture
from elastocal.robot.reach import first_turning, random_posture

_STEP = float(np.radians(30.0))
_JOINTS = 3  # after the first one that turns: they raise the arm and turn the wrist out of the way
_CHUNK = 256  # configurations looked at together


def at_rest(space: MotionSpace) -> MotionSpace:
    """The space with a home that is free, as near to the one it has as round values allow.

    Where the robot touches nothing at home, or everywhere, home stays as it is.

    Source: ours.
    """
    if not space.clearances:
        return space
    for q in _candidates(space):
        room = margins_at(space.clearances, Posture(space.robot, q)).min(axis=0)
        if (room >= 0.0).any():
            home = q[int((room >= 0.0).argmax())]
            return replace(space, pace=replace(space.pace, home=home))
    return space


def _candidates(space: MotionSpace) -> Iterator[Array]:
    """(K, n) configurations: home; with some joints at multiples of 30°; at last any."""
    rest = space.pace.home
    yield rest[None]
    first = first_turning(space.robot) + 1
    raised = [j for j in range(first, len(rest)) if not space.robot.prismatic[j]][:_JOINTS]
    choices = [_round_angles(rest[j], *space.limits[:, j]) for j in raised]
    turned = np.array(list(product(*choices))).reshape(-1, len(raised))
    near = np.repeat(rest[None], len(turned), axis=0)
    near[:, raised] = turned
    scale = space.robot.shown_scale
    anywhere = np.round(scale * random_posture(space.robot, space.limits).q.T) / scale
    anywhere = np.clip(anywhere, *space.limits)
    for q in (near, anywhere):
        far = (np.abs(q - rest) / space.pace.speed).sum(axis=1)
        q = q[np.argsort(far, kind="stable")]
        yield from (q[i : i + _CHUNK] for i in range(0, len(q), _CHUNK))


def _round_angles(rest: float, lower: float, upper: float) -> Array:
    """Angles within limits: the one at rest, and multiples of 30° [rad]."""
    angles = _STEP * np.arange(np.ceil(lower / _STEP), np.floor(upper / _STEP) + 1)
    return np.append(rest, angles[np.abs(angles) <= np.pi])
