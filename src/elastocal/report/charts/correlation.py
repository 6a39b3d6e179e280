"""Correlation map, and the combinations that the readings see worst.

In: correlation, combinations. Out: SVG, readable in grey: size by lightness, sign by the number.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.report.charts.axes import cut, width_of
from elastocal.wording.numbers import fixed, number

_BLUE, _ORANGE, _WHITE = (29, 95, 168), (200, 80, 10), (255, 255, 255)
_MOST_NUMBERS = 9  # springs up to which numbers fit into the cells


def correlation_chart(correlation: Array, names: Sequence[str], width: float = 400.0) -> Markup:
    """Lower triangle of correlations (p, p), with numbers where they fit."""
    p = len(names)
    shown = [cut(name, 10) for name in names]
    left = 14.0 + max(width_of(name) for name in shown)
    cell = min((width - left - 8.0) / p, 58.0)
    parts: list[Markup] = []
    for i in range(p):
        y = 6.0 + i * cell
        parts.append(text(left - 8.0, y + cell / 2.0 + 4.5, shown[i], "lane strong", "end"))
        for j in range(i + 1):
            r = 1.0 if i == j else float(correlation[i, j])
            colour = "#e9edf2" if i == j else _colour(r)
            x = left + j * cell
            parts.append(
                tag("rect", x=x, y=y, width=cell - 1.5, height=cell - 1.5, rx=3.0, fill=colour)
            )
            if p <= _MOST_NUMBERS:
                on = "on-dark" if abs(r) > 0.55 and i != j else "on-light"
                words = "1" if i == j else _short(r)
                size = "small" if cell < 40.0 else ""
                at = x + (cell - 1.5) / 2.0, y + cell / 2.0 + 4.0
                parts.append(text(*at, words, f"{on} {size}".strip(), "middle"))
    bottom = 6.0 + p * cell + 14.0
    for j in range(p):
        x = left + j * cell + cell / 2.0
        fits = max(width_of(name) for name in shown) <= cell
        if fits:
            parts.append(text(x, bottom, shown[j], "lane strong", "middle"))
        else:
            turned = tag(
                "text",
                shown[j],
                x=x,
                y=bottom - 8.0,
                class_="lane strong",
                text_anchor="end",
                transform=f"rotate(-45 {x:.1f} {bottom - 8.0:.1f})",
            )
            parts.append(turned)
    if max(width_of(name) for name in shown) > cell:
        bottom += 0.75 * max(width_of(name) for name in shown)
    about = "Correlations of the estimated compliances"
    return drawing(width, bottom + 8.0, about, *parts, class_="chart")


def combinations_chart(
    combinations: Array, seen: Array, names: Sequence[str], width: float = 400.0
) -> Markup:
    """Bars of the combinations that are seen worst.

    Args:
        combinations: (K, p) unit combinations, worst first.
        seen: (K,) how well each is seen, over the one seen best.
        names: Names of the p springs.
        width: Width of the picture [px].
    """
    shown = [cut(name, 10) for name in names]
    left = 14.0 + max(width_of(name) for name in shown)
    lane = 19.0
    parts: list[Markup] = []
    y = 16.0
    for k, (row, share) in enumerate(zip(combinations, seen, strict=True)):
        row = row * np.sign(row[np.argmax(np.abs(row))])
        parts.append(text(4.0, y, _said(k, float(share)), "note"))
        scale = Scale(-1.0, 1.0, left, width - 44.0)
        bottom = y + 10.0 + lane * len(names)
        for i, (name, value) in enumerate(zip(shown, row, strict=True)):
            middle = y + 10.0 + lane * (i + 0.5)
            a, b = sorted((scale(0.0), scale(float(value))))
            class_ = "bar-positive" if value > 0 else "bar-negative"
            strong = "lane strong" if abs(value) > 0.3 else "lane"
            parts.append(text(left - 8.0, middle + 4.5, name, strong, "end"))
            parts.append(
                tag("rect", x=a, y=middle - 6.0, width=max(b - a, 0.5), height=12.0, class_=class_)
            )
            beside = b + 6.0 if value > 0 else a - 6.0
            anchor = "start" if value > 0 else "end"
            if abs(value) >= 0.005:
                parts.append(text(beside, middle + 4.0, _short(float(value)), "tick", anchor))
        parts.append(line(scale(0.0), y + 8.0, scale(0.0), bottom, "zero"))
        y = bottom + 26.0
    about = "Combinations of compliances that the readings see worst"
    return drawing(width, y - 12.0, about, *parts, class_="chart")


def _said(rank: int, share: float) -> str:
    first = ("Seen worst", "Seen second worst", "Seen third worst")[rank]
    if share <= 0.0:
        return f"{first}: not at all"
    return f"{first}: 1/{number(1.0 / share, 2)} as well as the best"


def _colour(r: float) -> str:
    """White at zero; blue for positive, orange for negative, darker with size."""
    end = _BLUE if r > 0 else _ORANGE
    t = min(abs(r), 1.0)
    mixed = [round(w + t * (e - w)) for w, e in zip(_WHITE, end, strict=True)]
    return "#" + "".join(f"{c:02x}" for c in mixed)


def _short(r: float) -> str:
    decimals = 3 if abs(r) >= 0.995 else 2
    return fixed(r, decimals)
