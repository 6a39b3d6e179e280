"""Labels beside points of a picture, where they cover least.

In: points and words. Out: where the words go [px], and lines to those that had to move away.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import join, line, text

_LETTER, _HEIGHT = 7.4, 15.0  # [px] of the font of 13 px
_RINGS = (15.0, 26.0, 40.0, 58.0)
_ANGLES = np.radians([0, -35, 35, 180, -145, 145, -90, 90])


class Labels:
    """Places words one after the other, and remembers where they are."""

    def __init__(self, width: float, height: float, busy: Array) -> None:
        """Start a picture of a size [px] with points (K, 2) that should stay visible."""
        self._size, self._busy = (width, height), busy
        self._boxes: list[Array] = []

    def place(self, at: Array, words: str, class_: str) -> Markup:
        """`words` near the point `at` (2,) [px]."""
        wide = _LETTER * len(words) + 4.0
        best, cost = None, np.inf
        for ring, radius in enumerate(_RINGS):
            for turn in _ANGLES:
                middle = at + radius * np.array([np.cos(turn), np.sin(turn)])
                middle[0] += np.sign(np.cos(turn)) * (abs(np.cos(turn)) > 0.1) * wide / 2
                half = np.array([wide, _HEIGHT]) / 2
                box = np.array([middle - half, middle + half])
                found = self._cost(box) + 4.0 * ring
                if found < cost - 1e-9:
                    best, cost = (middle, box, radius), found
        assert best is not None
        middle, box, radius = best
        self._boxes.append(box)
        parts: list[Markup] = []
        if radius > _RINGS[0]:
            end = np.clip(at, box[0], box[1])
            parts.append(line(at[0], at[1], end[0], end[1], "leader"))
        parts.append(text(middle[0], middle[1] + 4.5, words, class_, "middle"))
        return join(parts)

    def _cost(self, box: Array) -> float:
        """How much a box covers."""
        outside = np.maximum(0.0, -box[0]).sum() + np.maximum(0.0, box[1] - self._size).sum()
        inside = np.all((self._busy > box[0] - 2.0) & (self._busy < box[1] + 2.0), axis=1).sum()
        over = sum(_overlap(box, other) for other in self._boxes)
        return 50.0 * float(outside) + 3.0 * float(inside) + 0.5 * over


def _overlap(a: Array, b: Array) -> float:
    """Area that two boxes share [px²]."""
    sides: Sequence[float] = np.minimum(a[1], b[1]) - np.maximum(a[0], b[0])
    return float(sides[0] * sides[1]) if min(sides) > 0.0 else 0.0
