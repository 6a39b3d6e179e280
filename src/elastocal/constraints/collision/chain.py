"""The solids of a robot: its collision shapes, or capsules along its chain, and its tool.

In: robot, tool, radii. Out: solids by body. A robot that was given without shapes is a chain of
capsules between its joints; that is coarse, and its thickness is a guess until somebody says it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.collision.mesh import MeshSizeError
from elastocal.constraints.collision.solid import Solid, around, capsule, enclosed, solids_of
from elastocal.errors import Doubt, InputError
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.reach import reach_of
from elastocal.robot.shapes import Shape
from elastocal.wording import worded

LINK_SHARE = 0.05
"""Radius of a link over the reach of the robot, if nothing is said."""

_LARGE = 10.0  # reaches of the robot that no link of it measures ...
_SMALLEST = 1.0  # ... of a robot that reaches so far at least [m]; a turntable reaches nowhere

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
        InputError: a mesh cannot be used, or a shape has a size that no link has.
    """
    if not robot.collisions:
        return _along_chain(robot, radius)
    found, reach = [], reach_of(robot)
    for shape in robot.collisions:
        solids = _solids(robot, shape, reach)
        found += [around(solid) if as_capsules and shape.body else solid for solid in solids]
    return found


def solids_at_hand(
    robot: Robot, radius: Radii = None
) -> tuple[list[Solid], list[Solid], tuple[str, ...], tuple[Doubt, ...]]:
    """Capsules, at the base boxes, with faces near the robot's shapes; else along the chain.

    Nothing is refused and no package is needed: what cannot be read is left to the chain, and so
    is a link that has no shape at all between its joints, for it is there all the same.

    Args:
        robot: The robot.
        radius: How thick links without shapes are.

    Returns:
        Solids of shapes, solids along the chain, the names of links whose shapes could not be
        had: of those without any the joint that moves them; and which have a size no link has.
    """
    found: list[Solid] = []
    lost: dict[str, int] = {}
    odd: list[Doubt] = []
    reach = reach_of(robot)
    for shape in robot.collisions:
        try:
            found += map(enclosed, _solids(robot, shape, reach))
        except InputError as error:
            lost[_shape_name(robot, shape)] = shape.body
            odd += [doubt for doubt in error.doubts if doubt.code == "odd-size"]
    chain = _along_chain(robot, radius)
    if robot.collisions:  # what a capsule covers in the chain is not there to cover it
        shaped = {shape.body for shape in robot.collisions}
        bare = [solid for solid in chain if solid.body not in shaped and not solid.covered]
        lost |= {solid.name: solid.body for solid in bare if not _is_ball(robot, solid.body)}
        chain = [replace(solid, covered=False) for solid in chain if solid.body in lost.values()]
    return found, chain, tuple(lost), _together(odd)


def _together(odd: list[Doubt]) -> tuple[Doubt, ...]:
    """Shapes of odd sizes, those too large in one and those too small in another."""
    found = []
    for large in (True, False):
        some = [d for d in odd if (d.numbers["size"] > d.numbers["reach"]) == large]
        if some:
            extreme = (max if large else min)(some, key=lambda d: d.numbers["size"])
            names = dict.fromkeys(name for d in some for name in d.about)
            found.append(replace(extreme, about=tuple(names)))
    return tuple(found)


def _solids(robot: Robot, shape: Shape, reach: float) -> list[Solid]:
    """The solids of a shape of the robot, called by link and joint.

    Raises:
        InputError: a mesh cannot be used, or the shape has a size that no link has.
    """
    name, joint = _shape_name(robot, shape), body_name(robot, shape.body)
    solids: list[Solid] = []
    odd = 0.0
    try:
        solids = solids_of(shape, name)
    except MeshSizeError as error:
        odd = error.size
    most = _LARGE * max(reach, _SMALLEST)
    for sides in map(_sides, solids):
        # A base may have a wide floor or a long wall to it, a link that moves has nothing like it.
        if (sides.max() if shape.body else sides.min()) > most:
            odd = max(odd, float(sides.max()))
    if odd:
        doubt = Doubt("odd-size", (name,), numbers={"size": odd, "reach": reach}, unit="m")
        raise InputError(worded(doubt)).with_doubts(doubt)
    return [replace(solid, joint=joint) for solid in solids]


def _sides(solid: Solid) -> Array:
    """Sides of a box along the axes of a solid that holds it [m]."""
    if solid.kind == "hull":
        return np.asarray(np.ptp(solid.vertices, axis=0))
    if solid.kind == "box":
        return solid.size
    radius, length = (*solid.size, 0.0)[:2]
    caps = 0.0 if solid.kind == "cylinder" else 2.0 * radius
    return np.array([2.0 * radius, length + caps])


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
