"""What of a cell is watched for collisions, told from the constraints that do it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from elastocal.constraints.base import Constraint
from elastocal.constraints.cell import FLOOR, ITSELF
from elastocal.constraints.clearance import Clearance
from elastocal.errors import Doubt


@dataclass(frozen=True)
class Watch:
    """What is watched for collisions, and what is not.

    Attributes:
        watched: What robot and tool keep clear of: "itself", "floor", obstacles.
        unwatched: What of "itself" and "floor" they do not.
        made_do: What stands in for the shapes of the robot.
        doubts: What is watched by half.
    """

    watched: tuple[str, ...]
    unwatched: tuple[str, ...]
    made_do: tuple[Doubt, ...] = ()
    doubts: tuple[Doubt, ...] = ()


def watch_of(constraints: Iterable[Constraint]) -> Watch:
    """What some constraints watch. A clearance without a pair watches nothing."""
    clearances = [c for c in constraints if isinstance(c, Clearance)]
    names = [c.what.casefold() if c.obstacle else c.what for c in clearances if len(c.pairs)]
    doubts = []
    for clearance in clearances:
        always, of = clearance.hardly
        if clearance.what == ITSELF and 2 * always > of:
            doubts.append(Doubt("hardly-watched", numbers={"pairs": always, "of": of}))
    made_do: list[Doubt] = []
    for doubt in (doubt for clearance in clearances for doubt in clearance.made_do):
        known = doubts if doubt.code == "odd-size" else made_do
        known += [] if doubt in known else [doubt]
    watched = tuple(c.what for c in clearances if len(c.pairs))
    unwatched = tuple(name for name in (ITSELF, FLOOR) if name not in names)
    return Watch(watched, unwatched, tuple(made_do), tuple(doubts))
