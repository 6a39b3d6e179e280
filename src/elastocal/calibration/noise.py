"""How far readings scatter: the instrument's part, which is given, and the model's, which is found.

What an arm does that no unknown of the model makes looks like noise of each pose. Part of it all
reflectors of a pose share, part each has of its own; both are found from what the fit leaves, for
every station.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray, freeze
from elastocal.measuring.positions import Positions


@dataclass(frozen=True)
class Noise:
    """Noise of R readings.

    Attributes:
        positions: The readings, with the covariance that their instrument has.
        shared: (S,) standard deviation of a coordinate that the model's error gives to all
            reflectors of a pose [m], by station.
        own: (S,) the same of each reflector by itself [m].
        turned: (S,) of each component of a rotation [rad].
        weight: (R,) how much each reading counts: 1, but for robust losses.
    """

    positions: Positions
    shared: Array
    own: Array
    turned: Array
    weight: Array

    def __post_init__(self) -> None:
        freeze(self, "shared", "own", "turned", "weight")

    def over(self, rows: Array) -> Array:
        """(R, 3, m) rows of the readings in units of their noise, and independent."""
        result = np.empty_like(rows)
        for _, r in self.positions.by_size():
            n, k = r.shape
            root = np.linalg.cholesky(self._covariance(r))
            part = rows[r].reshape(n, 3 * k, -1)
            result[r] = np.linalg.solve(root, part).reshape(n, k, 3, -1)
        return result * np.sqrt(self.weight)[:, None, None]

    def _covariance(self, r: IntArray) -> Array:
        """(n, 3k, 3k) of the readings (n, k) of poses."""
        p, k = self.positions, r.shape[1]
        station, turns = p.station[r], p.rotations[r]
        each = np.where(turns, self.turned[station], self.own[station]) ** 2
        whole = np.zeros((len(r), k, 3, k, 3))
        for i in range(k):
            whole[:, i, :, i] = p.covariance[r[:, i]] + each[:, i, None, None] * np.eye(3)
            for j in range(k):
                both = (station[:, i] == station[:, j]) & ~turns[:, i] & ~turns[:, j]
                share = np.where(both, self.shared[station[:, i]] ** 2, 0.0)
                whole[:, i, :, j] += share[:, None, None] * np.eye(3)
        return np.asarray(whole.reshape(len(r), 3 * k, 3 * k))


def instrument_alone(positions: Positions) -> Noise:
    """The noise that the instrument has, as if the model had no error."""
    zero = np.zeros(len(positions.stations))
    return Noise(positions, zero, zero, zero, np.ones(len(positions)))


def found_noise(noise: Noise, error: Array, told: float, spread: Array | None = None) -> Noise:
    """The noise that errors (R, 3) of a fit have, which knows `told` combinations from them.

    Args:
        noise: The noise with which was fitted.
        error: (R, 3) errors of the fit [m, rad].
        told: How many numbers the fit took from the readings.
        spread: (R, 3, U) a root of the covariance of what the fit says of the readings [m, rad]:
            what reflectors of a pose have in common it takes from otherwise than what each has.

    Source: ours; moments of what reflectors of a pose have in common, and do not. Errors of a fit
    have the covariance of the readings less that of the fit.
    """
    p, stations = noise.positions, len(noise.positions.stations)
    free = max(1.0 - told / (3.0 * len(p)), 1.0 / (3.0 * len(p)))
    own, shared, turned = (np.zeros(stations) for _ in range(3))
    for s in range(stations):
        mine = p.station == s
        turned[s] = _beyond(error, p.covariance, mine & p.rotations, free)
        at = mine & ~p.rotations
        size = np.bincount(p.case[at], minlength=len(p.cases))
        several = size[p.case] > 1
        if not (at & several).any():
            own[s] = _beyond(error, p.covariance, at, free)
            continue
        r = np.flatnonzero(at & several)
        k, poses = size[p.case[r]], int((size > 1).sum())
        each = np.einsum("rii->r", p.covariance[r])
        within, between = _apart(error[r], p.case[r], size)
        inner, noisy = 3.0 * (len(r) - poses), float((each * (1.0 - 1.0 / k)).sum())
        outer, mixed = 3.0 * float((1.0 / size[size > 1]).sum()), float((each / k**2).sum())
        free_within = free_between = free
        if spread is not None:
            taken = _apart(spread[r].reshape(len(r), -1), p.case[r], size)
            before = noisy + inner * noise.own[s] ** 2
            free_within = max(1.0 - taken[0] / before, 1.0 / inner)
            before = mixed + outer * noise.own[s] ** 2 + 3.0 * poses * noise.shared[s] ** 2
            free_between = max(1.0 - taken[1] / before, 1.0 / (3.0 * poses))
        own[s] = np.sqrt(max(within / free_within - noisy, 0.0) / inner)
        told_of = mixed + outer * own[s] ** 2
        shared[s] = np.sqrt(max(between / free_between - told_of, 0.0) / (3.0 * poses))
    return replace(noise, own=own, shared=shared, turned=turned)


def _apart(values: Array, case: IntArray, size: IntArray) -> tuple[float, float]:
    """Squares of values (r, m) about their means by pose, and of the means."""
    sums = np.zeros((len(size), values.shape[1]))
    np.add.at(sums, case, values)
    mean = sums / np.maximum(size, 1)[:, None]
    return float(((values - mean[case]) ** 2).sum()), float((mean[size > 1] ** 2).sum())


def _beyond(error: Array, covariance: Array, mine: BoolArray, free: float) -> float:
    """Standard deviation that errors have beyond their covariance, each by itself.

    Source: ours; the one at which the sum of squares over the noise is what it should be.
    """
    if not mine.any():
        return 0.0
    values, vectors = np.linalg.eigh(covariance[mine])
    squares = np.einsum("rij,ri->rj", vectors, error[mine]) ** 2
    wanted = 3.0 * free * float(mine.sum())

    def open_(variance: float) -> float:
        return float((squares / (values + variance)).sum()) - wanted

    if open_(0.0) <= 0.0:
        return 0.0
    low, high = 0.0, float(squares.sum()) / wanted
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if open_(middle) > 0.0 else (low, middle)
    return float(np.sqrt(high))
