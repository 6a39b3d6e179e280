"""Motion: how near straight motions in joint space come to anything that must not be touched.

In: a motion space, starts and goals. Out: the least margin along each motion, with where and what.
Nothing is skipped between samples: an interval of a motion is only left when the distance at its
middle is more than any point can move within it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, frozen
from elastocal.constraints import Clearance, margins_at
from elastocal.constraints.collision.distance import Pairs, nearest
from elastocal.errors import Code, Doubt
from elastocal.motion.space import MotionSpace
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture

TOLERANCE = 1e-3
"""Margins along a motion are known to this [m], on the safe side."""
_CHUNK = 2048  # intervals looked at together


@dataclass(frozen=True)
class MotionMargins:
    """How near M straight motions come to a collision.

    Attributes:
        margin: (M,) at least so much room is left everywhere, beyond what is to be kept while
            moving [m]; negative if a motion is not allowed. Plenty is said to be `enough`.
        share: (M,) where along the motion it is least, from 0 to 1.
        distance: (M,) signed distance there [m]; infinite where there is plenty.
        pairs: M times the names of what comes near what; empty where there is plenty.
    """

    margin: Array
    share: Array
    distance: Array
    pairs: tuple[tuple[str, ...], ...]

    @property
    def free(self) -> BoolArray:
        """(M,) which motions are allowed."""
        return np.asarray(self.margin >= 0.0)


def motion_margins(
    space: MotionSpace, starts: Array, goals: Array, *, enough: float = 0.02, decide: bool = False
) -> MotionMargins:
    """Least margin along M straight motions in joint space.

    Args:
        space: The robot and its clearances.
        starts: (M, n) where they start [rad or m].
        goals: (M, n) where they end.
        enough: Margins above this are not measured [m].
        decide: Stop at the first collision: `margin` is then right in its sign only.

    Source: ours; conservative advancement by halving, with the bound of `point_speed`.
    """
    count = len(starts)
    margin, share = np.full(count, enough), np.zeros(count)
    distance = np.full(count, np.inf)
    pairs: list[tuple[str, ...]] = [()] * count
    for clearance in space.clearances:
        found = _least(space.robot, clearance, starts, goals, enough, decide)
        for i in np.flatnonzero(found[0] < margin).tolist():
            margin[i], share[i], distance[i] = found[0][i], found[1][i], found[2][i]
            first, second = clearance.pairs.of(int(found[3][i]))
            pairs[i] = (second.name, first.name)
    return MotionMargins(frozen(margin), frozen(share), frozen(distance), tuple(pairs))


def _least(
    robot: Robot, clearance: Clearance, starts: Array, goals: Array, enough: float, decide: bool
) -> tuple[Array, Array, Array, IntArray]:
    """Margin, share, distance and pair where M motions are nearest to breaking one clearance."""
    count = len(starts)
    keep, pairs = clearance.keep_moving, clearance.pairs
    speed = relative_speed(robot, pairs, starts, goals)
    best, share = np.full(count, np.inf), np.zeros(count)
    pair = np.full(count, -1, dtype=np.int64)
    motion = np.arange(count)
    middle, half = np.full(count, 0.5), np.full(count, 0.5)
    while len(motion) and len(pairs):
        order = slice(0, _CHUNK)  # depth first where there is much to do
        m, s, h = motion[order], middle[order], half[order]
        q = starts[m] + s[:, None] * (goals[m] - starts[m])
        found = nearest(pairs, Posture(robot, q), keep + enough, speed[:, m] * h)
        seen = found.pair >= 0
        for i in np.flatnonzero(seen & (found.distance < best[m])).tolist():
            if found.distance[i] < best[m[i]]:
                best[m[i]], share[m[i]], pair[m[i]] = found.distance[i], s[i], found.pair[i]
        floor = best[m] - TOLERANCE
        if decide:  # known to be broken: nothing more to learn
            floor = np.where(best[m] - TOLERANCE < keep, -np.inf, floor)
        todo = seen & (found.value < floor)
        m, s, h = m[todo], s[todo], h[todo] / 2.0
        motion = np.concatenate([m, m, motion[_CHUNK:]])
        middle = np.concatenate([s - h, s + h, middle[_CHUNK:]])
        half = np.concatenate([h, h, half[_CHUNK:]])
    return best - TOLERANCE - keep, share, best, pair


def relative_speed(robot: Robot, pairs: Pairs, starts: Array, goals: Array) -> Array:
    """(P, M) bounds on how fast a point of the first solid can move for the second [m per motion].

    A joint that turns by Δq moves no point by more than Δq times its distance from the axis, and
    that is at most the length of the chain from the joint to the solid and the solid's reach.
    Both solids are seen from the last body that carries them both.

    Source: ours; triangle inequality.
    """
    way = np.abs((goals - starts) @ robot.mixing.T).T
    ends = [np.abs(q @ robot.mixing.T + robot.standing).T for q in (starts, goals)]
    slides = robot.sliding
    travel = np.where(slides[:, None], np.maximum(*ends), 0.0)
    links = np.concatenate([robot.links[:-1], robot.branches])
    lengths = np.linalg.norm(links[:, :3, 3], axis=1)
    speed = np.zeros((len(pairs), len(starts)))
    for p in range(len(pairs)):
        solids = pairs.of(p)
        shared = robot.carries[solids[0].body] & robot.carries[solids[1].body]
        for solid in solids:
            body, arm = solid.body, np.full(len(starts), solid.reach)
            while body and not shared[body - 1]:
                speed[p] += way[body - 1] * (1.0 if slides[body - 1] else arm)
                arm = arm + travel[body - 1] + lengths[body - 1]
                body = int(robot.carriers[body])
    return speed


def passing_free(space: MotionSpace, posture: Posture) -> BoolArray:
    """(N,) which postures keep of every clearance what is to be kept while moving."""
    clearances = [clearance.on_the_way for clearance in space.clearances]
    return np.asarray((margins_at(clearances, posture) > 0.0).all(axis=0))


def motions_free(space: MotionSpace, starts: Array, goals: Array) -> BoolArray:
    """(M,) which of the straight motions from (M, n) starts to goals are free."""
    return motion_margins(space, starts, goals, enough=0.0, decide=True).free


def blocked(margins: MotionMargins, i: int, code: Code = "motion-blocked", **where: float) -> Doubt:
    """What motion `i` comes near that it must not; `where` says which motion of a plan it is."""
    distance = float(margins.distance[i])
    keep = distance - float(margins.margin[i]) - TOLERANCE
    numbers = {"share": float(margins.share[i]), "distance": distance, "keep": keep}
    return Doubt(code, because=margins.pairs[i], numbers=numbers | where)


Vias = Sequence[Array]
"""S + 1 arrays (K, n): configurations passed on the way to each load case, then to home."""


def motion_violations(space: MotionSpace, q: Array, via: Vias = ()) -> tuple[Doubt, ...]:
    """The motions of a plan that are not allowed.

    Args:
        space: The robot, home and clearances.
        q: (S, n) configurations in order of execution [rad or m].
        via: Configurations passed in between; none if empty.
    """
    if not space.clearances or not len(q):
        return ()
    legs = legs_of(space.pace.home, q, via)
    starts = np.concatenate([leg[:-1] for leg in legs])
    goals = np.concatenate([leg[1:] for leg in legs])
    margins = motion_margins(space, starts, goals)
    found, at = [], 0
    for k, leg in enumerate(legs):
        parts = len(leg) - 1
        for part in range(parts):
            if not margins.free[at]:
                where = blocked(margins, at, leg=k, legs=len(legs), part=part + 1, parts=parts)
                found.append(where)
            at += 1
    return tuple(found)


def legs_of(home: Array, q: Array, via: Vias = ()) -> list[Array]:
    """S + 1 arrays (K + 2, n): from home to each configuration and back home, all points."""
    stops = [home, *q, home]
    between = via or [np.zeros((0, len(home)))] * (len(q) + 1)
    return [np.vstack([stops[k], between[k], stops[k + 1]]) for k in range(len(q) + 1)]
