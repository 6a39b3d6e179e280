"""Detour: configurations to pass when the straight motion between two others is blocked.

In: a motion space, start and goal. Out: via points, or None. First one point is tried, home or a
random free configuration, the shortest way first; then two trees grow towards each other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.constraints import margins_at
from elastocal.errors import InfeasibleError
from elastocal.motion.margins import (
    blocked,
    legs_of,
    motion_margins,
    motion_violations,
    motions_free,
    passing_free,
)
from elastocal.motion.space import MotionSpace
from elastocal.robot.joint_kinds import KINDS
from elastocal.robot.posture import Posture
from elastocal.wording import worded

_SINGLE = 200  # random configurations tried as the one via point
_TRIES = 1000  # random targets for the two trees
_STEP = 0.15  # longest edge of a tree over the size of the joint space


class UnreachableError(InfeasibleError):
    """No motion leads to a configuration `q`, (n,) [rad or m]."""

    def __init__(self, message: str, q: Array) -> None:
        super().__init__(message)
        self.q = q


def detours(space: MotionSpace, q: Array, *, seed: int = 0) -> tuple[Array, ...]:
    """Via points that make every motion of a plan free; empty if none are needed.

    Args:
        space: The robot, home and clearances.
        q: (S, n) configurations in order of execution [rad or m].
        seed: Of the random search.

    Returns:
        S + 1 arrays (K, n), see `motion.Vias`; an empty tuple if all motions are free as they are.

    Raises:
        UnreachableError: no way was found; names the motion and what is in its way.
    """
    if not space.clearances or not len(q):
        return ()
    straight = legs_of(space.pace.home, q)
    starts, goals = (np.array([leg[end] for leg in straight]) for end in (0, -1))
    margins = motion_margins(space, starts, goals)
    if margins.free.all():
        return ()
    found: list[Array] = []
    route = np.zeros((0, q.shape[1]))  # what was passed since home was left last
    for k, leg in enumerate(straight):
        between = route[:0]
        if not margins.free[k]:
            rng = np.random.default_rng([seed, k])
            way = way_around(space, leg[0], leg[1], rng)
            if way is None and k == len(q):
                way = route[::-1]  # home the way it came
            elif way is None and k > 0:
                way = _over_home(space, route, leg[1], rng)
            if way is None:
                doubt = blocked(margins, k, "no-way", leg=k, legs=len(straight))
                raise UnreachableError(worded(doubt), leg[1]).with_doubts(doubt)
            between = way
        found.append(between)
        route = np.vstack([route, *leg[:1][: min(k, 1)], between])
        home = np.flatnonzero((route == space.pace.home).all(axis=1))
        route = route[home[-1] + 1 :] if len(home) else route
    left = motion_violations(space, q, found)
    if left:
        raise InfeasibleError(worded(left[0])).with_doubts(*left)
    return tuple(found)


def _over_home(
    space: MotionSpace, route: Array, goal: Array, rng: np.random.Generator
) -> Array | None:
    """Back to home the way the robot came, and from there to `goal`."""
    home = space.pace.home
    forth = way_around(space, home, goal, rng)
    return None if forth is None else np.vstack([route[::-1], home, forth])


def refuse_home(space: MotionSpace) -> None:
    """Refuse a home at which the robot collides.

    Raises:
        InfeasibleError: names what touches what.
    """
    home = space.pace.home[None]
    if not space.clearances:
        return
    margins = motion_margins(space, home, home)
    if not margins.free[0]:
        kinds = {joint.kind for joint in space.robot.joints}
        keys = tuple(f"home_{kind.key}" for kind in KINDS if kind in kinds)
        doubt = replace(blocked(margins, 0, "home-blocked"), about=keys)
        raise InfeasibleError(worded(doubt)).with_doubts(doubt)


def way_around(
    space: MotionSpace, start: Array, goal: Array, rng: np.random.Generator
) -> Array | None:
    """(K, n) configurations to pass from `start` to `goal`, None if no way was found."""
    lower, upper = space.limits
    draws = rng.uniform(lower, upper, (_SINGLE, len(start)))
    draws = np.vstack([space.pace.home, (start + goal) / 2.0, draws])
    draws = draws[_free(space, draws)]
    speed = space.pace.speed
    length = (np.abs(draws - start) / speed).max(axis=1) + (np.abs(goal - draws) / speed).max(
        axis=1
    )
    draws = draws[np.argsort(length, kind="stable")]
    for begin in range(0, len(draws), 32):
        via = draws[begin : begin + 32]
        there = motions_free(space, np.broadcast_to(start, via.shape), via)
        there[there] = motions_free(space, via[there], np.broadcast_to(goal, via[there].shape))
        if there.any():
            return via[np.flatnonzero(there)[:1]]
    path = _connected(space, start, goal, rng)
    return None if path is None else _shortened(space, path)[1:-1]


def _free(space: MotionSpace, q: Array) -> BoolArray:
    """(N,) which configurations keep what is to be kept while moving."""
    posture = Posture(space.robot, q)
    return np.asarray(passing_free(space, posture) & _holding(space, posture))


def _holding(space: MotionSpace, posture: Posture) -> BoolArray:
    """(N,) at which postures everything holds that is no clearance."""
    return np.asarray((margins_at(space.holding, posture) >= 0.0).all(axis=0))


class _Tree:
    """Configurations that can be reached from a root, and from which."""

    def __init__(self, root: Array) -> None:
        self.q, self.parent = [root], [-1]

    def nearest(self, q: Array, speed: Array) -> int:
        return int((((np.array(self.q) - q) / speed) ** 2).sum(axis=1).argmin())

    def add(self, q: Array, parent: int) -> int:
        self.q.append(q)
        self.parent.append(parent)
        return len(self.q) - 1

    def branch(self, node: int) -> list[Array]:
        """From the root to a node."""
        points = []
        while node >= 0:
            points.append(self.q[node])
            node = self.parent[node]
        return points[::-1]


def _connected(
    space: MotionSpace, start: Array, goal: Array, rng: np.random.Generator
) -> list[Array] | None:
    """A free path of straight motions, None if the trees do not meet.

    Source: Kuffner & LaValle 2000, RRT-Connect.
    """
    lower, upper = space.limits
    speed = space.pace.speed
    step = _STEP * float(np.linalg.norm((upper - lower) / speed))
    if step == 0.0:
        return None  # every joint is held: there is nothing to try
    ours, other, swapped = _Tree(start), _Tree(goal), False
    for _ in range(_TRIES):
        target = rng.uniform(lower, upper)
        node = _extend(space, ours, target, step)
        if node is not None:
            meeting = ours.q[node]
            reached: int | None = 0
            while reached is not None:
                reached = _extend(space, other, meeting, step)
                if reached is not None and np.array_equal(other.q[reached], meeting):
                    path = [*ours.branch(node), *other.branch(reached)[-2::-1]]
                    return path[::-1] if swapped else path
        ours, other, swapped = other, ours, not swapped
    return None


def _extend(space: MotionSpace, tree: _Tree, target: Array, step: float) -> int | None:
    """A new node towards `target`, at most one step away; None if the motion is blocked."""
    near = tree.nearest(target, space.pace.speed)
    way = target - tree.q[near]
    length = float(np.linalg.norm(way / space.pace.speed))
    q = target if length <= step else tree.q[near] + way * (step / length)
    if not _holding(space, Posture(space.robot, q[None]))[0]:
        return None
    if not motions_free(space, tree.q[near][None], q[None])[0]:
        return None
    return tree.add(q, near)


def _shortened(space: MotionSpace, path: list[Array]) -> Array:
    """The path without points that a straight motion can leave out."""
    points = list(path)
    i = 0
    while i < len(points) - 2:
        ends = np.array(points[i + 2 :][::-1])
        free = motions_free(space, np.broadcast_to(points[i], ends.shape), ends)
        if free.any():
            last = len(points) - 1 - int(np.flatnonzero(free)[0])
            del points[i + 1 : last]
        i += 1
    return np.array(points)
