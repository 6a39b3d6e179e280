"""Glyphs of joints: the axis, and an arrow the way the joint value grows.

In: a joint's axis in the base frame. Out: lines to draw [m]. A turning joint gets an arc about its
axis by the right-hand rule, a sliding one an arrow along it. Joints that share a point get their
glyphs side by side along their axes; the arrow of a slide is drawn beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray
from elastocal.drawing.projection import Projection
from elastocal.robot.rotations import frame_about

_SWEEP = np.radians(290.0)
_STEPS = (0.0, 1.0, -1.0, 1.8, -1.8, 2.6, -2.6, 3.4, -3.4)
_LEAST = 1.5  # arcs nearer than this many radii are hard to tell apart


@dataclass(frozen=True)
class Glyph:
    """How one joint is drawn, in the base frame [m].

    Attributes:
        name: Name of the joint.
        axis: (2, 3) ends of the line along its axis.
        arrow: (K, 3) line that ends in an arrow head.
        centre: (3,) middle of the arrow.
    """

    name: str
    axis: Array
    arrow: Array
    centre: Array


def glyphs(
    names: Sequence[str],
    centres: Array,
    axes: Array,
    slides: BoolArray,
    radius: float,
    view: Projection,
) -> list[Glyph]:
    """Glyphs of n joints at `centres` (n, 3) with `axes` (n, 3), arcs of `radius` [m]."""
    found: list[Glyph] = []
    taken = np.zeros((0, 2))
    for name, centre, axis, sliding in zip(names, centres, axes, slides, strict=True):
        places = np.array([centre + step * radius * axis for step in _STEPS])
        seen = view(places)
        room = np.full(len(places), np.inf)
        if len(taken):
            room = np.linalg.norm(seen[:, None] - taken, axis=2).min(axis=1)
        enough = _LEAST * radius * view.scale
        k = int(np.argmax(np.minimum(room, enough)))
        place = places[k]
        taken = np.vstack([taken, seen[k]])
        far = 1.3 * radius
        if sliding:
            side = np.cross(axis, view.toward)
            place = place + 0.6 * radius * side / max(float(np.linalg.norm(side)), 1e-9)
            arrow = np.linspace(place - far * axis, place + 1.6 * far * axis, 20)
            line = arrow[[0, -1]]
        else:
            arrow = _arc(place, axis, radius, view)
            line = np.array([place - far * axis, place + far * axis])
        found.append(Glyph(name, line, arrow, place))
    return found


def _arc(centre: Array, axis: Array, radius: float, view: Projection) -> Array:
    """(K, 3) arc about the axis that ends where one sees its direction best, in front."""
    u, v, _ = frame_about(axis).T
    angles = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    along = -np.outer(np.sin(angles), u) + np.outer(np.cos(angles), v)
    out = np.outer(np.cos(angles), u) + np.outer(np.sin(angles), v)
    speed = np.linalg.norm(view(along) - view(np.zeros((1, 3))), axis=1) / view.scale
    best = angles[int(np.argmax(speed + 0.3 * view.nearness(out)))]
    run = np.linspace(best - _SWEEP, best, 40)
    return np.asarray(centre + radius * (np.outer(np.cos(run), u) + np.outer(np.sin(run), v)))
