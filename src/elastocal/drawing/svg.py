"""SVG: elements as safe text, and scales with ticks.

In: numbers and hostile text. Out: `Markup`. Colours and fonts come from the page's style sheet
through classes, so the pictures need no script and print as they look.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup, escape

from elastocal.arrays import Array
from elastocal.wording.numbers import number


def tag(name: str, *children: str, **attributes: str | float) -> Markup:
    """An element; children that are not Markup are escaped, `class_` means class."""
    shown = Markup("").join(
        Markup(' {}="{}"').format(key.rstrip("_").replace("_", "-"), _value(value))
        for key, value in attributes.items()
    )
    inside = join(children)
    return Markup("<{0}{1}>{2}</{0}>").format(Markup(name), shown, inside)


def join(parts: Iterable[str]) -> Markup:
    """Elements one after the other."""
    return Markup("").join(escape(part) for part in parts)


def drawing(width: float, height: float, about: str, *children: str, class_: str = "") -> Markup:
    """A whole picture that scales with its box; `about` is read to those who cannot see it."""
    return tag(
        "svg",
        tag("title", about),
        *children,
        viewBox=f"0 0 {width:.0f} {height:.0f}",
        width=width,
        height=height,
        role="img",
        class_=f"picture {class_}".strip(),
    )


def text(x: float, y: float, words: str, class_: str = "", anchor: str = "start") -> Markup:
    """Words at a point."""
    return tag("text", words, x=x, y=y, class_=class_, text_anchor=anchor)


def line(x1: float, y1: float, x2: float, y2: float, class_: str) -> Markup:
    """A straight line."""
    return tag("line", x1=x1, y1=y1, x2=x2, y2=y2, class_=class_)


def polyline(points: Array, class_: str) -> Markup:
    """A line through points (K, 2)."""
    shown = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return tag("polyline", points=shown, class_=class_)


@dataclass(frozen=True)
class Scale:
    """Values to pixels, linear or logarithmic.

    Attributes:
        low: Value at `start`.
        high: Value at `end`.
        start: Pixel of `low`.
        end: Pixel of `high`.
        log: Whether equal ratios have equal distances.
    """

    low: float
    high: float
    start: float
    end: float
    log: bool = False

    def __call__(self, value: float) -> float:
        """Pixel of a value."""
        low, high = self.low, self.high
        if self.log:
            low, high, value = np.log(low), np.log(high), np.log(value)
        return float(self.start + (self.end - self.start) * (value - low) / (high - low))

    def ticks(self, most: int = 6) -> list[float]:
        """Round values to write at the axis."""
        if self.log:
            found = _log_ticks(self.low, self.high)
            if len(found) >= 3:
                return found[:: int(np.ceil(len(found) / most))]
        return _linear_ticks(self.low, self.high, most)


def tick_labels(ticks: list[float]) -> list[str]:
    """Ticks as text with the digits they need."""
    return [
        number(tick, 3).rstrip("0").rstrip(".")
        if _fraction(tick)
        else number(tick, 6).split(".")[0]
        for tick in ticks
    ]


def _fraction(value: float) -> bool:
    return abs(value - round(value)) > 1e-9


def _linear_ticks(low: float, high: float, most: int) -> list[float]:
    rough = (high - low) / most
    power = 10.0 ** np.floor(np.log10(rough))
    step = next(s * power for s in (1.0, 2.0, 5.0, 10.0) if s * power >= rough * (1 - 1e-9))
    first = int(np.ceil(low / step - 1e-9))
    last = int(np.floor(high / step + 1e-9))
    return [round(i * step, 12) for i in range(first, last + 1)]


def _log_ticks(low: float, high: float) -> list[float]:
    """Round values, three powers of ten or more, else four values or more."""
    powers = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    found: list[float] = []
    tens = [10.0**p for p in powers if low * (1 - 1e-9) <= 10.0**p <= high * (1 + 1e-9)]
    if len(tens) >= 3:
        return tens
    for steps in ((1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)):
        values = [step * 10.0**power for power in powers for step in steps]
        found = [v for v in values if low * (1 - 1e-9) <= v <= high * (1 + 1e-9)]
        if len(found) >= 4:
            break
    return found


def _value(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.2f}".rstrip("0").rstrip(".")
