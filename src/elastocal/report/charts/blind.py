"""Blind errors: what each effect leaves at the task if the readings do not show it.

In: effects, what the plan claims. Out: SVG, a lane for each effect on one logarithmic axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.report.charts.axes import axis_below, cut, legend, legend_height, width_of
from elastocal.wording.numbers import length, length_unit

_LANE = 38.0
_LEAST = 1e-3  # of the largest error: less is not drawn


@dataclass(frozen=True)
class BlindLane:
    """One effect.

    Attributes:
        name: What it is.
        size: How large it is taken, in words.
        seen: Sign of how often a test sees it: "far" never, "ring" seldom, "dot" half of the time.
        error: What it leaves [m].
    """

    name: str
    size: str
    seen: str
    error: float


SIGNS = {
    "far": "never seen",
    "ring": "seen in less than half of all campaigns",
    "dot": "seen in half of them",
}


def blind_chart(lanes: Sequence[BlindLane], claim: float, width: float) -> Markup:
    """Lanes in the order given, and a line at the error that is claimed.

    Args:
        lanes: The effects.
        claim: What the plan claims to leave [m].
        width: Width of the picture [px].
    """
    narrow = width < 500.0
    errors = [lane.error for lane in lanes]
    factor, unit = length_unit(errors)
    low = max(min(*errors, claim), _LEAST * max(errors))
    left, right = 6.0, width - 14.0
    scale = Scale(0.7 * factor * low, 1.3 * factor * max(*errors, claim), left, right, log=True)
    items = [(sign, words) for sign, words in SIGNS.items() if any(o.seen == sign for o in lanes)]
    top = 34.0 + legend_height(items, left, right)
    bottom = top + _LANE * len(lanes) + 6.0
    parts = [*legend(items, left, 10.0, right), *axis_below(scale, top, bottom, "", 5)]
    at = scale(max(factor * claim, scale.low))
    words = f"this plan claims {length(claim)}"
    fits = at + 6.0 + width_of(words) < right
    parts.append(line(at, top - 8.0, at, bottom, "bound"))
    begin = at + 6.0 if fits else at - 6.0
    parts.append(text(begin, top - 12.0, words, "bound-name", "start" if fits else "end"))
    for i, lane in enumerate(lanes):
        parts += _lane(lane, scale, factor, top + _LANE * i, narrow)
    title = f"left at the test poses [{unit}], logarithmic"
    parts.append(text(0.5 * (left + right), bottom + 38.0, title, "axis-title", "middle"))
    about = "What each effect leaves at the test poses if the readings do not show it"
    return drawing(width, bottom + 46.0, about, *parts, class_="chart")


def _lane(lane: BlindLane, scale: Scale, factor: float, top: float, narrow: bool) -> list[Markup]:
    """Name and size over a rod that ends in the sign; the error beside it."""
    y, x = top + 28.0, scale(max(factor * lane.error, scale.low))
    said = length(lane.error)
    over = x + 12.0 + width_of(said) > scale.end
    name = cut(lane.name, 46) if narrow else f"{lane.name}, {lane.size}"
    return [
        text(scale.start, top + 15.0, name, "value other"),
        line(scale.start, y, x, y, "rod worse" if lane.seen == "far" else "rod"),
        tag("circle", cx=x, cy=y, r=5.0, class_=lane.seen),
        text(x - 10.0 if over else x + 10.0, y + 4.5, said, "value", "end" if over else "start"),
    ]
