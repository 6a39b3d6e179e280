"""Travel: how the view moves from one stop to the next, by the clock.

In: two configurations, seconds. Out: the configuration in between. Joints move together, slow at
both ends, as a robot that goes from point to point.
"""

from __future__ import annotations

from dataclasses import dataclass

from elastocal.arrays import Array

SECONDS = 1.4
"""How long a motion is shown."""
PAUSE = 1.6
"""How long a stop is shown while playing [s]."""


@dataclass(frozen=True)
class Travel:
    """A motion between two stops.

    Attributes:
        path: (K, n) configurations from its begin to its end [rad or m], straight in between.
        loads: (2, 6) load at its begin and at its end [N, N·m].
        since: When it began [s].
    """

    path: Array
    loads: Array
    since: float

    @property
    def ends(self) -> float:
        """When it is over [s]; every piece of it takes the same time."""
        return self.since + SECONDS * (len(self.path) - 1)

    def at(self, now: float) -> tuple[Array, Array]:
        """Configuration (n,) and load (6,) at a time [s]; its end exactly once it is over."""
        if now >= self.ends:
            return self.path[-1], self.loads[1]
        gone = max((now - self.since) / SECONDS, 0.0)
        piece = int(gone)
        share = _eased(gone - piece)
        q = (1.0 - share) * self.path[piece] + share * self.path[piece + 1]
        done = _eased(gone / (len(self.path) - 1))
        return q, (1.0 - done) * self.loads[0] + done * self.loads[1]


def _eased(share: float) -> float:
    """A share of the time as a share of the way: slow at both ends."""
    return share * share * (3.0 - 2.0 * share)
