"""Errors along a path: lines over the way, and the band in which the rest is expected.

In: errors of the points of a path. Out: SVG on a logarithmic scale.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, polyline, tag, text
from elastocal.report.charts.axes import axis_below, axis_left, cut, legend, legend_height
from elastocal.wording.numbers import length_unit, number

_HEIGHT, _LANE = 270.0, 62.0
_MOST = 800  # points drawn of a line
_SPAN = 1e4  # the smallest error drawn, under the largest


@dataclass(frozen=True)
class Line:
    """One line of the picture.

    Attributes:
        name: What it is.
        class_: How it looks.
        value: (N,) errors [m], NaN where there is none.
    """

    name: str
    class_: str
    value: Array


def error_chart(way: Array, title: str, lines: Sequence[Line], band: Array, width: float) -> Markup:
    """Lengths of errors along a path.

    Args:
        way: (N,) place of every point.
        title: What `way` is, with unit.
        lines: Errors; what is smaller than a ten-thousandth of the largest ends at the axis.
        band: (N,) upper edge of the band in which errors are expected [m].
        width: Width of the picture [px].
    """
    keep = _thinned(len(way))
    values = np.concatenate([band, *(item.value for item in lines)])
    values = values[np.isfinite(values) & (values > 0.0)]
    if not len(values):
        values = np.array([1e-6])
    least = max(float(values.min()) / 1.5, float(values.max()) / _SPAN)
    factor, unit = length_unit([float(np.sqrt(least * values.max()))])
    items = [(f"line-{item.class_}", item.name) for item in lines]
    items.append(("band", "below twice ρ₀: expected in 95 of 100 identifications"))
    narrow = width < 500.0
    if narrow:
        items[-1] = ("band", "below twice ρ₀: expected")
    left, right = 58.0, width - 10.0
    top = 40.0 + legend_height(items, left, right)
    bottom = top + _HEIGHT
    up = Scale(factor * least, 1.3 * factor * float(values.max()), bottom, top, log=True)
    across = _across(way, left, right)
    parts = legend(items, left, 10.0, right)
    edge = [
        (across(a), _inside(up, factor * b)) for a, b in zip(way[keep], band[keep], strict=True)
    ]
    edge = [(x, y) for x, y in edge if np.isfinite(y)]
    if edge:
        outline = [(edge[0][0], bottom), *edge, (edge[-1][0], bottom)]
        shown = " ".join(f"{x:.1f},{y:.1f}" for x, y in outline)
        parts.append(tag("polygon", points=shown, class_="band"))
    parts += axis_left(up, left, right, f"position error [{unit}], logarithmic")
    parts += axis_below(across, bottom - 4.0, bottom, title, 4 if narrow else 8)
    parts.append(line(left, bottom, right, bottom, "base"))
    for item in lines:
        points = [
            (across(a), _inside(up, factor * b))
            for a, b in zip(way[keep], item.value[keep], strict=True)
        ]
        parts += _pieces(points, f"curve {item.class_}")
    about = "Position error along the path: " + ", ".join(item.name for item in lines)
    return drawing(width, bottom + 44.0, about, *parts, class_="chart")


def joint_chart(
    way: Array,
    title: str,
    corrections: Array,
    names: Sequence[str],
    units: Sequence[str],
    width: float,
) -> Markup:
    """Corrections (N, n) of the joints along a path, in the given units, one lane for each.

    Joints of the same unit share a scale, so that lanes can be compared.
    """
    keep = _thinned(len(way))
    left, right = 132.0, width - 10.0
    across = _across(way, left, right)
    most = {
        unit: max(
            float(np.nanmax(np.abs(corrections[:, [u == unit for u in units]]), initial=0.0)), 1e-9
        )
        for unit in set(units)
    }
    parts: list[Markup] = []
    y = 6.0
    for j, (name, unit) in enumerate(zip(names, units, strict=True)):
        largest = float(np.nanmax(np.abs(corrections[:, j]), initial=0.0))
        scale = Scale(-1.1 * most[unit], 1.1 * most[unit], y + _LANE - 8.0, y)
        parts += axis_left(scale, left, right, most=4)
        parts.append(text(4.0, scale(0.0) - 2.0, cut(name, 11), "lane strong"))
        parts.append(text(4.0, scale(0.0) + 13.0, f"to {number(largest, 2)}\u00a0{unit}", "tick"))
        parts.append(line(left, scale(0.0), right, scale(0.0), "base"))
        points = [
            (across(a), scale(b) if np.isfinite(b) else np.nan)
            for a, b in zip(way[keep], corrections[keep, j], strict=True)
        ]
        parts += _pieces(points, "curve after")
        y += _LANE + 6.0
    parts += axis_below(across, y - 10.0, y - 6.0, title, 4 if width < 500.0 else 8)
    about = "Corrections of the joints along the path"
    return drawing(width, y + 38.0, about, *parts, class_="chart")


def _across(way: Array, left: float, right: float) -> Scale:
    low, high = float(way.min()), float(way.max())
    return Scale(low, high if high > low else low + 1.0, left, right)


def _inside(scale: Scale, value: float) -> float:
    """Pixel of a value, at the lower end if it is smaller; NaN stays."""
    return scale(max(value, scale.low)) if np.isfinite(value) else float("nan")


def _pieces(points: Sequence[tuple[float, float]], class_: str) -> list[Markup]:
    """Lines through points, broken where one is missing; a lone point as a dot."""
    parts: list[Markup] = []
    piece: list[tuple[float, float]] = []
    for point in [*points, (0.0, float("nan"))]:
        if np.isfinite(point[1]):
            piece.append(point)
            continue
        if len(piece) > 1:
            parts.append(polyline(np.array(piece), class_))
        elif piece:
            x, y = piece[0]
            parts.append(tag("circle", cx=x, cy=y, r=3.0, class_=f"dot {class_}"))
        piece = []
    return parts


def _thinned(count: int) -> Array:
    return np.unique(np.linspace(0, count - 1, min(count, _MOST)).astype(np.int64))
