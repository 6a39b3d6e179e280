"""Which pairs of solids are watched, and which are left out because they always touch.

In: the solids of robot and tool, obstacles, names to leave out. Out: `Pairs`, and what is left out.
As in an allowed collision matrix: neighbours are left out, and so are pairs that touch in nearly
all of many random configurations; capsules and boxes say that, without their faces: rods and
wrists are made to be near. Of those the outer part is watched, if it is a capsule: whether it folds
back. All that is left out is said.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.collision.distance import Pairs, nearest
from elastocal.constraints.collision.solid import Solid, beyond, without_faces
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture
from elastocal.robot.reach import first_turning, random_posture

_NATURE = 0.95  # in this share of random configurations what touches is made to; as MoveIt takes it
_MOSTLY = 0.5  # share of configurations in which parts that are always close are nearer still
_FOLDED = 2.0  # 1 / sin 30°: two links are nearer than they may be when folded further than that


@dataclass(frozen=True)
class Unwatched:
    """Two bodies or things whose contact is not watched.

    Attributes:
        first: Name of the one.
        second: Name of the other.
        why: "ignored" by the study, "neighbours", "always-touch", "always-near" (nearer than the
            margin), "always-close" (never farther apart than twice the margin), "stands-on-it" or
            "below-it".
    """

    first: str
    second: str
    why: str


def self_pairs(
    robot: Robot,
    limits: Array,
    solids: Sequence[Solid],
    ignore: Sequence[tuple[str, str]],
    margin: float = 0.0,
) -> tuple[Pairs, tuple[Unwatched, ...]]:
    """Pairs of solids of the robot itself, tool included, that are to be watched.

    Args:
        robot: The robot.
        limits: (2, n) joint limits in which random configurations are drawn [rad or m].
        solids: Solids of robot and tool.
        ignore: Pairs of names that the user leaves out.
        margin: Pairs that are nearly always nearer than this are left out, too [m].
    """
    left: dict[tuple[str, str], str] = {}
    # Bodies of several solids are judged as one: which of them are nearest may change.
    groups: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for pair in combinations(range(len(solids)), 2):
        j, i = sorted(pair, key=lambda s: solids[s].body)
        names = solids[j].name, solids[i].name
        if solids[i].body == solids[j].body:
            continue
        if ignored(solids[i], solids[j], ignore):
            left[names] = "ignored"
        else:
            groups.setdefault(names, []).append((i, j))
    posture = random_posture(robot, limits)
    everything, kept = list(solids), []
    plain = [without_faces(solid) for solid in solids]
    for names, group in groups.items():
        why = _always(posture, plain, group, margin)
        if not why:
            kept += group
            continue
        left[names] = why
        for piece, other in _outer(posture, plain, group, margin):
            kept.append((len(everything), other))
            everything.append(piece)
    # Of two bodies of several solids each, some pairs may be watched and some left out.
    partly = {frozenset((everything[i].name, everything[j].name)) for i, j in kept}
    unwatched = [Unwatched(*p, why) for p, why in left.items() if frozenset(p) not in partly]
    return Pairs(tuple(everything), tuple(kept)), tuple(unwatched)


def _always(
    posture: Posture, solids: Sequence[Solid], group: Sequence[tuple[int, int]], margin: float
) -> str:
    """Why the pairs of two bodies cannot be watched; empty if they can."""
    i, j = group[0]
    if posture.robot.carriers[solids[i].body] == solids[j].body:
        return "neighbours"
    gap = nearest(Pairs(tuple(solids), tuple(group)), posture, 2.0 * margin).value
    if not _by_nature(gap, margin):
        return ""
    if (gap < margin).mean() < _NATURE:
        return "always-close"
    return "always-touch" if (gap < 0.0).mean() >= _NATURE else "always-near"


def _by_nature(gap: Array, margin: float) -> bool:
    """Whether parts with these gaps [m], measured up to twice the margin, are made to be near.

    Of some, as in a wrist, the gap hardly changes: whether it keeps the margin says more of the
    solids put around them than of the robot.
    """
    near = (gap < margin).mean()
    return bool(near >= _NATURE or (near >= _MOSTLY and gap.max() < 2.0 * margin))


def _outer(
    posture: Posture, solids: Sequence[Solid], group: Iterable[tuple[int, int]], margin: float
) -> Iterable[tuple[Solid, int]]:
    """Outer parts of capsules near another solid by nature, each with that solid's number.

    What is left out is as long as two links need to be clear of each other when one is folded
    30° short of back onto the other.
    """
    for i, j in group:
        if solids[i].covered or solids[j].covered:
            continue
        piece = _piece(posture.robot, solids[i], solids[j].radius + margin)
        if piece is None:
            continue
        gap = nearest(Pairs((piece, solids[j]), ((0, 1),)), posture, np.inf).value
        if not _by_nature(gap, margin) and np.ptp(gap) > _STILL:
            yield piece, j


def _piece(robot: Robot, solid: Solid, room: float) -> Solid | None:
    """The outer part of a capsule that folds towards what has, or needs, so much room [m]."""
    slides = robot.sliding[solid.body - 1]
    return None if slides else beyond(solid, _FOLDED * (solid.radius + room))


_STILL = 1e-6  # a distance that changes less is fixed [m]


def obstacle_pairs(
    robot: Robot,
    limits: Array,
    solids: Sequence[Solid],
    obstacle: Sequence[Solid],
    ignore: Sequence[tuple[str, str]],
    margin: float = 0.0,
) -> tuple[Pairs, tuple[Unwatched, ...]]:
    """Pairs of a solid of the robot and one of an obstacle that are to be watched.

    The first links, up to the first joint that turns, are left out if they touch at a depth that
    never changes: they stand on the obstacle. All else is watched, even what touches always: a
    wall may be in the way. Of a link that is always nearer than the margin to the floor, the outer
    part is.

    Args:
        robot: The robot.
        limits: (2, n) joint limits in which random configurations are drawn [rad or m].
        solids: Solids of robot and tool.
        obstacle: Solids of the obstacle.
        ignore: Pairs of names that the user leaves out.
        margin: Distance to keep [m].
    """
    index, left = [], {}
    moving = [solid for solid in solids if solid.body]
    everything = [*moving, *obstacle]
    posture = random_posture(robot, limits)
    first = first_turning(robot)
    standing = robot.last if first == len(robot.joints) else int(robot.place[first]) + 1
    for i, solid in enumerate(moving):
        for j, thing in enumerate(obstacle, len(moving)):
            names = (solid.name, thing.name)
            if ignored(solid, thing, ignore):
                left[names] = "ignored"
                continue
            floor = thing.kind == "plane"
            room = margin if floor else 0.0
            gap = nearest(Pairs((solid, thing), ((0, 1),)), posture, room).value
            if solid.body <= standing and (gap < room).all() and np.ptp(gap) < _STILL:
                below = floor and _top(posture, solid) < thing.pose[2, 3]
                left[names] = "below-it" if below else "stands-on-it"
            elif floor and (gap < room).all():
                piece = _piece(robot, solid, margin)
                if piece is None:
                    left[names] = "always-near"
                else:
                    index.append((len(everything), j))
                    everything.append(piece)
            else:
                index.append((i, j))
    return Pairs(tuple(everything), tuple(index)), tuple(
        Unwatched(*p, why) for p, why in left.items()
    )


def _top(posture: Posture, solid: Solid) -> float:
    """Height in the base frame [m] that no point of a solid is above."""
    frame = posture.bodies[solid.body]
    ends = np.einsum("ijn,kj->kin", frame[:3].transpose(1, 0, 2), solid.segment) + frame[3]
    return float(ends[:, 2].max()) + solid.radius


def ignored(a: Solid, b: Solid, ignore: Sequence[tuple[str, str]]) -> bool:
    """Whether the user leaves this pair out, by the names of solids or of joints."""
    first, second = {a.name, a.joint}, {b.name, b.joint}
    return any((x in first and y in second) or (x in second and y in first) for x, y in ignore)
