"""The cell around a robot: what must not touch what, as constraints.

In: robot, tool, joint limits, obstacles, rules. Out: one `Clearance` for every obstacle, and one
for the robot itself. Each knows which pairs it does not watch, and why.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from elastocal.arrays import Array
from elastocal.constraints import Clearance
from elastocal.constraints.collision.chain import robot_solids, tool_solids
from elastocal.constraints.collision.coal_distance import coal
from elastocal.constraints.collision.contacts import obstacle_pairs, self_pairs
from elastocal.constraints.collision.solid import Solid, solids_of
from elastocal.errors import Doubt, InputError
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.shapes import Shape
from elastocal.wording import worded

ITSELF = "itself"
"""What the robot is called as an obstacle to its own motion."""

_GAP = 0.1  # room [m] between the margin around the wrist and where the tool is watched


@dataclass(frozen=True)
class CollisionRules:
    """What counts as a collision.

    Attributes:
        margin: Distance to keep at the poses of a plan [m].
        motion_margin: Distance to keep while moving between them [m]; None for half of `margin`.
        itself: Whether the robot must not touch itself.
        ignore: Pairs of names that may touch: joints, links, "base", "tool", obstacles.
        as_capsules: Whether to put capsules around the shapes of the links: larger, and faster.
        link_radius: Radius of the capsules of a robot without shapes [m]: of all, or by joint.
    """

    margin: float = 0.02
    motion_margin: float | None = None
    itself: bool = True
    ignore: tuple[tuple[str, str], ...] = ()
    as_capsules: bool = False
    link_radius: float | Mapping[str, float] | None = None


def clearances(
    robot: Robot, tool: Tool, limits: Array, obstacles: Sequence[Shape], rules: CollisionRules
) -> tuple[Clearance, ...]:
    """Constraints that keep a robot with its tool clear of obstacles and of itself.

    Args:
        robot: The robot; without collision shapes it gets capsules along its chain.
        tool: What it carries.
        limits: (2, n) joint limits [rad or m]; pairs that touch everywhere in them are left out.
        obstacles: Shapes on body 0, in the base frame, each with a name of its own.
        rules: What counts as a collision.

    Raises:
        InputError: a mesh cannot be used, a name is not known, or a package is missing.
    """
    links = robot_solids(robot, rules.link_radius, as_capsules=rules.as_capsules)
    solids = [*links, *tool_solids(robot, tool)]
    things = [_solids_of(shape) for shape in obstacles]
    _check_names(robot, rules, solids, [shape.name for shape in obstacles])
    if not all(solid.exact for solid in [*solids, *(s for part in things for s in part)]):
        coal()  # say now that it is missing, not in the midst of planning
    outer = [solid for solid in solids if not solid.covered]
    found = []
    for shape, parts in zip(obstacles, things, strict=True):
        pairs, left = obstacle_pairs(robot, limits, outer, parts, rules.ignore)
        found.append(
            Clearance(
                shape.name,
                pairs,
                rules.margin,
                motion_margin=rules.motion_margin,
                obstacle=shape,
                unwatched=left,
            )
        )
    if rules.itself:
        also = _outside_the_wrist(robot, tool, links, rules.margin)
        pairs, left = self_pairs(robot, limits, solids, rules.ignore, also, rules.margin)
        found.append(
            Clearance(
                ITSELF, pairs, rules.margin, motion_margin=rules.motion_margin, unwatched=left
            )
        )
    return tuple(found)


def _solids_of(obstacle: Shape) -> list[Solid]:
    """The solids of an obstacle; an error says of which."""
    try:
        return solids_of(obstacle, obstacle.name)
    except InputError as error:
        raise error.with_doubts(Doubt("unusable-shape", (obstacle.name,))) from None


def _outside_the_wrist(
    robot: Robot, tool: Tool, links: list[Solid], margin: float
) -> list[tuple[Solid, Solid]]:
    """The outer part of a tool that begins inside the round end of the forearm, with the forearm.

    As a whole the two always touch; what can be told is whether the tool folds back.
    """
    forearm = [solid for solid in links if not solid.covered][-1]
    if robot.collisions or forearm.body == len(robot.joints):
        return []
    beyond = forearm.radius + tool.radius + margin + _GAP
    return [(solid, forearm) for solid in tool_solids(robot, tool, beyond=beyond)]


def _check_names(
    robot: Robot, rules: CollisionRules, solids: list[Solid], obstacles: list[str]
) -> None:
    """Refuse names that mean nothing, and obstacles that share a name."""
    own = list(dict.fromkeys([*robot.joint_names, "base", *(s.name for s in solids)]))
    for i, name in enumerate(obstacles):
        if name in obstacles[:i]:
            doubt = Doubt("name-twice", (name,))
            raise InputError(worded(doubt)).with_doubts(doubt)
        if name in own:
            doubt = Doubt("name-of-a-part", (name,))
            raise InputError(worded(doubt)).with_doubts(doubt)
    known = [*own, *obstacles]
    for pair in rules.ignore:
        for name in pair:
            if name not in known:
                doubt = Doubt("unknown-name", (name,), tuple(known))
                raise InputError(worded(doubt)).with_doubts(doubt)
