"""Ordering: the load cases of a plan in the order that takes the least time.

In: load cases, a pace. Out: an order of execution from home to home. Motion is timed by the
slowest joint at full speed; a change of wrench costs what the pace says, so that load cases
of the same wrench come together. Same input, same order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze
from elastocal.elastic.load_cases import LoadCases
from elastocal.motion.pace import Pace

MotionCheck = Callable[[Array, Array], BoolArray]
"""(K, n) starts, (K, n) goals -> (K,) whether the joint motion between them is free."""

EXACT = 9
"""Up to so many load cases the order is the best there is."""
_BLOCKED = 1e9  # [s] a motion that must not be done: never chosen where another way exists


@dataclass(frozen=True)
class Order:
    """An order of execution.

    Attributes:
        sequence: (S,) positions of the load cases, first to last.
        duration: Time of the motions and of the changes of load between load cases [s].
        blocked: Legs of the tour that are not free, as positions from 0 (home to the first load
            case) to S (from the last one home); empty if all are.
    """

    sequence: IntArray
    duration: float
    blocked: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        freeze(self, "sequence", dtype=np.int64)


def travel_times(starts: Array, goals: Array, speed: Array) -> Array:
    """(A, B) seconds from each of (A, n) configurations to each of (B, n), slowest joint first."""
    way = np.abs(starts[:, None, :] - goals[None, :, :])
    return np.asarray((way / speed).max(axis=2, initial=0.0))


def best_order(
    cases: LoadCases,
    pace: Pace,
    *,
    arrivals: Array | None = None,
    free: MotionCheck | None = None,
) -> Order:
    """The order of load cases that takes the least time, starting and ending at home.

    Args:
        cases: S load cases.
        pace: Speeds, home and time of a change of load, one of every joint.
        arrivals: (S, n) points from which each configuration is approached, for the same
            direction every time; the configurations themselves if None.
        free: Says which motions are free; all if None.

    Source: ours; for few load cases Held & Karp 1962, for more 2-opt and Or-opt.
    """
    count = len(cases)
    q = np.vstack([pace.home, cases.q])
    goals = q if arrivals is None else np.vstack([pace.home, arrivals])
    cost = travel_times(q, goals, pace.speed)
    if arrivals is not None:
        last = np.abs(goals - q) / pace.speed
        cost = cost + last.max(axis=1)
    other = np.any(cases.wrench[:, None, :] != cases.wrench[None, :, :], axis=2)
    cost[1:, 1:] += pace.change_load * other
    barred = np.zeros_like(cost, dtype=bool)
    if free is not None:
        i, j = np.nonzero(~np.eye(count + 1, dtype=bool))
        barred[i, j] = ~free(q[i], goals[j])
    tour = shortest_tour(cost + _BLOCKED * barred)
    legs = np.concatenate([[0], tour, [0]])
    pairs = legs[:-1], legs[1:]
    return Order(
        sequence=tour - 1,
        duration=float(cost[pairs].sum()),
        blocked=tuple(int(k) for k in np.flatnonzero(barred[pairs])),
    )


def shortest_tour(cost: Array) -> IntArray:
    """(S,) order of the places 1 to S on the shortest tour from place 0 and back to it.

    Args:
        cost: (S + 1, S + 1) cost from place to place; need not be symmetric.
    """
    count = len(cost) - 1
    if count <= 1:
        return np.arange(1, count + 1)
    if count <= EXACT:
        return _exact(cost)
    return min((_improved(cost, tour) for tour in _starts(cost)), key=lambda t: _length(cost, t))


def _length(cost: Array, tour: IntArray) -> float:
    legs = np.concatenate([[0], tour, [0]])
    return float(cost[legs[:-1], legs[1:]].sum())


def _exact(cost: Array) -> IntArray:
    """Dynamic programming over subsets: the best way through each subset to each of its places."""
    count = len(cost) - 1
    best = np.full((1 << count, count), np.inf)
    before = np.zeros((1 << count, count), dtype=np.int64)
    for j in range(count):
        best[1 << j, j] = cost[0, j + 1]
    inner = cost[1:, 1:]
    for subset in range(1, 1 << count):
        for j in range(count):
            rest = subset & ~(1 << j)
            if rest and rest != subset:
                total = best[rest] + inner[:, j]
                before[subset, j] = int(total.argmin())
                best[subset, j] = total[before[subset, j]]
    subset = (1 << count) - 1
    place = int((best[subset] + cost[1:, 0]).argmin())
    tour = []
    while subset:
        tour.append(place + 1)
        subset, place = subset & ~(1 << place), int(before[subset, place])
    return np.array(tour[::-1])


def _starts(cost: Array) -> list[IntArray]:
    """A few tours to begin with: the nearest place next, from different first places."""
    count = len(cost) - 1
    first = np.argsort(cost[0, 1:], kind="stable") + 1
    chosen = first[np.unique(np.linspace(0, count - 1, 5).astype(int))]
    tours = []
    for place in chosen.tolist():
        tour, left = [place], [j for j in range(1, count + 1) if j != place]
        while left:
            nearest = int(np.argmin(cost[tour[-1], left]))
            tour.append(left.pop(nearest))
        tours.append(np.array(tour))
    return tours


def _improved(cost: Array, tour: IntArray) -> IntArray:
    """2-opt and Or-opt until neither helps: pieces turned round, pieces of up to three moved."""
    length = _length(cost, tour)
    while True:
        candidates = [_turned(tour, i) for i in range(len(tour) - 1)]
        candidates += [_moved(tour, i, k) for k in (1, 2, 3) for i in range(len(tour) - k + 1)]
        best, shortest = tour, length
        for batch in candidates:
            legs = np.pad(batch, ((0, 0), (1, 1)))
            lengths = cost[legs[:, :-1], legs[:, 1:]].sum(axis=1)
            least = int(lengths.argmin())
            if lengths[least] < shortest - 1e-9:
                best, shortest = batch[least], float(lengths[least])
        if best is tour:
            return tour
        tour, length = best, shortest


def _turned(tour: IntArray, i: int) -> IntArray:
    """(K, S) tours with a piece that begins at `i` turned round."""
    ends = range(i + 2, len(tour) + 1)
    return np.array([np.concatenate([tour[:i], tour[i:j][::-1], tour[j:]]) for j in ends])


def _moved(tour: IntArray, i: int, size: int) -> IntArray:
    """(K, S) tours with the `size` places from `i` on put somewhere else, either way round."""
    piece, rest = tour[i : i + size], np.delete(tour, np.arange(i, i + size))
    return np.array(
        [
            np.concatenate([rest[:j], way, rest[j:]])
            for j in range(len(rest) + 1)
            for way in (piece, piece[::-1])
        ]
    )
