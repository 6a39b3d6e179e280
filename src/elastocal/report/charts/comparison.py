"""Picture of ρ0 on one logarithmic axis: random plans, other plans, this plan, the bound.

In: errors [m]. Out: SVG. Drawn once for wide and once for narrow screens, because letters must
not shrink with the picture.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, tag, text, tick_labels
from elastocal.wording.numbers import length, length_unit, number

_HISTOGRAM, _LANE, _BINS = 84.0, 46.0, 34


def comparison_chart(
    rho0: float,
    bound: float | None,
    random: Array | None,
    others: Mapping[str, float],
    width: float,
) -> Markup:
    """The plan among what it is compared with.

    Args:
        rho0: Error of this plan [m].
        bound: No plan has a smaller one [m]; None if unknown.
        random: (K,) errors of random plans [m].
        others: Errors of other plans by name [m].
        width: Width of the picture [px].
    """
    drawn = np.array([]) if random is None else random[np.isfinite(random)]
    shown = [rho0, *others.values(), *([bound] if bound else [])]
    values = [value for value in shown if np.isfinite(value) and value > 0.0]
    values += [float(np.quantile(drawn, 0.99))] if len(drawn) else []
    factor, unit = length_unit(values)
    low, high = factor * min(values) / 1.12, factor * max(values) * 1.15
    narrow = width < 500.0
    left = 10.0 if narrow else 170.0
    scale = Scale(low, max(high, 1.6 * low), left, width - (14.0 if narrow else 30.0), log=True)
    lanes = _Lanes(scale, factor, narrow, top=34.0 if bound else 8.0)
    if len(drawn):
        lanes.histogram(drawn, f"{len(drawn)} random plans")
    for name, value in others.items():
        lanes.plan(name, value, "other")
    lanes.plan("this plan", rho0, "own")
    parts = _frame(scale, lanes, unit, width)
    if bound:
        parts = _out_of_reach(scale, lanes, factor * bound, left, unit) + parts
    about = f"Root mean square position error: this plan {length(rho0)}"
    about += f", lower bound {length(bound)}" if bound else ""
    return drawing(width, lanes.y + 52.0, about, *parts, *lanes.parts, class_="chart")


class _Lanes:
    """Rows of the picture, filled from the top."""

    def __init__(self, scale: Scale, factor: float, narrow: bool, top: float) -> None:
        self.scale, self.factor, self.narrow, self.top, self.y = scale, factor, narrow, top, top
        self.parts: list[Markup] = []

    def _words(self, words: str, x: float, y: float, class_: str) -> None:
        """Words over a mark at `x`, kept inside the picture."""
        half = 3.6 * len(words)
        x = min(max(x, self.scale.start + half), self.scale.end - half)
        self.parts.append(text(x, y, words, class_, "middle"))

    def _name(self, words: str, y: float, class_: str) -> None:
        """Name of a lane, left of it."""
        self.parts.append(text(self.scale.start - 14.0, y + 4.5, words, class_, "end"))

    def histogram(self, values: Array, name: str) -> None:
        """How many values fall where; what lies beyond the axis is counted in the last bar."""
        edges = np.geomspace(self.scale.low, self.scale.high, _BINS + 1)
        clipped = np.clip(self.factor * values, edges[0], edges[-1])
        counts, _ = np.histogram(clipped, edges)
        floor = self.y + _HISTOGRAM
        for count, a, b in zip(counts, edges[:-1], edges[1:], strict=True):
            if count:
                x, height = self.scale(a), (_HISTOGRAM - 20.0) * count / counts.max()
                self.parts.append(
                    tag(
                        "rect",
                        x=x + 0.5,
                        y=floor - height,
                        width=self.scale(b) - x - 1.0,
                        height=height,
                        class_="random",
                    )
                )
        middle = float(np.median(values)) * self.factor
        x = self.scale(min(middle, self.scale.high))
        self.parts.append(line(x, self.y + 16.0, x, floor, "median"))
        words = f"median {number(middle)}"
        if self.narrow:
            words = f"{name}, {words}"
        else:
            self._name(name, floor - 0.45 * _HISTOGRAM, "lane")
        self._words(words, x, self.y + 12.0, "note")
        self.parts.append(line(self.scale.start, floor, self.scale.end, floor, "base"))
        self.y = floor + 6.0

    def plan(self, name: str, value: float, class_: str) -> None:
        """One plan as a mark on its line."""
        name = name if len(name) <= 24 else name[:23] + "…"
        middle = self.y + _LANE - 16.0
        finite = bool(np.isfinite(value))
        words = number(self.factor * value) if finite else "does not identify every compliance"
        if self.narrow:
            words = f"{name}: {words}" if finite else f"{name}: not identifiable"
        else:
            self._name(name, middle, f"lane {class_}")
        self.parts.append(line(self.scale.start, middle, self.scale.end, middle, "track"))
        x = self.scale(self.factor * value) if finite else self.scale.end
        if finite:
            r = 8.0 if class_ == "own" else 6.0
            corners = f"{x},{middle - r} {x + r},{middle} {x},{middle + r} {x - r},{middle}"
            self.parts.append(tag("polygon", points=corners, class_=f"mark {class_}"))
        beside = 5.0 if self.narrow else 12.0 + 3.6 * len(words)
        self._words(words, x + beside, middle - (11.0 if self.narrow else 5.0), f"value {class_}")
        self.y += _LANE


def _frame(scale: Scale, lanes: _Lanes, unit: str, width: float) -> list[Markup]:
    """Axis with ticks below the lanes."""
    y = lanes.y + 2.0
    parts = []
    ticks = scale.ticks(5 if lanes.narrow else 9)
    for tick, words in zip(ticks, tick_labels(ticks), strict=True):
        x = scale(tick)
        parts.append(line(x, lanes.top, x, y, "grid"))
        parts.append(text(x, y + 16.0, words, "tick", "middle"))
    name = f"ρ₀ [{unit}], logarithmic; smaller is better"
    parts.append(text((scale.start + scale.end) / 2.0, y + 38.0, name, "axis-title", "middle"))
    return parts


def _out_of_reach(
    scale: Scale, lanes: _Lanes, bound: float, left: float, unit: str
) -> list[Markup]:
    """The region no plan can enter, and its edge."""
    x, top, bottom = scale(bound), 26.0, lanes.y + 2.0
    words = f"lower bound {number(bound)} {unit}"
    fits = x + 6.0 + 8.0 * len(words) < scale.end
    return [
        tag("rect", x=left, y=top, width=max(x - left, 0.0), height=bottom - top, class_="barred"),
        line(x, top - 8.0, x, bottom, "bound"),
        text(x + 6.0 if fits else x - 6.0, 20.0, words, "bound-name", "start" if fits else "end"),
    ]
