"""Pictures of a calibration: models that grow, unknowns, errors in space, what joints do.

In: numbers. Out: SVG.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.report.charts.axes import axis_below, cut, legend, legend_height
from elastocal.wording.numbers import length, length_unit, number

_LANE = 30.0


class Bars(NamedTuple):
    """Two lengths of one name."""

    name: str
    first: float
    second: float
    mark: str = ""


def bar_chart(rows: Sequence[Bars], names: tuple[str, str], title: str, width: float) -> Markup:
    """Two bars for every name: the first wide and light, the second narrow and full.

    Args:
        rows: Lengths [m].
        names: What the two are.
        title: What is drawn, for the axis.
        width: Width of the picture [px].
    """
    narrow = width < 500.0
    left, right = (96.0 if narrow else 190.0), width - 16.0
    values = [v for row in rows for v in (row.first, row.second) if np.isfinite(v)]
    factor, unit = length_unit([max(values, default=1.0)])
    scale = Scale(0.0, 1.12 * factor * max(max(values, default=1.0), 1e-12), left, right)
    items = [("box-bar-first", names[0]), ("box-bar-second", names[1])]
    top = 14.0 + legend_height(items, left, right)
    bottom = top + _LANE * len(rows)
    parts = legend(items, left, 8.0, right)
    parts += axis_below(scale, top, bottom, f"{title} [{unit}]", 4 if narrow else 7)
    for i, row in enumerate(rows):
        y = top + _LANE * (i + 0.5)
        label = cut(row.name, 12 if narrow else 24)
        parts.append(text(left - 8.0, y + 4.0, label, "label", "end"))
        for value, half, kind in ((row.first, 9.0, "bar-first"), (row.second, 4.0, "bar-second")):
            if np.isfinite(value):
                size = max(scale(factor * value) - left, 0.5)
                parts.append(
                    tag("rect", x=left, y=y - half, width=size, height=2 * half, class_=kind)
                )
        if row.mark:
            largest = max(v for v in (row.first, row.second) if np.isfinite(v))
            parts.append(text(scale(factor * largest) + 6.0, y + 4.0, row.mark, "mark"))
    about = f"{title}: " + ", ".join(f"{row.name} {length(row.second)}" for row in rows)
    return drawing(width, bottom + 48.0, about, *parts, class_="chart")


class Found(NamedTuple):
    """One unknown, in the unit that is shown."""

    name: str
    value: float
    half: float
    seen: bool


def interval_chart(found: Sequence[Found], unit: str, width: float) -> Markup:
    """Unknowns of one unit with their intervals; open rings where nothing tells them."""
    narrow = width < 500.0
    left, right = (118.0 if narrow else 190.0), width - 16.0
    told = [one for one in found if one.seen]
    reach = max(
        [abs(one.value) + one.half for one in told] + [abs(o.value) for o in found] + [1e-9]
    )
    scale = Scale(-1.08 * reach, 1.08 * reach, left, right)
    top = 8.0
    bottom = top + 22.0 * len(found)
    parts = axis_below(scale, top, bottom, f"[{unit}]", 4 if narrow else 8)
    parts.append(line(scale(0.0), top, scale(0.0), bottom, "zero"))
    for i, one in enumerate(found):
        y = top + 22.0 * (i + 0.5)
        parts.append(text(left - 8.0, y + 4.0, cut(one.name, 15 if narrow else 24), "label", "end"))
        if not one.seen:
            parts.append(tag("circle", cx=scale(one.value), cy=y, r=4.0, class_="untold"))
            continue
        low, high = scale(one.value - one.half), scale(one.value + one.half)
        parts.append(line(low, y, high, y, "interval"))
        parts.append(tag("circle", cx=scale(one.value), cy=y, r=4.0, class_="estimate"))
    about = "Unknowns with their 95 % intervals: " + ", ".join(
        f"{one.name} {number(one.value)}" for one in told
    )
    return drawing(width, bottom + 48.0, about, *parts, class_="chart")


def error_map(
    points: Array,
    before: Array,
    after: Array,
    plane: tuple[int, int],
    scale_up: float,
    width: float,
) -> Markup:
    """Where positions were read, with errors as arrows many times as long as they are.

    Args:
        points: (R, 3) in the frame of the base [m].
        before: (R, 3) errors of the arm as drawn, base and reflectors fitted [m].
        after: (R, 3) errors of the calibrated arm [m].
        plane: Which two axes are seen.
        scale_up: How many times errors are enlarged.
        width: Width of the picture [px].
    """
    a, b = plane
    low = np.minimum(points.min(axis=0), 0.0) - 0.15
    high = np.maximum(points.max(axis=0), 0.0) + 0.15
    height = width * (high[b] - low[b]) / (high[a] - low[a])
    across = Scale(low[a], high[a], 26.0, width - 8.0)
    up = Scale(low[b], high[b], 26.0 + height, 26.0)
    parts = []
    for metre in range(int(np.ceil(low[a])), int(np.floor(high[a])) + 1):
        parts.append(line(across(metre), up(low[b]), across(metre), up(high[b]), "grid"))
    for metre in range(int(np.ceil(low[b])), int(np.floor(high[b])) + 1):
        parts.append(line(across(low[a]), up(metre), across(high[a]), up(metre), "grid"))
    parts.append(tag("circle", cx=across(0.0), cy=up(0.0), r=6.0, class_="base-mark"))
    parts.append(text(across(0.0) + 9.0, up(0.0) + 4.0, "base", "label"))
    chosen = np.linspace(0, len(points) - 1, min(len(points), _MOST)).astype(int)
    for errors, kind in ((before, "error-before"), (after, "error-after")):
        for r in chosen.tolist():
            start, end = points[r], points[r] + scale_up * errors[r]
            parts.append(line(across(start[a]), up(start[b]), across(end[a]), up(end[b]), kind))
    parts += [
        tag("circle", cx=across(points[r, a]), cy=up(points[r, b]), r=1.6, class_="speck")
        for r in chosen.tolist()
    ]
    axes = "xyz"
    parts.append(text(width - 10.0, 18.0, f"{axes[a]} to the right, {axes[b]} up", "tick", "end"))
    parts.append(text(26.0, 18.0, f"errors × {number(scale_up, 2)}; squares of 1 m", "tick"))
    about = f"Errors of positions before and after, seen in {axes[a]} and {axes[b]}"
    return drawing(width, height + 34.0, about, *parts, class_="chart")


_MOST = 400  # errors that are drawn
