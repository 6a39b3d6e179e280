"""Parts: what a robot is drawn with, as triangles that stay on their bodies.

In: robot, tools. Out: parts. From its own shapes if it has any that can be drawn, meshes or simple
ones; else as tubes and drums along its chain.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from elastocal.arrays import Array
from elastocal.drawing.palette import COLOURS
from elastocal.drawing.shape_solids import round_ball, solid_of
from elastocal.drawing.solids import Mesh, tube, union
from elastocal.errors import InputError
from elastocal.robot.chain import Joint, Robot, Tool
from elastocal.robot.reach import reach_of
from elastocal.robot.rotations import frame_about
from elastocal.robot.shapes import Shape

Colour = tuple[int, int, int]


@dataclass(frozen=True)
class Part:
    """Triangles that move with a body.

    Attributes:
        name: What it is: of the link, the joint or the point.
        body: Number of the body, see `Robot`; the number after the last is the flange.
        solid: Its triangles in the frame of that body [m].
        colour: Red, green, blue, each from 0 to 255.
    """

    name: str
    body: int
    solid: Mesh
    colour: Colour


def colour(name: str) -> Colour:
    """A colour of the report, as red, green, blue from 0 to 255."""
    code = COLOURS[name]
    return int(code[1:3], 16), int(code[3:5], 16), int(code[5:7], 16)


def robot_parts(robot: Robot) -> tuple[tuple[Part, ...], tuple[str, ...]]:
    """Parts of a robot, and sentences on what cannot be drawn as its file has it.

    A body whose visual shapes cannot be drawn is drawn with its collision shapes, and without
    those along the chain.
    """
    visual, lost = _drawn(robot.visuals)
    collision, _ = _drawn([s for s in robot.collisions if s.body not in visual])
    found: list[Part] = []
    bare: list[int] = []
    bodies = {shape.body for shape in (*robot.visuals, *robot.collisions)}
    for body in range(robot.bodies):
        own = visual.get(body) or collision.get(body)
        if own:
            found += own
        elif body in bodies or not bodies:
            bare.append(body)
    found += [part for part in chain_parts(robot) if part.body in bare]
    return tuple(found), _remarks(robot, lost, bare)


def _remarks(robot: Robot, lost: Sequence[Shape], bare: Sequence[int]) -> tuple[str, ...]:
    """What is not drawn as the file has it, in one sentence."""
    if not lost:
        return ()
    first = lost[0]
    file = (first.source or first.name).rpartition("/")[2]
    instead = "lines of the chain" if bare else "collision shapes"
    why = "not found" if first.mesh is None else "cannot be read"
    return (f"{len(lost)} of {len(robot.visuals)} shapes {why}, such as {file}; shown: {instead}",)


def _drawn(shapes: Iterable[Shape]) -> tuple[dict[int, list[Part]], list[Shape]]:
    """Parts of shapes by body, and the shapes that cannot be drawn."""
    found: dict[int, list[Part]] = {}
    lost: list[Shape] = []
    for shape in shapes:
        try:
            solid = solid_of(shape)
        except InputError:
            lost.append(shape)
            continue
        red, green, blue = (round(255 * c) for c in shape.color[:3]) if shape.color else _PLAIN
        found.setdefault(shape.body, []).append(
            Part(shape.name, shape.body, solid, (red, green, blue))
        )
    return found, lost


_PLAIN: Colour = (196, 204, 214)


def chain_parts(robot: Robot) -> tuple[Part, ...]:
    """A robot without shapes: tubes from joint to joint, a drum about every axis.

    A link leaves its joint along the joint axis and turns off square where the next joint
    stands, as in the pictures of the report. A sliding joint gets the rail it slides on.
    """
    size = reach_of(robot)
    n = robot.last
    taper = np.linspace(1.0, 0.6, n + 1)
    found = []
    for body in range(n + 1):
        thick = 0.026 * size * float(taper[body])
        end = np.array(robot.links[body][:3, 3])
        link = _tubes(_square(end), thick)
        name = robot.moving[body - 1].name if body else "base"
        if body:
            drum = _drum(robot.moving[body - 1], robot.links[body - 1], 1.45 * thick)
            drum_body = body - 1 if robot.moving[body - 1].prismatic else body
            found.append(Part(f"joint {name}", drum_body, drum, colour("muted")))
        if len(link.triangles):
            found.append(Part(f"link {name}", body, link, _PLAIN))
    thick = 0.026 * size * float(taper[-1])
    disc = tube(np.array([0, 0, -0.2 * thick]), np.array([0, 0, 0.2 * thick]), 1.2 * thick)
    flange = robot.links[-1][:3, :3].T @ np.array([0.0, 0.0, 1.0])
    turned = _turned(disc, flange)
    return (*found, Part("flange", robot.bodies, turned, colour("muted")))


def _square(end: Array) -> list[Array]:
    """Way from the origin along z, then square to it, to `end`."""
    return _distinct([np.zeros(3), np.array([0.0, 0.0, end[2]]), end])


def _distinct(points: Sequence[Array]) -> list[Array]:
    """Points without those that repeat the one before."""
    kept = [points[0]]
    for point in points[1:]:
        if np.linalg.norm(point - kept[-1]) > 1e-6:
            kept.append(point)
    return kept


def _tubes(points: Sequence[Array], radius: float) -> Mesh:
    """Round tubes through points, with round corners."""
    if len(points) < 2:
        return union([])
    pipes = [tube(a, b, radius, sides=24) for a, b in pairwise(points)]
    return union([*pipes, *(round_ball(point, radius) for point in points)])


def _drum(joint: Joint, link: Array, radius: float) -> Mesh:
    """A drum about a turning joint, in its body; the rail of a sliding one, in the body before."""
    if not joint.prismatic:
        half = np.array([0.0, 0.0, 1.15 * radius])
        return tube(-half, half, radius, sides=32)
    ends = [joint.lower if np.isfinite(joint.lower) else -1.0]
    ends.append(joint.upper if np.isfinite(joint.upper) else 1.0)
    rail = [link[:3, 3] + value * link[:3, 2] for value in ends]
    return tube(rail[0], rail[1], 0.45 * radius, sides=4)


def _turned(solid: Mesh, axis: Array) -> Mesh:
    """A solid about z, turned to be about `axis`."""
    return Mesh(solid.vertices @ frame_about(axis).T, solid.triangles)


def tool_parts(robot: Robot, tool: Tool) -> tuple[Part, ...]:
    """A tool on the flange: arms to its points; load point, TCP and markers as balls."""
    body, size = robot.bodies, reach_of(robot)
    axis = robot.links[-1][:3, :3].T @ np.array([0.0, 0.0, 1.0])
    thick = 0.008 * size
    arms, balls = [], []
    points = {"TCP": tool.tcp, "load point": tool.load_point}
    points |= dict(zip(tool.marker_names, tool.markers, strict=True))
    for name, point in points.items():
        corner = axis * float(axis @ point)
        arms.append(_tubes(_distinct([np.zeros(3), corner, point]), thick))
        shade = "contrast" if name in tool.marker_names else "ink"
        balls.append(Part(name, body, round_ball(point, 1.9 * thick), colour(shade)))
    return (Part(f"tool {tool.name}", body, union(arms), colour("faint")), *balls)
