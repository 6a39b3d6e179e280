"""Picture of nuisance parameters: what was found of each, on the band in which it was expected.

In: estimates in prior uncertainties. Out: SVG with one lane a parameter.
"""

from __future__ import annotations

from collections.abc import Sequence

from markupsafe import Markup

from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.identification.nuisance_found import NuisanceFound
from elastocal.report.charts.axes import axis_below, cut, legend, legend_height, width_of

_LANE = 26.0
_LEAST = 2.5  # prior uncertainties shown on either side, at least
_MOST = 8.0


def expected_chart(found: Sequence[NuisanceFound], width: float) -> Markup:
    """Estimates with their standard errors, zero in the middle, the priors as a band."""
    names = [cut(one.name, 18) for one in found]
    left = 16.0 + max((width_of(name) for name in names), default=0.0)
    items = [("dot", "found"), ("bar", "± standard error"), ("band", "expected")]
    top = 10.0 + legend_height(items, 4.0, width)
    ends = [abs(v) + e for v, e in (one.relative for one in found)]
    most = min(max(*ends, _LEAST), _MOST) if ends else _LEAST
    scale = Scale(-most, most, left, width - 14.0)
    bottom = top + _LANE * len(names) + 8.0
    parts = legend(items, 4.0, 10.0, width - 4.0)
    parts.append(
        tag("rect", x=scale(-1.0), y=top, width=scale(1.0) - scale(-1.0), height=bottom - top,
            class_="band")
    )  # fmt: skip
    parts += axis_below(scale, top, bottom, "in the uncertainties expected before", 6)
    parts.append(line(scale(0.0), top - 2.0, scale(0.0), bottom, "zero"))
    for i, (name, one) in enumerate(zip(names, found, strict=True)):
        y = top + 4.0 + _LANE * (i + 0.5)
        value, error = one.relative
        parts.append(text(4.0, y + 4.0, name, "lane strong"))
        low, high = (scale(min(max(v, -most), most)) for v in (value - error, value + error))
        parts.append(line(low, y, high, y, "interval"))
        x = scale(min(max(value, -most), most))
        parts.append(tag("circle", cx=x, cy=y, r=4.0, class_="ring" if one.held else "dot"))
    about = "What was fitted along, on what was expected: " + ", ".join(names)
    return drawing(width, bottom + 46.0, about, *parts, class_="chart")
