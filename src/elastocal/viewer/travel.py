"""Travel: how the view moves from one stop to the next, by the clock.

In: two configurations, seconds. Out: the configuration in between. Joints move together, slow at
both ends, as a robot that goes from point to point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array

SECONDS = 1.4
"""How long a motion is shown."""
PAUSE = 1.6
"""How long a stop is shown while playing [s]."""


@dataclass(frozen=True)
class Travel:
    """A motion between two stops.

    Attributes:
        begin: Configuration (n,) and load (6,) where it begins.
        end: Where it ends.
        since: When it began [s].
        seconds: How long it takes [s].
    """

    begin: tuple[Array, Array]
    end: tuple[Array, Array]
    since: float
    seconds: float = SECONDS

    def at(self, now: float) -> tuple[Array, Array]:
        """Configuration (n,) and load (6,) at a time [s]; its end exactly once it is over."""
        if self.over(now):
            return self.end
        share = float(np.clip((now - self.since) / self.seconds, 0.0, 1.0))
        share = share * share * (3.0 - 2.0 * share)
        q, wrench = (
            (1.0 - share) * a + share * b for a, b in zip(self.begin, self.end, strict=True)
        )
        return q, wrench

    def over(self, now: float) -> bool:
        """Whether it has ended at a time [s]."""
        return now >= self.since + self.seconds
