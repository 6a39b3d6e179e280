"""Room between solids: of the robot from an obstacle, and between parts of the robot itself."""

from __future__ import annotations

from copy import copy

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.base import Constraint, Pull
from elastocal.constraints.collision.contacts import Unwatched
from elastocal.constraints.collision.distance import NearestPairs, Pairs, nearest
from elastocal.errors import Doubt
from elastocal.robot.posture import Posture
from elastocal.robot.shapes import Shape
from elastocal.wording.numbers import bounded

PLENTY = 0.05
"""Margins above this [m] are not measured while planning: they are said to be this."""


class Clearance(Constraint):
    """Signed distance of the nearest of some pairs of solids, less a margin [m].

    Negative where solids overlap: then the distance is minus the depth of penetration. Where two
    pairs are equally near the margin has a kink, as has every distance where the nearest points
    jump.
    """

    costly = True

    def __init__(
        self,
        name: str,
        pairs: Pairs,
        margin: float,
        *,
        motion_margin: float | None = None,
        obstacle: Shape | None = None,
        height: float | None = None,
        unwatched: tuple[Unwatched, ...] = (),
        made_do: tuple[Doubt, ...] = (),
    ) -> None:
        """Watch some pairs of solids.

        Args:
            name: What is kept apart: "table", or "itself" for the robot.
            pairs: The pairs.
            margin: Distance to keep at the poses of a plan [m].
            motion_margin: Distance to keep while moving between them [m]; half of `margin` if
                not given, so that a pose at its margin can be left in any direction.
            obstacle: The obstacle in the base frame; None for the robot itself and for the floor.
            height: Of the floor in the base frame [m]; None if it is not the floor.
            unwatched: What is not watched, and why.
            made_do: What stands in for the shapes of the robot.
        """
        self.what, self.unit = name, "m"
        self.pairs, self.keep = pairs, margin
        self.keep_moving = margin / 2.0 if motion_margin is None else motion_margin
        self.obstacle, self.height = obstacle, height
        self.unwatched, self.made_do = unwatched, made_do
        self.one_by_one = not pairs.closed
        self.name = bounded(f"clearance from {name}", ">=", margin, "m")

    @property
    def on_the_way(self) -> Clearance:
        """The same clearance with what is to be kept while moving."""
        passing = copy(self)
        passing.keep = self.keep_moving
        passing.name = bounded(f"clearance from {self.what}", ">=", passing.keep, "m")
        return passing

    @property
    def hardly(self) -> tuple[int, int]:
        """How many pairs of parts always touch and are not watched, and of how many.

        Neighbours are not counted: they are made to touch.
        """
        always = sum(left.why.startswith("always") for left in self.unwatched)
        pairs = [self.pairs.of(pair) for pair in range(len(self.pairs))]
        watched = {(a.name, b.name) for a, b in pairs if abs(a.body - b.body) > 1}
        return always, always + len(watched)

    def at(self, posture: Posture) -> tuple[Array, Pull]:
        found = nearest(self.pairs, posture, self.keep + PLENTY)

        def pull(weights: Array) -> Array:
            return self._gradient(posture, found, weights)

        return found.distance - self.keep, pull

    def room(self, posture: Posture) -> Array:
        return nearest(self.pairs, posture, np.inf).distance - self.keep

    def names_at(self, posture: Posture) -> list[str]:
        found = nearest(self.pairs, posture, np.inf)
        return [
            bounded(f"clearance of {self.pair_name(pair)}", ">=", self.keep, "m")
            for pair in found.pair.tolist()
        ]

    def pair_name(self, pair: int) -> str:
        """The two solids of a pair in words: "A4 from table"."""
        if pair < 0:
            return self.what
        first, second = self.pairs.of(pair)
        return f"{first.name} from {second.name}"

    def _gradient(self, posture: Posture, found: NearestPairs, weights: Array) -> Array:
        """(n, N) Σ over both bodies of normal · velocity of the nearest point, times weights.

        The points are held fixed to their bodies: that they slide along the surfaces changes the
        distance to second order only. Source: ours; the rule is an envelope theorem.
        """
        k = np.flatnonzero((weights != 0.0) & (found.pair >= 0))
        normal = found.normal[:, k] * weights[k]
        bodies = [[s.body for s in self.pairs.of(p)] for p in found.pair[k].tolist()]
        first, second = np.array(bodies, dtype=np.int64).reshape(-1, 2).T
        return posture.pull_carried(
            k, (found.first[:, k], first, normal), (found.second[:, k], second, -normal)
        )
