"""Within reach: joint ranges to which no motion leads from home, since a value between is closed.

In: a motion space. Out: joint limits without these ranges. A joint value is closed where the robot
collides whatever the other joints do, as where a forearm would have to pass through its upper arm.
Every motion to what lies beyond has to pass it.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import Doubt
from elastocal.motion.margins import motions_free, passing_free
from elastocal.motion.space import MotionSpace
from elastocal.robot.posture import Posture

_CHUNK = 2048  # configurations drawn together
_FREE = 400  # free configurations that are enough to see gaps in the values of a joint ...
_DRAWN = 8192  # ... and how many are drawn for them at most
_WIDE = 3.0  # gaps of so many times log(n) / n of a range do not come by chance
_SHARES = (0.5, 0.3, 0.7, 0.15, 0.85)  # where in a gap the value may be that is closed
_SURE = 20480  # configurations of which none is free where a value is closed
_ACROSS = 256  # motions tried to the other side


def reachable_limits(space: MotionSpace) -> Array:
    """(2, n) joint limits without what is beyond a value that is closed [rad or m].

    They are those of the space where nothing is found. What is left out is out of reach but for a
    passage that none of 20480 random configurations hits; what is left need not be within reach.

    Source: ours.
    """
    limits = np.array(space.limits)
    if not space.clearances:
        return limits
    rng, home = np.random.default_rng(0), space.pace.home
    drawn = (_draw(space, rng) for _ in range(_DRAWN // _CHUNK))
    free = home[None]
    while len(free) <= _FREE and (more := next(drawn, None)) is not None:
        free = np.vstack([free, more[passing_free(space, Posture(space.robot, more))]])
    for j in np.flatnonzero(limits[0] < limits[1]).tolist():
        for side in (1, 0):
            for near, far in _gaps(free[:, j], home[j], limits[:, j], upwards=side == 1):
                closed = _closed(space, j, near, far, rng)
                if closed is not None and not _passed(space, free, j, closed):
                    limits[side, j] = closed
                    free = free[(free[:, j] < closed) == (home[j] < closed)]
                    break
    return limits


def out_of_reach(space: MotionSpace) -> tuple[Doubt, ...]:
    """The joints of which a part of their range is out of reach."""
    limits = reachable_limits(space)
    return tuple(
        Doubt(
            "out-of-reach",
            (joint.name,),
            numbers={"lower": float(limits[0, j]), "upper": float(limits[1, j])},
            unit=joint.kind.unit,
        )
        for j, joint in enumerate(space.robot.joints)
        if (limits[:, j] != space.limits[:, j]).any()
    )


def _draw(space: MotionSpace, rng: np.random.Generator) -> Array:
    lower, upper = space.limits
    return rng.uniform(lower, upper, (_CHUNK, len(lower)))


def _gaps(
    values: Array, home: float, limits: Array, *, upwards: bool
) -> Iterator[tuple[float, float]]:
    """Gaps between values on one side of home, the nearest first: ends near and far from it."""
    sign = 1.0 if upwards else -1.0
    beyond = np.sort(sign * values[sign * values >= sign * home])
    least = max(_WIDE * np.log(len(values)) / len(values), 1e-3) * np.ptp(limits)
    for i in np.flatnonzero(np.diff(beyond) > least).tolist():
        yield sign * float(beyond[i]), sign * float(beyond[i + 1])


def _closed(
    space: MotionSpace, j: int, near: float, far: float, rng: np.random.Generator
) -> float | None:
    """A value of joint `j` between two others at which no configuration is free; None if none."""
    for share in _SHARES:
        value = near + share * (far - near)
        for _ in range(_SURE // _CHUNK):
            q = _draw(space, rng)
            q[:, j] = value
            if passing_free(space, Posture(space.robot, q)).any():
                break
        else:
            return value
    return None


def _passed(space: MotionSpace, free: Array, j: int, value: float) -> bool:
    """Whether a motion between free configurations passes a value of joint `j` all the same."""
    home, speed = space.pace.home, space.pace.speed
    ours = (free[:, j] < value) == (home[j] < value)
    far, own = free[~ours][:_ACROSS], free[ours]
    near = np.array([own[np.argmin((((own - q) / speed) ** 2).sum(axis=1))] for q in far])
    return any(
        motions_free(space, start, far).any() for start in (np.broadcast_to(home, far.shape), near)
    )
