"""Which pairs of solids are watched, and which are left out because they always touch.

In: the solids of robot and tool, obstacles, names to leave out. Out: `Pairs`, and what is left out.
As in an allowed collision matrix: neighbours are left out, and so are pairs that touch in every one
of many random configurations. All that is left out is said.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.collision.distance import Pairs, nearest
from elastocal.constraints.collision.solid import Solid
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture

_SAMPLES = 1000  # random configurations


@dataclass(frozen=True)
class Unwatched:
    """Two bodies or things whose contact is not watched.

    Attributes:
        first: Name of the one.
        second: Name of the other.
        why: "ignored" by the study, "neighbours", "always-touch", "always-near" (nearer than the
            margin) or "stands-on-it".
    """

    first: str
    second: str
    why: str


def self_pairs(
    robot: Robot,
    limits: Array,
    solids: Sequence[Solid],
    ignore: Sequence[tuple[str, str]],
    also: Sequence[tuple[Solid, Solid]] = (),
    margin: float = 0.0,
) -> tuple[Pairs, tuple[Unwatched, ...]]:
    """Pairs of solids of the robot itself, tool included, that are to be watched.

    Args:
        robot: The robot.
        limits: (2, n) joint limits in which random configurations are drawn [rad or m].
        solids: Solids of robot and tool.
        ignore: Pairs of names that the user leaves out.
        also: Further pairs of a new solid and one of `solids`.
        margin: Pairs that are always nearer than this are left out, too [m].
    """
    index: list[tuple[int, int]] = []
    left: dict[tuple[str, str], str] = {}
    for i, j in combinations(range(len(solids)), 2):
        a, b = solids[i], solids[j]
        if a.body == b.body:
            continue
        if ignored(a, b, ignore):
            left[a.name, b.name] = "ignored"
        elif robot.carrier(max(a.body, b.body)) == min(a.body, b.body):
            left[a.name, b.name] = "neighbours"
        else:
            index.append((i, j) if a.body > b.body else (j, i))
    solids = list(solids)
    posture = _random_posture(robot, limits)
    # Bodies of several solids are judged as one: which of them are nearest may change.
    groups: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for i, j in index:
        groups.setdefault((solids[j].name, solids[i].name), []).append((i, j))
    candidates = [(*names, group) for names, group in groups.items()]
    for new, known in also:
        if not ignored(new, known, ignore):
            pair = len(solids), next(i for i, s in enumerate(solids) if s is known)
            candidates.append((known.name, new.name, [pair]))
            solids.append(new)
    kept = []
    for first, second, group in candidates:
        gap = nearest(Pairs(tuple(solids), tuple(group)), posture, margin).value
        if (gap < margin).all():
            touch = bool((gap < 0.0).all())
            left[first, second] = "always-touch" if touch else "always-near"
        else:
            kept += group
    # Of two bodies of several solids each, some pairs may be watched and some left out.
    partly = {frozenset((solids[i].name, solids[j].name)) for i, j in kept}
    unwatched = [Unwatched(*p, why) for p, why in left.items() if frozenset(p) not in partly]
    return Pairs(tuple(solids), tuple(kept)), tuple(unwatched)


def obstacle_pairs(
    robot: Robot,
    limits: Array,
    solids: Sequence[Solid],
    obstacle: Sequence[Solid],
    ignore: Sequence[tuple[str, str]],
) -> tuple[Pairs, tuple[Unwatched, ...]]:
    """Pairs of a solid of the robot and one of an obstacle that are to be watched.

    The first links, up to the first joint that turns, are left out if they touch at a depth that
    never changes: they stand on the obstacle. All else is watched, even what touches always: a
    wall may be in the way.
    """
    index, left = [], {}
    everything = [*solids, *obstacle]
    posture = _random_posture(robot, limits)
    turning = np.flatnonzero(~robot.prismatic)
    standing = 1 + int(turning[0]) if len(turning) else len(robot.joints)
    for i, solid in enumerate(solids):
        for j, thing in enumerate(obstacle, len(solids)):
            if solid.body == 0:
                continue
            names = (solid.name, thing.name)
            if ignored(solid, thing, ignore):
                left[names] = "ignored"
                continue
            gap = nearest(Pairs((solid, thing), ((0, 1),)), posture, 0.0).value
            if solid.body <= standing and (gap < 0.0).all() and np.ptp(gap) < 1e-6:
                left[names] = "stands-on-it"
            else:
                index.append((i, j))
    return Pairs(tuple(everything), tuple(index)), tuple(
        Unwatched(*p, why) for p, why in left.items()
    )


def ignored(a: Solid, b: Solid, ignore: Sequence[tuple[str, str]]) -> bool:
    """Whether the user leaves this pair out, by the names of solids or of joints."""
    first, second = {a.name, a.joint}, {b.name, b.joint}
    return any((x in first and y in second) or (x in second and y in first) for x, y in ignore)


def _random_posture(robot: Robot, limits: Array) -> Posture:
    rng = np.random.default_rng(0)
    return Posture(robot, rng.uniform(limits[0], limits[1], (_SAMPLES, len(robot.joints))))
