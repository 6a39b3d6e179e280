"""Whether campaigns keep what is predicted: bias, spread and coverage of every compliance.

In: statistics of many campaigns. Out: SVG, with the range that chance allows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.report.charts.axes import axis_below, corners, cut, legend, legend_height, width_of

_LANE = 30.0
_SIGNS = ("diamond", "square", "triangle")


@dataclass(frozen=True)
class Statistic:
    """One panel.

    Attributes:
        title: What it shows, with unit.
        target: What it should be.
        chance: Range that chance allows.
        values: (plans, p) what was found.
    """

    title: str
    target: float
    chance: tuple[float, float]
    values: Array


def calibration_chart(
    statistics: Sequence[Statistic], springs: Sequence[str], plans: Sequence[str], width: float
) -> Markup:
    """A panel for each statistic, a lane for each spring, a mark for each of three plans."""
    narrow = width < 500.0
    names = [cut(name, 12) for name in springs]
    room = 16.0 + max(width_of(name) for name in names)
    items = list(zip(_SIGNS, [cut(name, 24) for name in plans], strict=False))
    items.append(("band", "what chance allows (95 %)"))
    y = 12.0 + legend_height(items, 4.0, width)
    parts = legend(items, 4.0, 10.0, width - 4.0)
    columns = 1 if narrow else len(statistics)
    wide = (width - room - 12.0 - 30.0 * (columns - 1)) / columns
    height = _LANE * len(names) + 8.0
    for k, statistic in enumerate(statistics):
        left = room if narrow else room + k * (wide + 30.0)
        if k == 0 or narrow:
            for i, name in enumerate(names):
                parts.append(text(4.0, y + 8.0 + _LANE * (i + 0.5), name, "lane strong"))
        parts += _panel(statistic, left, left + wide, y, y + height)
        y += height + 56.0 if narrow else 0.0
    about = "Bias, spread and coverage of the estimates against what is predicted"
    return drawing(width, y if narrow else y + height + 46.0, about, *parts, class_="chart")


def _panel(shown: Statistic, left: float, right: float, top: float, bottom: float) -> list[Markup]:
    low = min(shown.chance[0], float(shown.values.min()))
    high = max(shown.chance[1], float(shown.values.max()))
    span = high - low
    scale = Scale(low - 0.15 * span, high + 0.15 * span, left, right)
    band = {"x": scale(shown.chance[0]), "width": scale(shown.chance[1]) - scale(shown.chance[0])}
    parts = [tag("rect", **band, y=top, height=bottom - top, class_="band")]
    parts += axis_below(scale, top, bottom, shown.title, 4)
    parts.append(line(scale(shown.target), top, scale(shown.target), bottom, "zero"))
    count = min(len(shown.values), len(_SIGNS))
    for kind, row, k in zip(_SIGNS, shown.values, range(count), strict=False):
        shift = 8.0 * (k - 0.5 * (count - 1))
        for i, value in enumerate(row):
            y = top + 4.0 + _LANE * (i + 0.5) + shift
            shape = corners(kind, scale(float(value)), y, 5.0)
            parts.append(tag("polygon", points=shape, class_=f"mark {kind}"))
    return parts
