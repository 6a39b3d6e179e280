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
from elastocal.robot.chain import Robot, Tool

LINK_SHARE = 0.05
"""Radius of a link over the length of the chain, if nothing is said."""


def robot_solids(
    robot: Robot,
    radius: float | Mapping[str, float] | None = None,
    *,
    as_capsules: bool = False,
) -> list[Solid]:
    """The robot's collision shapes as convex solids, or capsules along its chain.

    Args:
        robot: The robot.
        radius: Radius of the capsules [m]: of all, or by the joint that moves them ("base" for
            the base); where it is not said, `LINK_SHARE` of the length of the chain.
        as_capsules: Put a capsule around every shape of a link instead: larger, and faster.

    Raises:
        InputError: a mesh cannot be used.
    """
    if robot.collisions:
        return [
            replace(
                around(solid) if as_capsules and shape.body else solid,
                joint=body_name(robot, shape.body),
            )
            for shape in robot.collisions
            for solid in solids_of(shape, shape.name or body_name(robot, shape.body))
        ]
    by_name = radius if isinstance(radius, Mapping) else {}
    usual = radius if isinstance(radius, float) else LINK_SHARE * chain_length(robot)
    found: list[Solid] = []
    for body in range(len(robot.joints) + 1):
        name = body_name(robot, body)
        start, end = _axis_of_link(robot, body)
        thick = by_name.get(name, usual)
        # A joint at the place of the one before: a ball that the end of that link covers. It is
        # kept for what may touch that link but not the ball, as the upper arm and the wrist.
        ball = bool(np.linalg.norm(end - start) < 1e-6)
        covered = bool(found) and ball and thick <= found[-1].radius
        if covered and found[-1].covered:
            continue
        solid = capsule(name, body, start, end, thick)
        found.append(replace(solid, joint=name, covered=covered))
    return found


def tool_solids(robot: Robot, tool: Tool, *, beyond: float = 0.0) -> list[Solid]:
    """Capsules from the flange to the load point and to every marker of a tool.

    Args:
        robot: The robot that carries it.
        tool: The tool; `tool.radius` is theirs.
        beyond: Distance from the flange at which they begin [m]; a shorter one is left out.
    """
    body, flange = len(robot.joints), robot.links[-1]
    points = np.unique(np.vstack([tool.load_point, tool.markers]), axis=0)
    found = []
    for point in points:
        length = float(np.linalg.norm(point))
        if length > beyond:
            start = point * (beyond / length)
            ends = [flange[:3, :3] @ end + flange[:3, 3] for end in (start, point)]
            found.append(capsule("tool", body, ends[0], ends[1], tool.radius))
    return found


def body_name(robot: Robot, body: int) -> str:
    """What a body is called: by the joint that moves it."""
    return robot.moving[body - 1].name if body else "base"


def chain_length(robot: Robot) -> float:
    """Length of the chain from joint to joint at rest [m]."""
    return float(np.linalg.norm(robot.links[:, :3, 3], axis=1).sum())


def _axis_of_link(robot: Robot, body: int) -> tuple[Array, Array]:
    """From the joint that moves a body to the next one, in the frame of the body [m].

    A joint that slides after one that turns pushes a ram out of the arm: the ram is as long as
    the joint travels. Before any joint turns it is a rail, and the rail is not modelled.
    """
    end = np.array(robot.links[body][:3, 3])
    start = np.zeros(3)
    if body and robot.joints[body - 1].prismatic and not robot.prismatic[:body].all():
        joint = robot.joints[body - 1]
        travel = joint.upper if abs(joint.upper) >= abs(joint.lower) else joint.lower
        if np.isfinite(travel):
            start = np.array([0.0, 0.0, -travel])
    return start, end
