"""Surfaces: constraints as something one can see in the scene.

In: constraint, stage. Out: translucent solids and outlines. A constraint on joint values alone,
or of a kind unknown here, has no surface and returns None.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints import Clearance, Constraint, Elevation, HalfSpace, MinRadius, Tilt
from elastocal.drawing.obstacles import OPACITY, solid_of, top_of
from elastocal.drawing.solids import Mesh, circle
from elastocal.drawing.stage import Stage
from elastocal.robot.posture import Posture

WALLS = (HalfSpace, MinRadius, Clearance)
APERTURES = (Elevation, Tilt)


@dataclass(frozen=True)
class Surface:
    """A drawn limit.

    Attributes:
        name: Name of the constraint.
        solid: What is translucent [m].
        outlines: Polylines (., 3) [m].
        label: (3,) where the name is written [m].
        opacity: How much of what is behind it is hidden.
        about: Name of the point it limits; empty if it limits none.
        phrase: Its name with a gap for that of the point.
    """

    name: str
    solid: Mesh
    outlines: tuple[Array, ...]
    label: Array
    opacity: float = 0.13
    about: str = ""
    phrase: str = ""


def wall(constraint: Constraint, stage: Stage) -> Surface | None:
    """A limit that stands in the room, the same for every configuration."""
    if isinstance(constraint, HalfSpace):
        plane = _plane(constraint.name, constraint.normal, constraint.offset, stage)
        return None if plane is None else _about(constraint, plane)
    if isinstance(constraint, MinRadius):
        return _about(constraint, _cylinder(constraint, stage))
    if isinstance(constraint, Clearance) and constraint.height is not None:
        ground = _plane(constraint.what, np.array([0.0, 0.0, 1.0]), constraint.height, stage)
        return None if ground is None else replace(ground, label=_in_front(ground.outlines[0]))
    if isinstance(constraint, Clearance) and constraint.obstacle is not None:
        solid, outlines = solid_of(constraint.obstacle)
        return Surface(constraint.what, solid, outlines, top_of(solid), OPACITY)
    return None


def _in_front(rim: Array) -> Array:
    """(3,) corner of a rim (., 3) that is nearest to who looks at the stage as it opens."""
    return np.asarray(rim[int(np.argmax(rim[:, 0] - rim[:, 1]))])


def _about(constraint: HalfSpace | MinRadius, surface: Surface) -> Surface:
    """The surface, with what it says of which point."""
    return replace(surface, about=constraint.about, phrase=constraint.phrase)


def aperture(constraint: Constraint, posture: Posture, at: Array, size: float) -> Surface | None:
    """A limit on how the tool is held, at the tool.

    Args:
        constraint: The limit.
        posture: The one configuration.
        at: (3,) where to draw it [m].
        size: How large to draw it [m].
    """
    if isinstance(constraint, Elevation):
        axis = posture.direction(constraint.axis)[:, 0]
        level = np.array([axis[0], axis[1], 0.0])
        norm = float(np.linalg.norm(level))
        level = level / norm if norm > 1e-6 else np.array([1.0, 0.0, 0.0])
        angles = np.linspace(-constraint.limit, constraint.limit, 25)
        up = np.array([0.0, 0.0, 1.0])
        return _fan(constraint.name, at, size, _turned(level, up, angles), axis, closed=False)
    if isinstance(constraint, Tilt):
        axis = posture.direction(constraint.axis)[:, 0]
        rim = circle(constraint.towards, 36)
        rays = np.cos(constraint.limit) * constraint.towards + np.sin(constraint.limit) * rim
        return _fan(constraint.name, at, size, rays, axis, closed=True)
    return None


def _turned(level: Array, up: Array, angles: Array) -> Array:
    """(., 3) unit vectors at `angles` from `level` towards `up`."""
    return np.asarray(np.outer(np.cos(angles), level) + np.outer(np.sin(angles), up))


def _fan(name: str, at: Array, size: float, rays: Array, axis: Array, *, closed: bool) -> Surface:
    """Fan of `rays` (., 3) from a point, and the axis it limits."""
    rim = at + size * rays
    i = np.arange(1, len(rim))
    triangles = np.column_stack([np.zeros_like(i), i, i + 1])
    outline = np.vstack([at, rim, at])
    if closed:
        triangles = np.vstack([triangles, [0, len(rim), 1]])
        outline = np.vstack([rim, rim[:1]])
    tip = at + 1.25 * size * axis
    solid = Mesh(np.vstack([at, rim]), triangles)
    return Surface(name, solid, (outline, np.vstack([at, tip])), tip)


def _plane(name: str, normal: Array, offset: float, stage: Stage) -> Surface | None:
    """The plane at `offset` [m] along `normal`, where it cuts the box of the stage."""
    low, high = _inside(stage)
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, 8).T
    height = corners @ normal - offset
    cuts = []
    for a in range(8):
        for b in range(a):
            along_edge = (np.abs(corners[a] - corners[b]) > 0.0).sum() == 1
            if along_edge and height[a] * height[b] < 0.0:
                share = height[a] / (height[a] - height[b])
                cuts.append(corners[a] + share * (corners[b] - corners[a]))
    if len(cuts) < 3:
        return None
    centre = np.mean(cuts, axis=0)
    side, other = circle(normal, 4)[:2]
    around = np.argsort([np.arctan2((c - centre) @ other, (c - centre) @ side) for c in cuts])
    rim = np.array(cuts)[around]
    back = int(np.argmax(rim[:, 0] + rim[:, 1] + rim[:, 2]))
    i = np.arange(1, len(rim) - 1)
    solid = Mesh(rim, np.column_stack([np.zeros_like(i), i, i + 1]))
    return Surface(name, solid, (np.vstack([rim, rim[:1]]),), rim[back])


def _inside(stage: Stage) -> tuple[Array, Array]:
    """Corners just inside the box of the stage: what lies on its faces is cut off."""
    inset = 0.02 * stage.size
    return stage.lower + inset, stage.upper - inset


def _cylinder(constraint: MinRadius, stage: Stage) -> Surface:
    """The cylinder about the base, as high as the box of the stage."""
    sides = 48
    up = np.array([0.0, 0.0, 1.0])
    rim = constraint.radius * circle(up, sides)
    bottom, top = (float(corner[2]) for corner in _inside(stage))
    low, high = rim + bottom * up, rim + top * up
    i = np.arange(sides)
    j = (i + 1) % sides
    halves = [i, j, j + sides], [i, j + sides, i + sides]
    triangles = np.vstack([np.column_stack(half) for half in halves])
    outlines = tuple(np.vstack([ring, ring[:1]]) for ring in (low, high))
    right = high[int(np.argmax(high[:, 0] + high[:, 1]))]
    return Surface(constraint.name, Mesh(np.vstack([low, high]), triangles), outlines, right)
