"""The path of a task as a picture: as wanted, as the load bends it, as corrected.

In: points in the base frame. Out: SVG from the same side as the pictures of the robot.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.projection import Projection
from elastocal.drawing.svg import drawing, line, polyline, tag, text
from elastocal.report.charts.axes import legend, legend_height

_TIES = 24  # thin lines between the wanted and the bent path


def magnification(size: float, path: Array) -> float:
    """A round factor at which an error of this `size` [m] is well seen beside a path (N, 3)."""
    reach = max(float(np.linalg.norm(np.ptp(path, axis=0))), 0.05)
    value = max(0.22 * reach / max(size, 1e-12), 1.0)
    power = 10.0 ** np.floor(np.log10(value))
    return float(max(s * power for s in (1.0, 2.0, 5.0) if s * power <= value))


def path_picture(
    wanted: Array, lines: Sequence[tuple[str, str, Array]], factor: float, width: float
) -> Markup:
    """Wanted path (N, 3) [m] and others given by name, class and error (N, 3) [m].

    Errors are magnified by `factor`; NaN leaves a gap.
    """
    drawn = [(name, class_, wanted + factor * error) for name, class_, error in lines]
    everything = np.vstack(
        [wanted, *(points[np.isfinite(points).all(axis=1)] for *_, points in drawn)]
    )
    low, high = everything.min(axis=0), everything.max(axis=0)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    box = np.array(list(product(*zip(middle - 0.02, middle + 0.02, strict=True))))
    items = [("line-wanted", "wanted"), *((f"line-{c}", name) for name, c, _ in lines)]
    head = 26.0 + legend_height(items, 6.0, width)
    view = Projection(np.vstack([everything, box]), width, margins=(70.0, head, 84.0))
    height = min(view.height, 1.1 * width)
    if view.height > height:
        scale = view.scale * (height - head - 84.0) / (view.height - head - 84.0)
        view = Projection(
            np.vstack([everything, box]), width, margins=(70.0, head, 84.0), scale=scale
        )
    parts = legend(items, 6.0, 10.0, width - 6.0)
    parts += _triad(view, float(half.max()))
    ties = np.unique(np.linspace(0, len(wanted) - 1, _TIES).astype(int))
    if drawn:
        for i in ties.tolist():
            pair = np.array([wanted[i], drawn[0][2][i]])
            if np.isfinite(pair).all():
                parts.append(polyline(view(pair), "tie"))
    parts.append(_trace(view, wanted, "curve wanted"))
    parts += [_trace(view, points, f"curve {class_}") for _, class_, points in drawn]
    x, y = view(wanted[:1])[0]
    parts.append(tag("circle", cx=x, cy=y, r=4.0, class_="start"))
    parts.append(text(x, y - 9.0, "start", "value", "middle"))
    about = "The wanted path, and where the tool is without and with compensation, magnified"
    return drawing(width, view.height, about, *parts, class_="chart path")


def _trace(view: Projection, points: Array, class_: str) -> Markup:
    """A line through points, without those that are missing."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) > 800:
        points = points[np.unique(np.linspace(0, len(points) - 1, 800).astype(int))]
    if len(points) == 1:
        x, y = view(points)[0]
        return tag("circle", cx=x, cy=y, r=3.5, class_=f"spot {class_}")
    return polyline(view(points), class_)


def _triad(view: Projection, half: float) -> list[Markup]:
    """The directions of the base frame with a length one can read, at the corner below."""
    size = 0.45 * max(half, 0.02)
    power = 10.0 ** np.floor(np.log10(size))
    size = max(s * power for s in (1.0, 2.0, 5.0) if s * power <= size)
    ends = view(size * np.eye(3)) - view(np.zeros((1, 3)))
    reach = float(np.abs(ends).max())
    corner = np.array([16.0 + max(0.0, float(-ends[:, 0].min())), view.height - 26.0])
    corner[1] -= max(0.0, float(ends[:, 1].max()))
    parts = []
    for end, name in zip(ends, "xyz", strict=True):
        a, b = corner, corner + end
        parts.append(line(a[0], a[1], b[0], b[1], "axis"))
        at = b + 10.0 * end / max(float(np.linalg.norm(end)), 1e-9)
        parts.append(text(at[0], at[1] + 4.0, name, "axis-name", "middle"))
    words = f"each {1e3 * size:.4g} mm"
    parts.append(text(4.0, view.height - 6.0, words, "axis-name"))
    return parts if reach > 8.0 else []
