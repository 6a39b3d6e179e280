"""Histograms of the error that campaigns leave, plans over one another on the same axis.

In: errors of many campaigns, what was predicted. Out: SVG.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, polyline, tag, text
from elastocal.report.charts.axes import axis_below, cut, legend, legend_height, width_of
from elastocal.simulation.campaigns import Campaigns, RandomCampaigns
from elastocal.wording.numbers import length_unit, number

_HEIGHT, _BINS = 92.0, 44
_NAMES = 150.0  # room for names beside the histograms, where it is wide enough


@dataclass(frozen=True)
class _Lane:
    """One histogram: a name, errors [m], what was predicted, and errors drawn from that, if any."""

    name: str
    errors: Array
    rho0: float
    rms: float
    sample: Array | None


def histogram_chart(
    plans: Sequence[Campaigns],
    predicted: Sequence[Array],
    width: float,
    random: RandomCampaigns | None = None,
) -> Markup:
    """A histogram for each plan; one scale for all, logarithmic if they lie far apart.

    `predicted` are errors drawn from what each plan promises, (S,) [m]. Random plans together are
    a further one, without.
    """
    narrow = width < 500.0
    medians = [float(np.median(p.total)) for p in plans]
    steep = max(medians) > 3.0 * min(medians)
    most = max(float(np.quantile(p.total, 0.998)) for p in plans)
    lanes = [
        _Lane(p.name, p.total, p.rho0, p.rms, s) for p, s in zip(plans, predicted, strict=True)
    ]
    if random is not None:
        steep = steep or float(np.quantile(random.total, 0.95)) > 6.0 * min(medians)
        most = max(most, float(np.quantile(random.total, 0.98)))  # their tail may have no end
        lanes.append(_Lane(random.name, random.total.ravel(), random.rho0, random.rms, None))
    least = min(float(np.quantile(lane.errors, 0.002 if steep else 0.0)) for lane in lanes)
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
    for lane in lanes:
        y += 22.0 if narrow else 0.0
        parts += _lane(lane, factor, scale, edges, y)
        y += _HEIGHT + 16.0
    title = f"position error after compensation [{unit}]" + (", logarithmic" if steep else "")
    axis = axis_below(scale, top, y - 10.0, title, 4 if narrow else 9)
    about = "Errors of virtual campaigns by plan: " + ", ".join(lane.name for lane in lanes)
    return drawing(width, y + 34.0, about, *axis, *parts, class_="chart")


def _lane(lane: _Lane, factor: float, scale: Scale, edges: Array, top: float) -> list[Markup]:
    """One histogram with its prediction."""
    floor = top + _HEIGHT
    counts = _counted(factor * lane.errors, edges)
    smooth = np.zeros(0)
    if lane.sample is not None:
        smooth = _counted(factor * lane.sample, edges) * (len(lane.errors) / len(lane.sample))
    most = max(float(counts.max()), float(smooth.max(initial=0.0)), 1.0)
    parts: list[Markup] = []
    for count, a, b in zip(counts, edges[:-1], edges[1:], strict=True):
        if count:
            x, height = scale(a), _HEIGHT * count / most
            box = {"x": x + 0.4, "y": floor - height, "width": scale(b) - x - 0.8, "height": height}
            parts.append(tag("rect", **box, class_="random"))
    steps = [
        (scale(edge), floor - _HEIGHT * value / most)
        for value, pair in zip(smooth, pairwise(edges), strict=False)
        for edge in pair
    ]
    if steps:
        parts.append(polyline(np.array(steps), "curve density"))
    for value, class_ in ((lane.rho0, "own"), (lane.rms, "found")):
        x = scale(float(np.clip(factor * value, scale.low, scale.high)))
        parts.append(line(x, top + 2.0, x, floor, f"curve {class_}"))
    parts.append(line(scale.start, floor, scale.end, floor, "base"))
    words = f"ρ₀ {number(factor * lane.rho0)}, found {number(factor * lane.rms)}"
    if scale.start < _NAMES:  # names above
        name = cut(lane.name, int((scale.end - scale.start - width_of(words) - 20.0) / 8.0))
        parts.append(text(scale.start, top - 7.0, name, "lane strong"))
        parts.append(text(scale.end, top - 7.0, words, "tick", "end"))
        return parts
    parts.append(text(4.0, floor - 44.0, cut(lane.name, 16), "lane strong"))
    parts.append(text(4.0, floor - 26.0, f"ρ₀ {number(factor * lane.rho0)}", "tick"))
    parts.append(text(4.0, floor - 10.0, f"found {number(factor * lane.rms)}", "tick"))
    return parts


def _counted(values: Array, edges: Array) -> Array:
    """How many values lie in each bin; those beyond the axis in the last one."""
    return np.asarray(np.histogram(np.clip(values, edges[0], edges[-1]), edges)[0])
