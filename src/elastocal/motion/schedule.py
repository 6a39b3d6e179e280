"""Schedule: how many hours a plan takes at the cell.

In: load cases in order of execution, repeats, a pace. Out: times of moving, measuring and
changing loads, for every stop. An estimate for planning, not a promise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, IntArray, freeze
from elastocal.elastic.load_cases import LoadCases
from elastocal.motion.margins import Vias, legs_of
from elastocal.motion.pace import Pace
from elastocal.motion.tour import best_order, travel_times


@dataclass(frozen=True)
class Schedule:
    """Times of a campaign [s]; S stops, one for each load case, in order of execution.

    Attributes:
        moving: (S,) motion to each stop and the rest after it.
        changing: (S,) change of load there.
        measuring: (S,) all repeats there.
        homing: Motion home after the last stop.
    """

    moving: Array
    changing: Array
    measuring: Array
    homing: float

    def __post_init__(self) -> None:
        freeze(self, "moving", "changing", "measuring")

    @property
    def each(self) -> Array:
        """(S,) all that is done for each stop [s]."""
        return np.asarray(self.moving + self.changing + self.measuring)

    @property
    def ends(self) -> Array:
        """(S,) when each stop is done, from the start [s]."""
        return np.asarray(np.cumsum(self.each))

    @property
    def total(self) -> float:
        """From home to home [s]."""
        return float(self.each.sum()) + self.homing

    @property
    def minutes(self) -> dict[str, float]:
        """What is done for how long [min]: measuring, moving, changing loads."""
        seconds = {
            "measuring": float(self.measuring.sum()),
            "moving": float(self.moving.sum()) + self.homing,
            "changing loads": float(self.changing.sum()),
        }
        return {what: value / 60.0 for what, value in seconds.items()}

    @property
    def hours(self) -> float:
        """From home to home [h]."""
        return self.total / 3600.0


def fastest(cases: LoadCases, repeats: IntArray, pace: Pace) -> Schedule:
    """Times of a campaign that executes S load cases in their best order; see `schedule`."""
    order = best_order(cases, pace).sequence
    return schedule(cases.chosen(order), np.asarray(repeats)[order], pace)


def schedule(cases: LoadCases, repeats: IntArray, pace: Pace, via: Vias = ()) -> Schedule:
    """Times of a campaign that executes `cases` in this order.

    The first load is put on before the first stop: that is a change of load, too.

    Args:
        cases: S load cases in order of execution.
        repeats: (S,) how often each is measured.
        pace: Speeds and times, with a value for every joint.
        via: S + 1 arrays (K, n) of configurations passed on the way; none if empty.
    """
    count = len(cases)
    ways = legs_of(pace.home, cases.q, via)
    legs = np.array(
        [np.diagonal(travel_times(way[:-1], way[1:], pace.speed)).sum() for way in ways]
    )
    changed = np.ones(count, dtype=bool)
    changed[1:] = np.any(cases.wrench[1:] != cases.wrench[:-1], axis=1)
    return Schedule(
        moving=legs[:-1] + pace.settle,
        changing=pace.change_load * changed,
        measuring=pace.measure * np.asarray(repeats, dtype=float),
        homing=float(legs[-1]),
    )
