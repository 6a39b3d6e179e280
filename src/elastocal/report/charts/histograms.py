"""Histograms of the error that campaigns leave, plans over one another on the same axis.

In: errors of many campaigns, what was predicted. Out: SVG.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, polyline, tag, text
from elastocal.report.charts.axes import axis_below, cut, legend, legend_height, width_of
from elastocal.simulation.monte_carlo import Campaigns
from elastocal.wording.numbers import length_unit, number

_HEIGHT, _BINS = 92.0, 44
_NAMES = 150.0  # room for names beside the histograms, where it is wide enough


def histogram_chart(plans: Sequence[Campaigns], predicted: Sequence[Array], width: float) -> Markup:
    """A histogram for each plan; one scale for all, logarithmic if they lie far apart.

    `predicted` are errors drawn from what each plan promises, (S,) [m].
    """
    narrow = width < 500.0
    medians = [float(np.median(p.total)) for p in plans]
    steep = max(medians) > 3.0 * min(medians)
    least = min(float(np.quantile(p.total, 0.002 if steep else 0.0)) for p in plans)
    most = max(float(np.quantile(p.total, 0.998)) for p in plans)
    factor, unit = length_unit([float(np.median(medians))])
    left, right = (10.0 if narrow else _NAMES), width - 14.0
    low = factor * least / 1.05 if steep else 0.0
    scale = Scale(low, max(factor * most * 1.04, low * 1.01 + 1e-12), left, right, log=steep)
    edges = (
        np.geomspace(scale.low, scale.high, _BINS + 1)
        if steep
        else np.linspace(scale.low, scale.high, _BINS + 1)
    )
    items = [("box-random", "campaigns"), ("line-density", "predicted distribution")]
    items += [("line-own", "predicted RMS, ρ₀"), ("line-found", "RMS found")]
    parts = legend(items, left, 10.0, right)
    y = 30.0 + legend_height(items, left, right)
    top = y
    for plan, sample in zip(plans, predicted, strict=True):
        y += 22.0 if narrow else 0.0
        parts += _lane(plan, sample, factor, scale, edges, y)
        y += _HEIGHT + 16.0
    title = f"position error after compensation [{unit}]" + (", logarithmic" if steep else "")
    axis = axis_below(scale, top, y - 10.0, title, 4 if narrow else 9)
    about = "Errors of virtual campaigns by plan: " + ", ".join(p.name for p in plans)
    return drawing(width, y + 34.0, about, *axis, *parts, class_="chart")


def _lane(
    plan: Campaigns, sample: Array, factor: float, scale: Scale, edges: Array, top: float
) -> list[Markup]:
    """One histogram with its prediction."""
    floor = top + _HEIGHT
    counts, expected = (
        np.histogram(np.clip(factor * errors, edges[0], edges[-1]), edges)[0]
        for errors in (plan.total, sample)
    )
    smooth = expected * (len(plan.total) / len(sample))
    most = max(float(counts.max()), float(smooth.max()), 1.0)
    parts: list[Markup] = []
    for count, a, b in zip(counts, edges[:-1], edges[1:], strict=True):
        if count:
            x, height = scale(a), _HEIGHT * count / most
            box = {"x": x + 0.4, "y": floor - height, "width": scale(b) - x - 0.8, "height": height}
            parts.append(tag("rect", **box, class_="random"))
    steps = [
        (scale(edge), floor - _HEIGHT * value / most)
        for value, pair in zip(smooth, pairwise(edges), strict=True)
        for edge in pair
    ]
    parts.append(polyline(np.array(steps), "curve density"))
    for value, class_ in ((plan.rho0, "own"), (plan.rms, "found")):
        x = scale(float(np.clip(factor * value, scale.low, scale.high)))
        parts.append(line(x, top + 2.0, x, floor, f"curve {class_}"))
    parts.append(line(scale.start, floor, scale.end, floor, "base"))
    words = f"ρ₀ {number(factor * plan.rho0)}, found {number(factor * plan.rms)}"
    if scale.start < _NAMES:  # names above
        name = cut(plan.name, int((scale.end - scale.start - width_of(words) - 20.0) / 8.0))
        parts.append(text(scale.start, top - 7.0, name, "lane strong"))
        parts.append(text(scale.end, top - 7.0, words, "tick", "end"))
        return parts
    parts.append(text(4.0, floor - 44.0, cut(plan.name, 16), "lane strong"))
    parts.append(text(4.0, floor - 26.0, f"ρ₀ {number(factor * plan.rho0)}", "tick"))
    parts.append(text(4.0, floor - 10.0, f"found {number(factor * plan.rms)}", "tick"))
    return parts
