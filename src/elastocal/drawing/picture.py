"""Static pictures of configurations: for paper, for run sheets, and where there is no WebGL.

In: figures of a stage. Out: SVG. All pictures of a plan share view and scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.projection import Projection
from elastocal.drawing.stage import DrawnCase, Stage, Vector, extent
from elastocal.drawing.svg import drawing, join, line, polyline, tag, text

_GRID = 0.5  # floor squares [m]
_LONGEST = 9  # letters of a load that fit beside its arrow


class View:
    """A parallel view from the front, the right and a little above.

    Attributes:
        width: Width of the pictures [px].
        height: Height of the pictures [px].
    """

    def __init__(self, stage: Stage, width: float = 300.0) -> None:
        """Fit the box of `stage` into `width` pixels."""
        drawn = _drawn(stage)
        bodies = [f.skeleton.points for f in (*stage.planned, *stage.tests, *stage.peak)]
        lowest = float(np.vstack(bodies)[:, 2].min())
        self.floor = lowest if lowest < -0.02 * stage.size else 0.0
        flat = drawn * [1.0, 1.0, 0.0] + [0.0, 0.0, self.floor]
        self._project = Projection(np.vstack([drawn, flat]), width)
        self.width, self.height = width, self._project.height
        self._ends = self._grid_ends(stage)

    def __call__(self, points: Array) -> Array:
        """(K, 2) pixels of points (K, 3) [m]."""
        return self._project(points)

    def pixels(self, length: float) -> float:
        """Length on the picture [px] of a ball's radius [m]."""
        return float(length * self._project.scale)

    def floor_grid(self) -> Markup:
        """The floor, in squares of half a metre."""
        return join(polyline(self(pair), "floor") for pair in self._ends)

    def shadow(self, points: Array) -> Array:
        """(K, 2) pixels of the points on the floor below `points` (K, 3)."""
        flat = points.copy()
        flat[:, 2] = self.floor
        return self(flat)

    def _grid_ends(self, stage: Stage) -> Array:
        """(G, 2, 3) ends of the lines of the floor [m]."""
        low = np.minimum(np.floor(stage.lower[:2] / _GRID), -1.0) * _GRID
        high = np.maximum(np.ceil(stage.upper[:2] / _GRID), 1.0) * _GRID
        z = self.floor
        along = [np.arange(a, b + 1e-9, _GRID) for a, b in zip(low, high, strict=True)]
        lines = [[[x, low[1], z], [x, high[1], z]] for x in along[0]]
        lines += [[[low[0], y, z], [high[0], y, z]] for y in along[1]]
        return np.array(lines)


def portrait(
    figure: DrawnCase,
    stage: Stage,
    kind: str = "plan",
    width: float = 300.0,
    lines: Sequence[Array] = (),
) -> Markup:
    """Picture of one figure; `kind` is plan or test; `lines` (., 3) are drawn besides [m]."""
    view = View(stage, width)
    about = f"{figure.label}: the robot, seen from the front right, with its load {figure.load}"
    inside = [view.floor_grid(), _origin(view, stage), _figure(figure, view, kind, labelled=True)]
    inside += [polyline(view(points), "path") for points in lines]
    return drawing(view.width, view.height, about, *inside, class_="robot")


def group(
    planned: Sequence[DrawnCase], tests: Sequence[DrawnCase], stage: Stage, width: float
) -> Markup:
    """All figures in one picture, test poses behind."""
    view = View(stage, width)
    inside = [view.floor_grid(), _origin(view, stage)]
    inside += [_figure(figure, view, "test", labelled=False) for figure in tests]
    inside += [_figure(figure, view, "plan", labelled=False) for figure in planned]
    about = "All planned configurations, and the test poses, in one picture"
    many = " many" if len(planned) > 4 else ""
    return drawing(view.width, view.height, about, *inside, class_="robot" + many)


def _figure(figure: DrawnCase, view: View, kind: str, *, labelled: bool) -> Markup:
    """The robot as a line with joints, over its shadow."""
    skeleton = figure.skeleton
    parts = [polyline(view.shadow(part), "shadow") for part in (skeleton.arm, *skeleton.tool)]
    parts += [polyline(view(part), "tool") for part in skeleton.tool]
    parts += [polyline(view(skeleton.arm), "limb-edge"), polyline(view(skeleton.arm), "limb")]
    parts += [tag("circle", cx=x, cy=y, r=4.0, class_="joint") for x, y in view(skeleton.centres)]
    for x, y in view(np.vstack([skeleton.load_point, skeleton.markers])):
        parts.append(tag("circle", cx=x, cy=y, r=2.8, class_="marker"))
    for vector, heads in ((figure.force, 1), (figure.moment, 2)):
        parts.append(_arrow(view, skeleton.load_point, vector, heads))
    parts += _vectors(figure.vectors, view)
    if len(figure.trace):
        parts.append(polyline(view(figure.trace), "path"))
    if labelled and 0 < len(figure.load) <= _LONGEST:
        x, y = view((skeleton.load_point + figure.force)[None])[0]
        half = 4.2 * len(figure.load)
        beside = x + 7.0 + half if x + 7.0 + 2.0 * half < view.width else x - 7.0 - half
        beside = min(max(beside, half), view.width - half)
        parts.append(text(beside, y, figure.load, "load", "middle"))
    return tag("g", *parts, class_=f"figure {kind}")


def _arrow(view: View, start: Array, along: Array, heads: int) -> Markup:
    """Arrow of a force (one head) or a moment (two)."""
    if not np.any(along):
        return Markup("")
    a, b = view(np.vstack([start, start + along]))
    length = float(np.linalg.norm(b - a))
    if length < 3.0:
        return Markup("")
    unit = (b - a) / length
    side = np.array([-unit[1], unit[0]])
    parts = [line(a[0], a[1], b[0] - 5.0 * unit[0], b[1] - 5.0 * unit[1], "force")]
    for k in range(heads):
        tip = b - 7.0 * k * unit
        corners = (tip, tip - 9.0 * unit + 4.2 * side, tip - 9.0 * unit - 4.2 * side)
        shown = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)
        parts.append(tag("polygon", points=shown, class_="force-head"))
    return join(parts)


def _vectors(vectors: tuple[Vector, ...], view: View) -> list[Markup]:
    """Small arrows, and once around every start the circle of what noise would explain."""
    halos = {tuple(np.round(view(v.start[None])[0], 1)): v.halo for v in vectors if v.halo > 0.0}
    parts = [
        tag("circle", cx=x, cy=y, r=max(view.pixels(halo), 1.0), class_="halo")
        for (x, y), halo in halos.items()
    ]
    for vector in vectors:
        arrow = _arrow(view, vector.start, vector.along, 1)
        if arrow:
            parts.append(tag("g", arrow, class_="vector"))
    return parts


def _origin(view: View, stage: Stage) -> Markup:
    """The axes of the base frame."""
    parts = []
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        start, end, word = view(np.outer([0.0, 0.16, 0.215], axis * stage.size))
        parts.append(line(start[0], start[1], end[0], end[1], "axis"))
        parts.append(text(word[0], word[1] + 4.0, name, "axis-name", "middle"))
    return join(parts)


def _drawn(stage: Stage) -> Array:
    """(., 3) every point of every figure [m]."""
    points = [np.array(list(product([0.0], [0.0], [0.0, 0.2 * stage.size])))]
    points += [extent(f) for f in (*stage.planned, *stage.tests, *stage.peak)]
    return np.vstack(points)
