"""Quantile plot: residuals against the normal distribution, with the band of chance.

In: quantiles of the residuals. Out: SVG.
"""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from elastocal.drawing.svg import Scale, drawing, polyline, tag
from elastocal.identification.residuals import Quantiles
from elastocal.report.charts.axes import axis_below, axis_left

_WIDTH, _HEIGHT = 400.0, 330.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 48.0, 390.0, 34.0, 282.0


def quantile_chart(quantiles: Quantiles) -> Markup:
    """Sorted residuals over the quantiles they should have, with the band of each."""
    found, expected = quantiles.found, quantiles.expected
    low, high = quantiles.low, quantiles.high
    end = 1.08 * max(float(np.abs(expected).max()), 1.0)
    most = 1.05 * max(float(np.abs(found).max()), end, float(min(np.abs(low).max(), 2.0 * end)))
    across = Scale(-end, end, _LEFT, _RIGHT)
    up = Scale(-most, most, _BOTTOM, _TOP)
    clipped = np.clip(np.concatenate([low, high[::-1]]), -most, most)
    outline = zip(np.concatenate([expected, expected[::-1]]), clipped, strict=True)
    shown = " ".join(f"{across(a):.1f},{up(b):.1f}" for a, b in outline)
    parts = [tag("polygon", points=shown, class_="band")]
    parts += axis_below(across, _TOP, _BOTTOM, "expected of normal noise [σ]", 5)
    parts += axis_left(up, _LEFT, _RIGHT, "found [σ]")
    ends = np.array([[across(-end), up(-end)], [across(end), up(end)]])
    parts.append(polyline(ends, "reference"))
    outside = (found < low) | (found > high)
    for a, b, out in zip(expected, found, outside, strict=True):
        class_ = "far" if out else "dot"
        parts.append(tag("circle", cx=across(a), cy=up(b), r=3.0, class_=class_))
    about = "Sorted residuals over the quantiles of normal noise"
    return drawing(_WIDTH, _HEIGHT, about, *parts, class_="chart")
