"""Dumbbells: the error of every experiment before and after, joined by a line.

In: errors. Out: SVG, on a logarithmic scale where one has to see both.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.report.charts.axes import axis_left, legend, legend_height, names_below
from elastocal.wording.numbers import shown_unit

_HEIGHT = 260.0
_MOST = 200  # experiments drawn


def dumbbell_chart(
    before: Array, after: Array, names: Sequence[str], width: float, si: str = "m"
) -> Markup:
    """Errors before and after, (N,) [unit `si`], one column for each experiment."""
    count = len(before)
    chosen = np.arange(count)
    if count > _MOST:  # the worst ones, and others evenly
        worst = np.argsort(-after)[: _MOST // 2]
        evenly = np.linspace(0, count - 1, _MOST // 2).astype(np.int64)
        chosen = np.unique(np.concatenate([worst, evenly]))
    before, after = before[chosen], after[chosen]
    values = np.concatenate([before, after])
    values = values[values > 0.0]
    if not len(values):
        values = np.array([1e-6])
    steep = values.max() > 6.0 * values.min()
    factor, unit = shown_unit(si, [float(np.sqrt(values.max() * values.min()))])
    what = "deflection" if si == "m" else "rotation"
    items = [("ring", f"before: measured {what}"), ("dot", "after: model subtracted")]
    left, right = 58.0, width - 8.0
    top = 38.0 + legend_height(items, left, right)
    bottom = top + _HEIGHT
    low = factor * max(float(values.min()) / 1.4, float(values.max()) * 1e-5) if steep else 0.0
    up = Scale(low, 1.25 * factor * float(values.max()), bottom, top, log=steep)
    title = f"RMS error [{unit}]" + (", logarithmic" if steep else "")
    parts = legend(items, left, 10.0, right)
    parts += axis_left(up, left, right, title)
    column = (right - left) / len(before)
    radius = float(np.clip(0.3 * column, 2.0, 5.0))
    places = [left + column * (k + 0.5) for k in range(len(before))]
    for x, a, b in zip(places, factor * before, factor * after, strict=True):
        ya, yb = up(max(a, up.low)), up(max(b, up.low))
        worse = " worse" if b > a else ""
        parts.append(line(x, ya, x, yb, f"rod{worse}"))
        parts.append(tag("circle", cx=x, cy=ya, r=radius, class_="ring"))
        parts.append(tag("circle", cx=x, cy=yb, r=radius, class_=f"dot{worse}"))
    parts += names_below(places, [names[i] for i in chosen.tolist()], bottom + 18.0)
    parts.append(text((left + right) / 2.0, bottom + 38.0, "experiment", "axis-title", "middle"))
    about = "Error of every experiment before and after subtracting the model"
    return drawing(width, bottom + 46.0, about, *parts, class_="chart")
