"""The cell around a robot: what must not touch what, as constraints.

In: robot, tool, joint limits, obstacles, rules. Out: one `Clearance` for every obstacle, one for
the floor and one for the robot itself. Each knows which pairs it does not watch, and why.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from elastocal.arrays import Array
from elastocal.constraints.clearance import Clearance
from elastocal.constraints.collision.chain import (
    LINK_SHARE,
    Radii,
    robot_solids,
    solids_at_hand,
    tool_solids,
)
from elastocal.constraints.collision.coal_distance import coal
from elastocal.constraints.collision.contacts import obstacle_pairs, self_pairs
from elastocal.constraints.collision.solid import Solid, plane, solids_of
from elastocal.errors import Doubt, InputError
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.posture import Posture
from elastocal.robot.reach import first_turning, reach_of
from elastocal.robot.shapes import Shape
from elastocal.wording import worded

ITSELF = "itself"
"""What the robot is called as an obstacle to its own motion."""
FLOOR = "floor"
"""What the floor is called; an obstacle of that name takes its place."""

_UPRIGHT = float(np.cos(np.radians(1.0)))  # how near to vertical an axis is


@dataclass(frozen=True)
class CollisionRules:
    """What counts as a collision.

    Attributes:
        margin: Distance to keep at the poses of a plan [m].
        motion_margin: Distance to keep while moving between them [m]; None for half of `margin`.
        itself: Whether the robot must not touch itself.
        floor: Height of the floor in the base frame [m]; None where none is watched.
        ignore: Pairs of names that may touch: joints, links, "base", "tool", "floor", obstacles.
        as_capsules: Whether to put capsules around the shapes of the links: larger, and faster.
        at_hand: Whether shapes that cannot be read are left to capsules along the chain.
        link_radius: Radius of the capsules of a robot without shapes.
    """

    margin: float = 0.02
    motion_margin: float | None = None
    itself: bool = True
    floor: float | None = None
    ignore: tuple[tuple[str, str], ...] = ()
    as_capsules: bool = False
    at_hand: bool = False
    link_radius: Radii = None


def usual_rules(robot: Robot, gravity: ArrayLike = (0.0, 0.0, 0.0)) -> CollisionRules:
    """What counts as a collision if nothing is said: see `default_clearances`."""
    floor = 0.0 if stands_upright(robot, gravity) else None
    return CollisionRules(floor=floor, as_capsules=True, at_hand=True)


def default_clearances(
    robot: Robot,
    tool: Tool,
    limits: ArrayLike | None = None,
    gravity: ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[Clearance, ...]:
    """What study files watch if they say nothing, for the constraints of a `Study`.

    The robot keeps 20 mm from itself: convex solids of few faces around its shapes, or capsules
    along its chain. Where its first axis stands upright, links and tool keep as much from a floor
    at z = 0 of the base frame.
    Nothing is refused, and no package is needed.

    Args:
        robot: The robot.
        tool: What it carries in the experiments.
        limits: (2, n) joint limits [rad or m]; the robot's if not given.
        gravity: (3,) acceleration in the base frame [m/s²], if it is known.
    """
    room = np.array([robot.lower, robot.upper]) if limits is None else np.asarray(limits)
    return clearances(robot, tool, room, (), usual_rules(robot, gravity))


def stands_upright(robot: Robot, gravity: ArrayLike = (0.0, 0.0, 0.0)) -> bool:
    """Whether a robot stands on a level floor at z = 0 of its base frame, as far as can be told.

    Its first axis that turns is vertical, the next joint does not hang below it, and stands so
    high that its links have room over the floor; gravity, if it is known, points down.
    """
    first, down = first_turning(robot), np.asarray(gravity, dtype=float)
    if first == len(robot.joints) or -down[2] < _UPRIGHT * float(np.linalg.norm(down)):
        return False
    posture = Posture(robot, np.zeros((1, len(robot.joints))))
    body = int(robot.place[first]) + 1
    foot, shoulder = posture.origins[2, first, 0], posture.bodies[body][3, :, 0]
    shoulder = shoulder + robot.links[body][:3, 3] @ posture.bodies[body][:3, :, 0]
    vertical = abs(posture.axes[2, first, 0]) >= _UPRIGHT
    high = max(foot, LINK_SHARE * reach_of(robot) + CollisionRules.margin)
    return bool(vertical and shoulder[2] >= high - 1e-3)


def clearances(
    robot: Robot, tool: Tool, limits: Array, obstacles: Sequence[Shape], rules: CollisionRules
) -> tuple[Clearance, ...]:
    """Constraints that keep a robot with its tool clear of obstacles, the floor and itself.

    Args:
        robot: The robot; without collision shapes it gets capsules along its chain.
        tool: What it carries.
        limits: (2, n) joint limits [rad or m]; pairs that touch everywhere in them are left out.
        obstacles: Shapes on body 0, in the base frame, each with a name of its own.
        rules: What counts as a collision.

    Raises:
        InputError: a mesh cannot be used, a name is not known, or a package is missing.
    """
    links, made_do = _links(robot, rules)
    solids = [*links, *tool_solids(robot, tool)]
    things = [_solids_of(shape) for shape in obstacles]
    _check_names(robot, rules, solids, [shape.name for shape in obstacles])
    watched = [*solids, *(s for part in things for s in part)]
    if (rules.itself or things) and not all(solid.exact for solid in watched):
        coal()  # say now that it is missing, not in the midst of planning
    keep = partial(
        Clearance, margin=rules.margin, motion_margin=rules.motion_margin, made_do=made_do
    )
    outer = [solid for solid in solids if not solid.covered]
    against = partial(obstacle_pairs, robot, limits, outer, ignore=rules.ignore)
    found = []
    for shape, parts in zip(obstacles, things, strict=True):
        pairs, left = against(parts)
        found.append(keep(shape.name, pairs, obstacle=shape, unwatched=left))
    if rules.floor is not None:
        pairs, left = against([plane(FLOOR, rules.floor)], margin=rules.margin)
        found.append(keep(FLOOR, pairs, height=rules.floor, unwatched=left))
    if rules.itself:
        pairs, left = self_pairs(robot, limits, solids, rules.ignore, rules.margin)
        found.append(keep(ITSELF, pairs, unwatched=left))
    return tuple(found)


def _links(robot: Robot, rules: CollisionRules) -> tuple[list[Solid], tuple[Doubt, ...]]:
    """The solids of the robot, and what stands in for its shapes."""
    if robot.collisions and not rules.at_hand:
        return robot_solids(robot, as_capsules=rules.as_capsules), ()
    shaped, along, lost, odd = solids_at_hand(robot, rules.link_radius)
    made_do = [*odd, Doubt("shapes-as-capsules")] if shaped else [*odd]
    if lost or not robot.collisions:
        radii = [solid.radius for solid in along]
        thick = {"least": min(radii, default=0.0), "most": max(radii, default=0.0)}
        made_do.append(Doubt("chain-as-capsules", lost, numbers=thick, unit="m"))
    return [*shaped, *along], tuple(made_do)


def _solids_of(obstacle: Shape) -> list[Solid]:
    """The solids of an obstacle; an error says of which."""
    try:
        return solids_of(obstacle, obstacle.name)
    except InputError as error:
        raise error.with_doubts(Doubt("unusable-shape", (obstacle.name,))) from None


def _check_names(
    robot: Robot, rules: CollisionRules, solids: list[Solid], obstacles: list[str]
) -> None:
    """Refuse names that mean nothing, and obstacles that share a name."""
    taken = [] if rules.floor is None else [FLOOR]
    own = list(dict.fromkeys([*robot.joint_names, "base", *(s.name for s in solids)]))
    for i, name in enumerate(obstacles):
        if name in [*taken, *obstacles[:i]]:
            doubt = Doubt("name-twice", (name,))
            raise InputError(worded(doubt)).with_doubts(doubt)
        if name in own:
            doubt = Doubt("name-of-a-part", (name,))
            raise InputError(worded(doubt)).with_doubts(doubt)
    known = [*own, *taken, *obstacles]
    for pair in rules.ignore:
        for name in pair:
            if name not in known:
                doubt = Doubt("unknown-name", (name,), tuple(known))
                raise InputError(worded(doubt)).with_doubts(doubt)
