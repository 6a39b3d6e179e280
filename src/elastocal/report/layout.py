"""Layout: what several sections do with pictures."""

from __future__ import annotations

from collections.abc import Callable

from markupsafe import Markup

WIDE, NARROW = 860.0, 350.0


def two_widths(draw: Callable[[float], Markup]) -> Markup:
    """A picture for wide screens and paper, and one for phones: letters must not shrink."""
    return Markup('<div class="wide">{}</div><div class="narrow">{}</div>').format(
        draw(WIDE), draw(NARROW)
    )
