"""The solids of a robot: its collision shapes, or capsules along its chain, and its tool.

In: robot, tool, radii. Out: solids by body. A robot that was given without shapes is a chain of
capsules between its joints; that is coarse, and its thickness is a guess until somebody says it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.collision.solid import Solid, around, capsule, solids_of
from elastocal.errors import InputError
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.reach import reach_of
from elastocal.robot.shapes import Shape

LINK_SHARE = 0.05
"""Radius of a link over the reach of the robot, if nothing is said."""

Radii = float | Mapping[str, float] | None
"""Radius of the capsules along a chain [m]: of all, or by the joint that moves them ("base" for the
base); where it is not said, `LINK_SHARE` of the reach."""


def robot_solids(robot: Robot, radius: Radii = None, *, as_capsules: bool = False) -> list[Solid]:
    """The robot's collision shapes as convex solids, or capsules along its chain.

    Args:
        robot: The robot.
        radius: How thick a robot without shapes is.
        as_capsules: Put a capsule around every shape of a link instead: larger, and faster.

    Raises:
        InputError: a mesh cannot be used.
    """
    if not robot.collisions:
        return _along_chain(robot, radius)
    return [
        around(solid) if as_capsules and shape.body else solid
        for shape in robot.collisions
        for solid in _solids(robot, shape)
    ]


def solids_at_hand(
    robot: Robot, radius: Radii = None
) -> tuple[list[Solid], list[Solid], tuple[str, ...]]:
    """Capsules, at the base boxes, around the robot's shapes; along the chain where there are none.

    Nothing is refused and no package is needed: what cannot be read is left to the chain, and so
    is a link that has no shape at all between its joints, for it is there all the same.

    Args:
        robot: The robot.
        radius: How thick links without shapes are.

    Returns:
        Solids of shapes, solids along the chain, and the names of links whose shapes could not be
        had: of those without any the joint that moves them.
    """
    found: list[Solid] = []
    lost: dict[str, int] = {}
    for shape in robot.collisions:
        try:
            found += map(around, _solids(robot, shape))
        except InputError:
            lost[_shape_name(robot, shape)] = shape.body
    chain = _along_chain(robot, radius)
    if robot.collisions:  # what a capsule covers in the chain is not there to cover it
        shaped = {shape.body for shape in robot.collisions}
        bare = [solid for solid in chain if solid.body not in shaped and not solid.covered]
        lost |= {solid.name: solid.body for solid in bare if not _is_ball(robot, solid.body)}
        chain = [replace(solid, covered=False) for solid in chain if solid.body in lost.values()]
    return found, chain, tuple(lost)


def _solids(robot: Robot, shape: Shape) -> list[Solid]:
    """The solids of a shape of the robot, called by link and joint."""
    joint = body_name(robot, shape.body)
    return [replace(solid, joint=joint) for solid in solids_of(shape, _shape_name(robot, shape))]


def _shape_name(robot: Robot, shape: Shape) -> str:
    return shape.name or body_name(robot, shape.body)


def _along_chain(robot: Robot, radius: Radii) -> list[Solid]:
    """Capsules from joint to joint."""
    by_name = radius if isinstance(radius, Mapping) else {}
    usual = radius if isinstance(radius, float) else LINK_SHARE * reach_of(robot)
    found: list[Solid] = []
    for body in range(robot.last + 1):
        name = body_name(robot, body)
        start, end = _axis_of_link(robot, body)
        ball = _is_ball(robot, body)
        thick = by_name.get(name, usual)
        # A joint at the place of the one before: a ball that the end of that link covers. It is
        # kept for what may touch that link but not the ball, as the upper arm and the wrist.
        covered = bool(found) and ball and thick <= found[-1].radius
        if covered and found[-1].covered:
            continue
        solid = capsule(name, body, start, end, thick)
        found.append(replace(solid, joint=name, covered=covered))
    return found


def tool_solids(robot: Robot, tool: Tool) -> list[Solid]:
    """Capsules from the flange to the load point and to every marker of a tool.

    Args:
        robot: The robot that carries it.
        tool: The tool; `tool.radius` is theirs.
    """
    body, flange = robot.last, robot.links[-1]
    points = np.unique(np.vstack([tool.load_point, tool.markers]), axis=0)
    start = flange[:3, 3]
    return [
        capsule("tool", body, start, flange[:3, :3] @ point + start, tool.radius)
        for point in points
        if np.linalg.norm(point) > 0.0
    ]


def body_name(robot: Robot, body: int) -> str:
    """What a body is called: by the joint that moves it."""
    return robot.moving[body - 1].name if body else "base"


def _is_ball(robot: Robot, body: int) -> bool:
    """Whether a body has no length: its joint and the next one are at one place."""
    start, end = _axis_of_link(robot, body)
    return bool(np.linalg.norm(end - start) < 1e-6)


def _axis_of_link(robot: Robot, body: int) -> tuple[Array, Array]:
    """From the joint that moves a body to the next one, in the frame of the body [m].

    A joint that slides after one that turns pushes a ram out of the arm: the ram is as long as
    the joint travels. Before any joint turns it is a rail, and the rail is not modelled.
    """
    end = np.array(robot.links[body][:3, 3])
    start = np.zeros(3)
    joint = robot.moving[body - 1]
    if body and joint.prismatic and not robot.sliding[:body].all():
        travel = joint.upper if abs(joint.upper) >= abs(joint.lower) else joint.lower
        if np.isfinite(travel):
            start = np.array([0.0, 0.0, -travel])
    return start, end
