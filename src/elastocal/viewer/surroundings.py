"""Surroundings: what stands around the robot: obstacles, limits, the tracker and its beams.

In: subject, configuration. Out: solids, lines and labels in the base frame [m].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import AcceptanceCone, Clearance
from elastocal.drawing.shape_solids import capsule, solid_of
from elastocal.drawing.skeleton import skeletons
from elastocal.drawing.solids import Mesh, circle, tube, union
from elastocal.drawing.stage import Stage
from elastocal.drawing.surfaces import Surface, aperture, wall
from elastocal.drawing.traces import trace
from elastocal.errors import InputError
from elastocal.measuring.instrument import tracker_of
from elastocal.robot.chain import Tool
from elastocal.robot.posture import Posture
from elastocal.robot.reach import reach_of
from elastocal.robot.shapes import Shape
from elastocal.viewer.frames import rigid_frames
from elastocal.viewer.parts import Part
from elastocal.viewer.readout import Room
from elastocal.viewer.subject import Stop, Subject


@dataclass(frozen=True)
class Beam:
    """The beam of a laser tracker to one marker.

    Attributes:
        marker: Name of the marker.
        ends: (2, 3) head of the tracker and marker [m].
        seen: Whether every constraint on the beam holds.
    """

    marker: str
    ends: Array
    seen: bool


@dataclass(frozen=True)
class Cone:
    """Whence a reflector sends the beam back.

    Attributes:
        solid: The cone about its viewing axis [m].
        met: Whether the beam of the tracker comes from within.
    """

    solid: Mesh
    met: bool


def reach(subject: Subject, parts: Sequence[Part] = ()) -> tuple[Array, Array, float]:
    """Two corners of the box that holds all stops and obstacles [m]; size of the robot [m].

    `parts` of the robot are held where they are at the first stop.
    """
    robot = subject.study.robot
    frames = rigid_frames(robot, subject.stops[0].q)
    points = [np.zeros((1, 3))]
    for part in parts:
        frame = frames[part.body]
        points.append(part.solid.vertices @ frame[:3, :3].T + frame[:3, 3])
    size = reach_of(robot)
    for tool in subject.tools:
        q = np.array([stop.q for stop in subject.stops if stop.tool is tool])
        points += [skeleton.points for skeleton in skeletons(robot, tool, q)]
    for shape in obstacles(subject):
        points.append(_vertices(shape))
    points += [np.array([[0.0, 0.0, height]]) for height in floors(subject)]
    points += traces(subject)
    box = np.vstack(points)
    return box.min(axis=0) - 0.05 * size, box.max(axis=0) + 0.05 * size, size


def traces(subject: Subject) -> list[Array]:
    """Lines (K, 3) that the tool follows along the test paths [m]."""
    lines = [trace(subject.study.robot, pose) for pose in subject.study.test_poses]
    return [line for line in lines if len(line) > 1]


def obstacles(subject: Subject) -> tuple[Shape, ...]:
    """The obstacles of the cell."""
    found = [c.obstacle for c in subject.study.constraints if isinstance(c, Clearance)]
    return tuple(shape for shape in found if shape is not None)


def floors(subject: Subject) -> list[float]:
    """Height of the floor that is watched [m]; empty if none is."""
    found = [c.height for c in subject.study.constraints if isinstance(c, Clearance)]
    return [height for height in found if height is not None]


def _vertices(shape: Shape) -> Array:
    """(., 3) points of an obstacle [m]; only its place if its mesh cannot be drawn."""
    try:
        return solid_of(shape).vertices
    except InputError:
        return shape.pose[None, :3, 3]


def walls(subject: Subject) -> tuple[Surface, ...]:
    """Limits that stand in the room; obstacles are drawn as what they are, see `obstacles`."""
    lower, upper, size = reach(subject)
    stage = Stage((), (), (), lower, upper, size)
    limits = [
        c for c in subject.study.constraints if not isinstance(c, Clearance) or c.height is not None
    ]
    drawn = [wall(constraint, stage) for constraint in limits]
    return _joined([surface for surface in drawn if surface is not None])


def _joined(surfaces: Sequence[Surface]) -> tuple[Surface, ...]:
    """Surfaces at the same place as one with both names, as those of two markers are."""
    kept: list[Surface] = []
    for surface in surfaces:
        for i, other in enumerate(kept):
            one, two = surface.solid.vertices, other.solid.vertices
            if one.shape == two.shape and np.allclose(one, two):
                kept[i] = _together(other, surface)
                break
        else:
            kept.append(surface)
    return tuple(kept)


def _together(one: Surface, other: Surface) -> Surface:
    """One surface with both names: what they share is said once."""
    if not one.about or one.phrase != other.phrase:
        return replace(one, name=f"{one.name}, {other.name}", about="")
    both = f"{one.about}/{other.about}"
    return replace(one, name=one.phrase.format(both), about=both)


def apertures(subject: Subject, tool: Tool, q: Array) -> tuple[Surface, ...]:
    """Limits on how the tool is held, at its load point; none for another tool."""
    study = subject.study
    if tool is not study.experiments.tool:
        return ()
    posture = Posture(study.robot, q[None])
    at, size = posture.point(tool.load_point)[:, 0], 0.12 * reach_of(study.robot)
    drawn = [aperture(constraint, posture, at, size) for constraint in study.constraints]
    return tuple(surface for surface in drawn if surface is not None)


def tracker_solid(position: Array, floor: float, size: float) -> Mesh:
    """A tracker with its head at `position`, on a stand that reaches down to `floor` [m]."""
    r = 0.03 * size
    up = np.array([0.0, 0.0, 1.0])
    neck = position - 1.6 * r * up
    parts = [
        _moved(capsule(r, 0.0), position),
        tube(neck, position, 0.75 * r, sides=24),
        tube(neck - 2.2 * r * up, neck, 1.15 * r, sides=24),
    ]
    hip = neck - 2.2 * r * up
    drop = float(hip[2]) - floor
    if drop > r:
        feet = hip - drop * up + 0.35 * min(drop, 6.0 * r) * circle(up, 3)
        parts += [tube(hip, foot, 0.22 * r) for foot in feet]
    return union(parts)


def beams(subject: Subject, tool: Tool, q: Array, rooms: Sequence[Room]) -> tuple[Beam, ...]:
    """Beams from the tracker to every marker of the calibration tool; none for another tool.

    Args:
        subject: What is shown.
        tool: What the robot carries.
        q: (n,) configuration [rad or m].
        rooms: Margins there; those of a marker say whether it is seen.
    """
    study = subject.study
    tracker = tracker_of(study.instrument)
    if tracker is None or tool is not study.experiments.tool:
        return ()
    posture = Posture(study.robot, q[None])
    found = []
    for name, marker in zip(tool.marker_names, tool.markers, strict=True):
        ends = np.array([tracker.position, posture.point(marker)[:, 0]])
        seen = all(room.state != "broken" for room in rooms if room.marker == name)
        found.append(Beam(name, ends, seen))
    return tuple(found)


def cones(subject: Subject, tool: Tool, q: Array) -> tuple[Cone, ...]:
    """Acceptance cones of the reflectors on the calibration tool; none for another tool."""
    study = subject.study
    if tool is not study.experiments.tool:
        return ()
    posture = Posture(study.robot, q[None])
    size = 0.14 * reach_of(study.robot)
    found = []
    for constraint in study.constraints:
        if isinstance(constraint, AcceptanceCone):
            tip = posture.point(constraint.point)[:, 0]
            axis = posture.direction(constraint.axis)[:, 0]
            solid = _cone(tip, axis, constraint.limit, size)
            found.append(Cone(solid, float(constraint.at(posture)[0][0]) >= 0.0))
    return tuple(found)


def _cone(tip: Array, axis: Array, half_angle: float, size: float) -> Mesh:
    """Rays of length `size` [m] from `tip`, at `half_angle` [rad] around `axis`."""
    sides = 36
    rays = np.cos(half_angle) * axis + np.sin(half_angle) * circle(axis, sides)
    i = np.arange(sides)
    triangles = np.column_stack([np.zeros_like(i), 1 + i, 1 + (i + 1) % sides])
    return Mesh(np.vstack([tip, tip + size * rays]), triangles)


def ghost(subject: Subject, stop: Stop) -> Mesh:
    """A stop as a thin figure, to stand beside the robot."""
    skeleton = skeletons(subject.study.robot, stop.tool, stop.q[None])[0]
    thick = 0.006 * reach_of(subject.study.robot)
    lines = [skeleton.arm, *skeleton.tool]
    pipes = [tube(a, b, thick, sides=10) for line in lines for a, b in pairwise(line)]
    return union([*pipes, _moved(capsule(2.0 * thick, 0.0, 14), skeleton.tcp)])


def _moved(solid: Mesh, by: Array) -> Mesh:
    return Mesh(solid.vertices + by, solid.triangles)
