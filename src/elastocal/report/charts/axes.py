"""Axes, legends and names that charts share.

In: scales, words. Out: SVG elements.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, line, tag, text, tick_labels

_LETTER = 7.2  # width of a letter of an ordinary label [px]


def width_of(words: str) -> float:
    """About how wide a label is [px]."""
    return _LETTER * len(words)


def cut(name: str, most: int) -> str:
    """A name of at most `most` letters."""
    return name if len(name) <= most else name[: most - 1] + "…"


def shortened(names: Sequence[str], most: int) -> list[str]:
    """Names of at most `most` letters; what all of them begin with gives way first."""
    if max((len(name) for name in names), default=0) > most:
        shared = _shared(names) if len(names) > 1 else 0
        if shared > 2:
            names = [f"…{name[shared:]}" for name in names]
    return [cut(name, most) for name in names]


def _shared(names: Sequence[str]) -> int:
    """How many letters all names begin with."""
    first, last = min(names), max(names)  # the two that differ soonest
    for k, (a, b) in enumerate(zip(first, last, strict=False)):
        if a != b:
            return k
    return 0


def axis_below(
    scale: Scale, top: float, bottom: float, title: str, most: int = 6, *, last: bool = True
) -> list[Markup]:
    """Upright grid lines, and below them values and title; only the lines unless `last`."""
    parts, ticks = [], scale.ticks(most)
    for tick, words in zip(ticks, tick_labels(ticks), strict=True):
        x = scale(tick)
        parts.append(line(x, top, x, bottom, "grid"))
        if last:
            parts.append(text(x, bottom + 16.0, words, "tick", "middle"))
    if last and title:
        middle = (scale.start + scale.end) / 2.0
        parts.append(text(middle, bottom + 36.0, title, "axis-title", "middle"))
    return parts


def axis_left(
    scale: Scale, left: float, right: float, title: str = "", most: int = 5
) -> list[Markup]:
    """Level grid lines with their values on the left, and the title over them."""
    parts, ticks = [], scale.ticks(most)
    for tick, words in zip(ticks, tick_labels(ticks), strict=True):
        y = scale(tick)
        parts.append(line(left, y, right, y, "grid"))
        parts.append(text(left - 8.0, y + 4.5, words, "tick", "end"))
    if title:
        top = min(scale.start, scale.end)
        parts.append(text(4.0, top - 12.0, title, "axis-title"))
    return parts


def names_below(
    places: Sequence[float], names: Sequence[str], y: float, most: int = 9
) -> list[Markup]:
    """Names under places [px], as many as fit without touching."""
    shown = shortened(names, most)
    parts: list[Markup] = []
    edge = -np.inf
    for x, words in zip(places, shown, strict=True):
        half = 0.5 * width_of(words)
        if x - half >= edge + 6.0:
            parts.append(text(x, y, words, "tick", "middle"))
            edge = x + half
    return parts


def legend(items: Sequence[tuple[str, str]], left: float, top: float, right: float) -> list[Markup]:
    """Signs with their words, in as many lines as they need; items are (sign, words)."""
    parts: list[Markup] = []
    x, y = left, top
    for kind, words in items:
        width = 24.0 + width_of(words) + 16.0
        if x > left and x + width > right + 16.0:
            x, y = left, y + 20.0
        parts += [sign(kind, x + 9.0, y), text(x + 24.0, y + 4.5, words, "note")]
        x += width
    return parts


def legend_height(items: Sequence[tuple[str, str]], left: float, right: float) -> float:
    """Height of `legend` [px]."""
    x, lines = left, 1
    for _, words in items:
        width = 24.0 + width_of(words) + 16.0
        if x > left and x + width > right + 16.0:
            x, lines = left, lines + 1
        x += width
    return 20.0 * lines


def sign(kind: str, x: float, y: float) -> Markup:
    """A mark: dot, ring, diamond, cross, square, tick, bar, dash, line or band."""
    if kind in ("bar", "line", "dash"):
        return line(x - 9.0, y, x + 9.0, y, {"bar": "interval"}.get(kind, f"curve {kind}"))
    if kind.startswith("line-"):
        return line(x - 9.0, y, x + 9.0, y, f"curve {kind[5:]}")
    if kind == "band":
        return tag("rect", x=x - 9.0, y=y - 6.0, width=18.0, height=12.0, class_="band")
    if kind.startswith("box-"):
        return tag("rect", x=x - 9.0, y=y - 6.0, width=18.0, height=12.0, class_=kind[4:])
    if kind == "tick":
        return line(x, y - 7.0, x, y + 7.0, "linear")
    if kind in ("dot", "ring", "far"):
        return tag("circle", cx=x, cy=y, r=4.0, class_=kind)
    return tag("polygon", points=corners(kind, x, y, 5.5), class_=f"mark {kind}")


def corners(kind: str, x: float, y: float, r: float) -> str:
    """Corners of a diamond, square or triangle."""
    angles = {"square": 4, "diamond": 4, "triangle": 3}[kind]
    start = np.pi / 4 if kind == "square" else -np.pi / 2
    turn = start + 2.0 * np.pi * np.arange(angles) / angles
    return " ".join(
        f"{a:.1f},{b:.1f}" for a, b in zip(x + r * np.cos(turn), y + r * np.sin(turn), strict=True)
    )


def named_points(
    points: Array, names: Sequence[str], scale: Scale, rise: Scale, radius: Array
) -> list[Markup]:
    """Names beside points (K, 2) of radii (K,) [px], first come first served, none over another."""
    taken: list[tuple[float, float, float]] = []
    parts: list[Markup] = []
    for (x, y), words, r in zip(points, shortened(names, 14), radius, strict=True):
        wide = width_of(words)
        left = x + r + 5.0 + wide > max(scale.start, scale.end)
        begin = x - r - 5.0 - wide if left else x + r + 5.0
        for shift in (4.5, -8.0, 17.0):
            level = y + shift
            free = all(
                abs(level - b) >= 13.0 or begin > a + w + 6.0 or begin + wide + 6.0 < a
                for a, b, w in taken
            )
            inside = min(rise.start, rise.end) - 6.0 < level < max(rise.start, rise.end) - 2.0
            if free and inside:
                parts.append(text(begin, level, words, "value"))
                taken.append((begin, level, wide))
                break
    return parts
