"""Lost: configurations of a plan to which no way leads, and how the next plan keeps away from them.

In: a motion space, configurations. Out: those without a way, and constraints.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.constraints import Distinct
from elastocal.design.continuous import ContinuousDesign
from elastocal.motion.margins import motions_free
from elastocal.motion.space import MotionSpace
from elastocal.motion.via_points import way_around
from elastocal.robot.chain import Robot

AGAIN = 4
"""Plans that are given up since no way leads to some of their configurations."""
_AWAY = 0.5  # how far the second plan keeps away from these [rad, m]; twice as far every time


def turned_into(limits: Array, design: ContinuousDesign, robot: Robot) -> ContinuousDesign:
    """A design whose joint values are moved by whole turns to between (2, n) limits, if they can.

    Designs are made for all that a study allows, plans for what is within reach.
    """
    n, x = len(robot.joints), np.array(design.x)
    q = x[:, :n]
    turns = 2.0 * np.pi * np.round((q - limits.mean(axis=0)) / (2.0 * np.pi))
    near = np.where(robot.prismatic, q, q - turns)
    move = _inside(limits, near) & ~_inside(limits, q)
    x[:, :n] = np.where(move, near, q)
    return replace(design, x=x) if move.any() else design


def _inside(limits: Array, q: Array) -> BoolArray:
    return np.asarray((q >= limits[0]) & (q <= limits[1]))


def others_lost(space: MotionSpace, q: Array, known: Array, seed: int) -> Iterator[Array]:
    """The configurations (S, n), besides the one known, to which no way leads from home."""
    home = np.broadcast_to(space.pace.home, q.shape)
    for k in np.flatnonzero(~motions_free(space, home, q)).tolist():
        if (q[k] == known).all():
            continue
        if way_around(space, home[k], q[k], np.random.default_rng([seed, k])) is None:
            yield q[k]


def away_from(q: Array, robot: Robot, same: Collection[str], again: int) -> Distinct:
    """Keep away from (n,) joint values that cannot be reached; joints in `same` do not count.

    The circle is twice as wide in every plan that is made again.
    """
    counts = np.array([float(name not in same) for name in robot.joint_names])
    return Distinct("distance from what cannot be reached", q, counts, _AWAY * 2.0**again)
