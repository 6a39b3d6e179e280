"""Picture of what lies between a plan and the best of all: plan, bound of the search, proved bound.

In: errors [m]. Out: SVG, on a linear axis around them.
"""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.wording.numbers import fixed, length_unit, number
from elastocal.wording.proofs import proved_length

_LANE = 44.0


def bounds_chart(value: float, bound: float, proved: float, width: float) -> Markup:
    """A plan and what no plan is below.

    Args:
        value: Error of the plan [m].
        bound: No plan is below, as far as a search found [m].
        proved: No plan is below: this is proved [m].
        width: Width of the picture [px].
    """
    factor, unit = length_unit([value])
    span = max(value - proved, 1e-5 * value)
    narrow = width < 500.0
    left, right = (10.0 if narrow else 190.0), width - (16.0 if narrow else 40.0)
    low, high = max(proved - 0.45 * span, 0.0), value + 0.3 * span
    scale = Scale(factor * low, factor * high, left, right)
    apart = max(min(value - bound, bound - proved), 1e-3 * span)
    digits = int(np.clip(np.ceil(np.log10(value / apart)) + 2, 4, 7))
    lanes = (
        ("this plan", value, "own"),
        ("bound of the search", bound, "searched"),
        ("proved bound", proved, "proved"),
    )
    top, bottom = 12.0, 12.0 + _LANE * len(lanes)
    x_proved, x_bound = scale(factor * proved), scale(factor * bound)
    parts = [
        _area(left, x_proved, top, bottom, "barred proved"),
        _area(x_proved, x_bound, top, bottom, "barred"),
    ]
    ticks = scale.ticks(4 if narrow else 7)
    step = min(np.diff(ticks), default=factor * value)
    decimals = int(max(np.ceil(-np.log10(step) - 1e-9), 0))
    for tick in ticks:
        parts.append(line(scale(tick), top, scale(tick), bottom, "grid"))
        parts.append(text(scale(tick), bottom + 16.0, fixed(tick, decimals), "tick", "middle"))
    for i, (name, size, class_) in enumerate(lanes):
        y, x = top + _LANE * (i + 0.62), scale(factor * size)
        shown = _words(size, class_, factor, unit, digits)
        if narrow:
            shown = f"{name} {shown}"
        else:
            parts.append(text(left - 14.0, y + 4.5, name, f"lane {class_}", "end"))
        parts.append(line(left, y, right, y, "track"))
        if class_ == "own":
            corners = f"{x},{y - 8} {x + 8},{y} {x},{y + 8} {x - 8},{y}"
            parts.append(tag("polygon", points=corners, class_="mark own"))
        else:
            parts.append(line(x, y - 13.0, x, y + 9.0, f"bound {class_}"))
        half = 3.7 * len(shown)
        middle = min(max(x, left + half), right - half)
        parts.append(text(middle, y - 14.0, shown, f"value {class_}", "middle"))
    name = f"position error [{unit}]; smaller is better"
    parts.append(text((left + right) / 2.0, bottom + 38.0, name, "axis-title", "middle"))
    about = ", ".join(
        f"{name} {_words(size, class_, factor, unit, digits)}" for name, size, class_ in lanes
    )
    return drawing(width, bottom + 46.0, about, *parts, class_="chart bounds")


def _words(size: float, class_: str, factor: float, unit: str, digits: int) -> str:
    """A length, in the unit of the axis if it is not one that must not be rounded up."""
    if class_ == "proved":
        return proved_length(size, digits)
    return f"{number(factor * size, digits)} {unit}"


def _area(x1: float, x2: float, top: float, bottom: float, class_: str) -> Markup:
    """Where no plan is."""
    size = {"width": max(x2 - x1, 0.0), "height": bottom - top}
    return tag("rect", x=x1, y=top, class_=class_, **size)
