"""Forest plot: compliances and stiffnesses with their intervals, and a close-up of them.

In: estimates, intervals, what others say. Out: SVG, three panels side by side or, where it is
narrow, over one another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.report.charts.axes import (
    axis_below,
    corners,
    cut,
    legend,
    legend_height,
    width_of,
)

_LANE, _GAP = 30.0, 34.0
_SIGNS = ("diamond", "square", "triangle")


@dataclass(frozen=True)
class Estimate:
    """One compliance with its interval, in units to show.

    Attributes:
        name: Of the spring.
        value: Estimate.
        low: Lower end of the interval.
        high: Upper end; infinite if there is none.
        linear: Estimate of the linear model.
        references: What others say, NaN where they say nothing.
    """

    name: str
    value: float
    low: float
    high: float
    linear: float
    references: tuple[float, ...] = ()


def forest_chart(
    panels: Sequence[tuple[str, Sequence[Estimate]]],
    references: Sequence[str],
    confidence: str,
    width: float,
) -> Markup:
    """Panels of the same springs, each with an axis of its own.

    Args:
        panels: Title of the axis, and the estimates in its unit.
        references: Names of those whose values are shown beside, three at most.
        confidence: "95 %".
        width: Width of the picture [px].
    """
    narrow = width < 500.0
    names = [cut(e.name, 14) for e in panels[0][1]]
    room = 16.0 + max(width_of(name) for name in names)
    items = [("dot", "estimate"), ("bar", f"{confidence} interval"), ("tick", "linear model")]
    items += list(zip(_SIGNS, [cut(name, 30) for name in references], strict=False))
    y = 10.0 + legend_height(items, 4.0, width)
    parts = legend(items, 4.0, 10.0, width - 4.0)
    count = 1 if narrow else len(panels)
    wide = (width - room - 10.0 - _GAP * (count - 1)) / count
    height = _LANE * len(names) + 8.0
    for k, (title, rows) in enumerate(panels):
        left = room if narrow else room + k * (wide + _GAP)
        if k == 0 or narrow:
            for i, name in enumerate(names):
                parts.append(text(4.0, y + 8.0 + _LANE * (i + 0.5) + 1.0, name, "lane strong"))
        parts += _panel(title, rows, left, left + wide, y, y + height)
        if narrow:
            y += height + 58.0
    bottom = y if narrow else y + height + 46.0
    about = "Estimates with their intervals: " + ", ".join(names)
    return drawing(width, bottom, about, *parts, class_="chart")


def close_up(rows: Sequence[Estimate]) -> list[Estimate]:
    """The same in percent of the estimate, the estimate at zero."""

    def part(value: float, whole: float) -> float:
        return 100.0 * (value / whole - 1.0) if whole > 0.0 else np.nan

    return [
        Estimate(
            e.name,
            0.0 if e.value > 0.0 else np.nan,
            part(e.low, e.value),
            part(e.high, e.value),
            part(e.linear, e.value),
            tuple(part(r, e.value) for r in e.references),
        )
        for e in rows
    ]


def _panel(
    title: str, rows: Sequence[Estimate], left: float, right: float, top: float, bottom: float
) -> list[Markup]:
    """One axis with a lane for every spring."""
    scale = _scale(rows, left, right)
    parts = axis_below(scale, top, bottom, title, 4)
    if scale.low <= 0.0 <= scale.high:
        parts.append(line(scale(0.0), top - 2.0, scale(0.0), bottom, "zero"))
    for i, row in enumerate(rows):
        parts += _lane(row, scale, top + 4.0 + _LANE * (i + 0.5))
    return parts


def _scale(rows: Sequence[Estimate], left: float, right: float) -> Scale:
    """From zero or below to beyond every interval; far references do not count."""
    ends = np.array([[e.value, e.low, e.high, e.linear] for e in rows], dtype=float).ravel()
    ends = ends[np.isfinite(ends)]
    if not len(ends):
        return Scale(-1.0, 1.0, left, right)
    core = np.concatenate([ends, [0.0]])
    low, high = float(core.min()), float(core.max())
    others = np.array([r for e in rows for r in e.references if np.isfinite(r)])
    span = max(high - low, 1e-12)
    near = others[(others > low - span) & (others < high + span)]
    low, high = min([low, *near]), max([high, *near])
    span = max(high - low, 1e-12)
    return Scale(low - 0.05 * span * (low < 0.0), high + 0.08 * span, left, right)


def _lane(row: Estimate, scale: Scale, y: float) -> list[Markup]:
    """Interval, estimate, linear estimate and what others say."""
    parts = [line(scale.start, y, scale.end, y, "track")]

    def inside(value: float) -> float:
        return float(np.clip(scale(float(np.clip(value, -1e12, 1e12))), scale.start, scale.end))

    if np.isfinite(row.low) or np.isfinite(row.high):
        parts.append(line(inside(row.low), y, inside(row.high), y, "interval"))
        for end in (row.low, row.high):
            x, beyond = inside(end), not scale.low <= end <= scale.high
            if beyond:
                tip = 7.0 if end > scale.high else -7.0
                shape = f"{x},{y - 5} {x + tip},{y} {x},{y + 5}"
                parts.append(tag("polygon", points=shape, class_="interval-end"))
            else:
                parts.append(line(x, y - 5.0, x, y + 5.0, "interval"))
    for kind, value in zip(_SIGNS, row.references, strict=False):
        if np.isfinite(value):
            beyond = not scale.low <= value <= scale.high
            shape = corners(kind, inside(value), y, 6.0)
            parts.append(
                tag("polygon", points=shape, class_=f"mark {kind}{' beyond' if beyond else ''}")
            )
    if np.isfinite(row.linear) and scale.low <= row.linear <= scale.high:
        parts.append(line(scale(row.linear), y - 9.0, scale(row.linear), y + 9.0, "linear"))
    if np.isfinite(row.value):
        parts.append(tag("circle", cx=inside(row.value), cy=y, r=4.0, class_="dot"))
    return parts
