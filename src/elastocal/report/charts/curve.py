"""Pictures of ρ0 over what a campaign costs.

In: values over counts. Out: SVG, small enough to stand beside each other or on a phone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array, IntArray
from elastocal.drawing.svg import Scale, drawing, line, polyline, tag, text, tick_labels
from elastocal.wording.numbers import length, length_unit

_WIDTH, _HEIGHT = 400.0, 290.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 52.0, 386.0, 30.0, 236.0


def curve_chart(
    counts: IntArray, rho0: Array, bound: Array | None, own: tuple[int, float], axis: str
) -> Markup:
    """ρ0 over a number.

    Args:
        counts: (K,) the numbers.
        rho0: (K,) error of a plan for each [m].
        bound: (K,) no plan has a smaller error [m], NaN if unknown; None leaves the line out.
        own: Number and error [m] of the plan of this report, marked.
        axis: What is counted.
    """
    known = None if bound is None or not np.isfinite(bound).any() else bound
    everything = [*rho0, *(known if known is not None else ()), own[1]]
    finite = [float(value) for value in everything if np.isfinite(value)]
    factor, unit = length_unit(finite)
    steep = max(finite) > 8.0 * min(finite)
    low = factor * min(finite) / 1.15 if steep else 0.0
    first, last = float(min(counts)), max(float(max(counts)), own[0])
    begin = 0.0 if first <= 0.15 * last else first - 0.12 * (last - first) - 0.2
    across = Scale(begin, last + 0.08 * (last - begin), _LEFT, _RIGHT)
    up = Scale(low, 1.12 * factor * max(finite), _BOTTOM, _TOP, log=steep)
    parts = _frame(across, up, counts, f"ρ₀ [{unit}]", axis)
    if known is not None:
        points = _path(across, up, counts, factor * known)
        parts.append(polyline(points, "bound"))
        x, y = points[-1]
        parts.append(text(x, y + 22.0, "lower bound", "bound-name", "end"))
    points = _path(across, up, counts, factor * rho0)
    parts.append(polyline(points, "curve"))
    parts += [tag("circle", cx=x, cy=y, r=4.0, class_="dot") for x, y in points]
    x, y = across(own[0]), up(factor * own[1])
    corners = f"{x},{y - 9} {x + 9},{y} {x},{y + 9} {x - 9},{y}"
    parts.append(tag("polygon", points=corners, class_="mark own"))
    parts.append(text(min(x, _RIGHT - 22.0), y - 16.0, "this plan", "value own", "middle"))
    about = f"Root mean square position error over {axis}; this plan {length(own[1])}"
    return drawing(_WIDTH, _HEIGHT, about, *parts, class_="chart")


def _path(across: Scale, up: Scale, counts: IntArray, values: Array) -> Array:
    """(., 2) pixels of the finite values."""
    pairs = zip(counts, values, strict=True)
    return np.array([(across(n), up(v)) for n, v in pairs if np.isfinite(v)]).reshape(-1, 2)


def _frame(across: Scale, up: Scale, counts: IntArray, title: str, axis: str) -> list[Markup]:
    """Axes, grid and their names."""
    parts = []
    ticks = up.ticks(5)
    for tick, words in zip(ticks, tick_labels(ticks), strict=True):
        y = up(tick)
        parts.append(line(_LEFT, y, _RIGHT, y, "grid"))
        parts.append(text(_LEFT - 8.0, y + 4.5, words, "tick", "end"))
    parts.append(line(_LEFT, _BOTTOM, _RIGHT, _BOTTOM, "base"))
    for count in _apart(counts, across):
        parts.append(line(across(count), _BOTTOM, across(count), _BOTTOM + 5.0, "base"))
        parts.append(text(across(count), _BOTTOM + 20.0, str(count), "tick", "middle"))
    parts.append(text(4.0, 16.0, title, "axis-title"))
    parts.append(text((_LEFT + _RIGHT) / 2.0, _BOTTOM + 44.0, axis, "axis-title", "middle"))
    return parts


def _apart(counts: Sequence[int] | IntArray, across: Scale) -> list[int]:
    """The numbers whose labels do not touch each other."""
    kept: list[int] = []
    for count in reversed([int(c) for c in counts]):
        if not kept or across(kept[-1]) - across(count) >= 22.0:
            kept.append(count)
    return kept
