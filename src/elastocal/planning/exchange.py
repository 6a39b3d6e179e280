"""Exchange: load cases of a plan given for others of a pool, as long as that pays.

In: an aim, what is to be held, a pool of load cases that begins with those of a plan, its repeats.
Out: the choice at which no single move gains: all repeats of a load case, or one of them, to
another one. Configurations stay apart, for one that is split in two could be lost as a whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.design.space import information
from elastocal.elastic.load_cases import LoadCases
from elastocal.planning.aim import Aim
from elastocal.planning.blind_sums import BlindSums
from elastocal.planning.near import NEAR, apart, near_configurations

_SWEEPS = 12
_GAIN = 1e-5  # share of what is to fall that a move must gain
_DEAR = 10.0  # how much dearer it is to leave more than a limit
_HOPELESS = 4.0  # how much dearer than now a choice is whose blind error is not worth a look


@dataclass(frozen=True)
class Held:
    """What a choice is to hold, and what is to fall.

    Attributes:
        rho0: Largest ρ0, or promise [m].
        loss: The most that may be left without any configuration [m].
        blind: Largest blind error [m].
        sums: What decides on blind errors; None if they do not count.

    Where ρ0 is limited and not what is to fall, the blind error is, and what is left without a
    configuration if that is not limited.
    """

    rho0: float | None = None
    loss: float | None = None
    blind: float | None = None
    sums: BlindSums | None = None


class Exchanged(NamedTuple):
    """The best choice: points (S, d), (S,) repeats, and what is to fall."""

    x: Array
    counts: IntArray
    cost: float


class Exchange:
    """A pool of load cases, and what choices of them cost."""

    def __init__(self, aim: Aim, pool: LoadCases, held: Held, power: float = np.inf) -> None:
        self._aim, self._held, self._robot = aim, held, aim.space.arm.robot
        self._power = power
        self._pool, self._q, self._x = pool, pool.q, aim.space.points(pool)
        self._known: dict[int, Array] = {}  # what each adds, by how often it is measured
        self._seen: dict[int, Array] = {}  # what each tells of what the model lacks, likewise
        self._scale = 1.0 / np.sqrt(np.diagonal(aim.base + self._of(1).mean(axis=0)) + 1e-300)
        losses = aim.criterion.losses
        assert losses is not None
        self._columns = self._scale[:, None] * np.hstack(losses.roots)

    def exchanged(self, counts: IntArray) -> Exchanged:
        """The best choice; before, the first of the pool have `counts`."""
        chosen = np.zeros(len(self._x), dtype=np.int64)
        chosen[: len(counts)] = counts
        for _ in range(_SWEEPS):
            if not any([self._move(chosen, i) for i in np.flatnonzero(chosen).tolist()]):
                break
        cost = float(self._costs(chosen, 0, _NONE, np.inf)[0])
        return Exchanged(self._x[chosen > 0], chosen[chosen > 0], cost)

    def _of(self, count: int) -> Array:
        """(N, p, p) what each of the pool adds, measured so often."""
        if count not in self._known:
            often = np.full(len(self._x), float(count))
            blocks = self._aim.space.evaluate(self._x, often).blocks
            self._known[count] = count * information(blocks)
        return self._known[count]

    def _seen_of(self, sums: BlindSums, count: int) -> Array:
        """(N, f + c, f + c) what each of the pool tells of unknowns and effects likewise."""
        if count not in self._seen:
            self._seen[count] = sums.informations(self._pool, np.full(len(self._x), count))
        return self._seen[count]

    def _left(self, totals: Array) -> Array:
        """(K,) mean squares that totals (K, p, p) leave; infinite where they tell too little."""
        scaled = totals * np.outer(self._scale, self._scale)
        scaled = scaled + 1e-12 * np.eye(len(self._scale))
        columns = np.broadcast_to(self._columns, (len(scaled), *self._columns.shape))
        solved = np.linalg.solve(scaled, columns)
        return np.asarray((self._columns * solved).sum(axis=(1, 2)) + self._aim.beyond)

    def _move(self, chosen: IntArray, i: int) -> bool:
        """Whether all repeats of point i, or one of them, are better elsewhere: they are moved."""
        count = int(chosen[i])
        if not count:
            return False
        dear = float(self._dear(chosen, 0, _NONE)[0])
        now = float(self._costs(chosen, 0, _NONE, np.inf)[0])
        most = _HOPELESS * dear if self._held.rho0 is not None else now
        others = np.flatnonzero((chosen > 0) & (np.arange(len(chosen)) != i))
        far = apart(self._robot, self._q, self._q[others]).min(axis=1, initial=np.inf) > NEAR
        new = np.flatnonzero((chosen == 0) & far)
        moves = [(count, int(j)) for j in new]
        costs = [self._costs(_without(chosen, i, count), count, new, most)]
        for k in others.tolist():
            for some in sorted({1, count}):
                tried = _without(chosen, i, some)
                tried[k] += some
                moves.append((some, k))
                costs.append(self._costs(tried, 0, _NONE, most))
        if count > 1 and len(others) + 1 < self._aim.distinct:
            new = new[apart(self._robot, self._q[new], self._q[[i]])[:, 0] > NEAR]
            moves += [(1, int(j)) for j in new]
            costs.append(self._costs(_without(chosen, i, 1), 1, new, most))
        found = np.concatenate(costs)
        if not len(found) or not found.min() < now * (1.0 - _GAIN):
            return False
        some, to = moves[int(found.argmin())]
        chosen[i] -= some
        chosen[to] += some
        return True

    def _costs(self, chosen: IntArray, count: int, new: IntArray, most: float) -> Array:
        """(K,) what is to fall, dearer where limits are passed; infinite where that is hopeless.

        Args:
            chosen: (N,) repeats of a choice.
            count: How often another load case is measured besides.
            new: (K,) which of the pool that is; if there is none the choice is all, and K is one.
            most: Without its blind error, a choice of this cost is hopeless.
        """
        cost, held = self._dear(chosen, count, new), self._held
        if held.sums is None:
            return cost
        hopeful = cost < most
        there = np.flatnonzero(chosen).tolist()
        blind = np.full(len(cost), np.inf)
        if hopeful.any():
            total = np.sum([self._seen_of(held.sums, int(chosen[k]))[k] for k in there], axis=0)
            more = self._seen_of(held.sums, count)[new[hopeful]] if count else 0.0
            totals = np.asarray(total + more).reshape(-1, *total.shape)
            blind[hopeful] = held.sums.worst(totals, len(there) + bool(count), self._power) ** 2
        return np.asarray(cost * (_times(blind, held.blind) if held.rho0 is None else blind))

    def _dear(self, chosen: IntArray, count: int, new: IntArray) -> Array:
        """(K,) the same without the blind error."""
        total, groups = self._groups(chosen)
        totals = total + self._of(count)[new] if count else total[None]
        lost = np.zeros(len(totals))
        for group in groups:
            lost = np.maximum(lost, self._left(totals - group))
        if count:
            lost = np.maximum(lost, self._left(total[None])[0])
        rho0, held = self._left(totals), self._held
        dear = _times(lost, held.loss) * _times(rho0, held.rho0)
        if held.rho0 is None:
            return np.asarray(rho0 * dear)
        return np.asarray(dear if held.loss is not None else lost * dear)

    def _groups(self, chosen: IntArray) -> tuple[Array, Array]:
        """(p, p) what a choice tells, and (G, p, p) of it each of its configurations."""
        points = np.flatnonzero(chosen)
        each = np.array([self._of(int(chosen[k]))[k] for k in points.tolist()])
        each = each.reshape(len(points), *self._aim.base.shape)
        group = near_configurations(self._robot, self._q[points])
        sums = np.zeros((int(group.max(initial=-1)) + 1, *self._aim.base.shape))
        np.add.at(sums, group, each)
        return self._aim.base + sums.sum(axis=0), sums


_NONE = np.zeros(0, dtype=np.int64)


def _without(chosen: IntArray, i: int, some: int) -> IntArray:
    """The choice with so many repeats of point i less."""
    left = chosen.copy()
    left[i] -= some
    return left


def _times(squares: Array, limit: float | None) -> Array:
    """(K,) how much dearer mean squares are for being above the square of a limit."""
    if limit is None:
        return np.ones(len(squares))
    return np.asarray(1.0 + _DEAR * np.maximum(squares / limit**2 - 1.0, 0.0))
