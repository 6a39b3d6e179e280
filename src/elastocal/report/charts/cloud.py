"""Clouds: two estimates over one another, with the ellipse in which they are predicted.

In: estimates of many campaigns, predicted ellipse. Out: SVG.
"""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, tag
from elastocal.report.charts.axes import axis_below, axis_left, cut

_WIDTH, _HEIGHT = 400.0, 340.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 54.0, 388.0, 34.0, 288.0
_MOST = 600


def cloud_chart(
    shift: Array, ellipse: Array, names: tuple[str, str], units: tuple[str, str], reach: Array
) -> Markup:
    """Estimates minus truth, (K, 2), and the ellipse that holds 95 % of them by prediction.

    Args:
        shift: In the given units.
        ellipse: (., 2) its outline, in the same units.
        names: Of the two springs.
        units: Of the two axes.
        reach: (2,) half the length of the axes: alike for plans to be compared.
    """
    across = Scale(-reach[0], reach[0], _LEFT, _RIGHT)
    up = Scale(-reach[1], reach[1], _BOTTOM, _TOP)
    parts = axis_below(across, _TOP, _BOTTOM, f"{cut(names[0], 12)} − truth [{units[0]}]", 5)
    parts += axis_left(up, _LEFT, _RIGHT, f"{cut(names[1], 12)} − truth [{units[1]}]")
    parts.append(line(across(0.0), _TOP, across(0.0), _BOTTOM, "zero"))
    parts.append(line(_LEFT, up(0.0), _RIGHT, up(0.0), "zero"))
    inside = (np.abs(shift) <= reach).all(axis=1)
    for a, b in shift[inside][:_MOST]:
        parts.append(tag("circle", cx=across(a), cy=up(b), r=1.8, class_="speck"))
    shown = " ".join(f"{across(a):.1f},{up(b):.1f}" for a, b in ellipse)
    parts.append(tag("polygon", points=shown, class_="ellipse"))
    about = f"Estimates of {names[0]} and {names[1]} with the predicted ellipse"
    return drawing(_WIDTH, _HEIGHT, about, *parts, class_="chart")
