"""Strips: one mark for every reading and axis, with the band in which it is expected.

In: errors, half widths of bands, experiments. Out: SVG with a strip for each of x, y and z.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array, IntArray
from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.report.charts.axes import axis_left, legend, legend_height, names_below
from elastocal.wording.numbers import shown_unit

_MOST = 900  # readings drawn in one picture
_HEIGHT, _GAP = 104.0, 20.0


@dataclass(frozen=True)
class Strips:
    """What to draw.

    Attributes:
        error: (R, 3) errors [unit].
        half: (R, 3) half widths of the band around zero [unit].
        case: (R,) experiment of each reading.
        names: Names of the experiments.
        band: What the band is, in words.
        unit: SI unit of the errors: "m", or "rad" for rotations about x, y and z.
    """

    error: Array
    half: Array
    case: IntArray
    names: Sequence[str]
    band: str
    unit: str = "m"

    @property
    def shown(self) -> IntArray:
        """Readings that are drawn: the farthest out for their band, and others evenly."""
        count = len(self.error)
        if count <= _MOST:
            return np.arange(count)
        with np.errstate(divide="ignore", invalid="ignore"):
            far = np.nan_to_num(np.abs(self.error) / self.half).max(axis=1)
        outer = np.argsort(-far)[: _MOST // 3]
        evenly = np.linspace(0, count - 1, _MOST - len(outer)).astype(np.int64)
        return np.unique(np.concatenate([outer, evenly]))

    @property
    def remark(self) -> str:
        """What is not drawn, in words."""
        left = len(self.error) - len(self.shown)
        return f"{left} further readings, none of them the farthest out, are not drawn." * bool(
            left
        )


def strips_chart(strips: Strips, width: float) -> Markup:
    """Three strips over one another, one scale for all."""
    shown = strips.shown
    error, half, case = strips.error[shown], strips.half[shown], strips.case[shown]
    finite = half[np.isfinite(half)]
    most = max(float(np.abs(error).max(initial=0.0)), float(finite.max(initial=0.0)), 1e-12)
    factor, unit = shown_unit(strips.unit, [most / 3.0])
    left, right = 66.0, width - 8.0
    used = np.unique(case)
    column = (right - left) / len(used)
    place = {int(c): left + column * (k + 0.5) for k, c in enumerate(used)}
    offsets = _offsets(case)
    x = np.array([place[int(c)] for c in case]) + np.clip(column, 0.0, 40.0) * 0.7 * offsets
    items = [("band", strips.band), ("dot", "inside"), ("far", "outside")]
    y = 46.0 + legend_height(items, left, right) - 20.0
    parts_title = text(
        4.0,
        y - 4.0,
        f"{'error' if strips.unit == 'm' else 'error of the rotation'} [{unit}]",
        "axis-title",
    )
    y += 10.0
    parts = [*legend(items, left, 10.0, right), parts_title]
    radius = float(np.clip(0.22 * column, 1.6, 4.2))
    for axis, name in enumerate("xyz"):
        top, bottom = y, y + _HEIGHT
        scale = Scale(-1.08 * factor * most, 1.08 * factor * most, bottom, top)
        widths = factor * np.where(np.isfinite(half[:, axis]), half[:, axis], 1.08 * most)
        slot = max(min(column, 40.0) * 0.7 / max(len(np.unique(offsets)), 1), 1.0)
        parts += [
            tag(
                "rect",
                x=a - slot / 2.0,
                y=scale(h),
                width=slot,
                height=scale(-h) - scale(h),
                class_="band",
            )
            for a, h in zip(x, widths, strict=True)
        ]
        parts += axis_left(scale, left, right, most=4)
        parts.append(text(4.0, scale(0.0) + 4.5, name, "lane strong"))
        parts.append(line(left, scale(0.0), right, scale(0.0), "base"))
        outside = np.abs(error[:, axis]) > half[:, axis]
        for a, e, out in zip(x, factor * error[:, axis], outside, strict=True):
            class_ = "far" if out else "dot"
            r = radius * (1.25 if out else 1.0)
            parts.append(tag("circle", cx=a, cy=scale(float(e)), r=r, class_=class_))
        y = bottom + _GAP
    places = [place[int(c)] for c in used]
    parts += names_below(places, [strips.names[int(c)] for c in used], y)
    parts.append(text((left + right) / 2.0, y + 20.0, "experiment", "axis-title", "middle"))
    about = "Errors of every reading along x, y and z with the band in which they are expected"
    return drawing(width, y + 28.0, about, *parts, class_="chart")


def _offsets(case: IntArray) -> Array:
    """(R,) places of the readings of one experiment beside each other, from -0.5 to 0.5."""
    order = np.argsort(case, kind="stable")
    rank = np.zeros(len(case))
    seen: dict[int, int] = {}
    for r in order.tolist():
        rank[r] = seen.get(int(case[r]), 0)
        seen[int(case[r])] = int(rank[r]) + 1
    most = max(seen.values(), default=1)
    return np.zeros(len(case)) if most == 1 else (rank + 0.5) / most - 0.5
