"""Conventions by which a controller may count: which joints the other way, which with another.

In: the coupling that is assumed. Out: all others that differ in signs and in the coupling of
neighbours, so that what was read can tell which is right.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from elastocal.arrays import Array, IntArray
from elastocal.errors import Doubt
from elastocal.robot.chain import Robot
from elastocal.robot.controller_axes import Coupling, has_forearm

_FACTORS = (0.0, 1.0, -1.0)
_MOST_SIGNS, _MOST_PAIRS = 8, 2


@dataclass(frozen=True)
class Convention:
    """A coupling taken apart: (1 + K)(S q + o).

    Attributes:
        names: n joints.
        signs: (n,) 1 or -1.
        offsets: (n,) what the controller shows, after its sign, at zero [rad or m].
        mixing: (n, n) 1 + K.
    """

    names: tuple[str, ...]
    signs: Array
    offsets: Array
    mixing: Array

    @staticmethod
    def of(table: Coupling) -> Convention:
        """The parts of a coupling."""
        signs = np.where(np.diag(table.matrix) < 0.0, -1.0, 1.0)
        mixing: Array = table.matrix * signs
        offsets: Array = np.linalg.solve(mixing, table.offset).astype(float)
        return Convention(table.joint_names, signs, offsets, mixing)

    def to_model(self, shown: Array) -> Array:
        """(K, n) joint values of the model for those shown, (K, n)."""
        own = np.linalg.solve(self.mixing, shown.T).T
        return np.asarray((own - self.offsets) * self.signs)

    def turned(self, joints: Sequence[int] | IntArray) -> Convention:
        """The same with some joints counting the other way."""
        signs = self.signs.copy()
        signs[joints] *= -1.0
        return Convention(self.names, signs, self.offsets, self.mixing)

    def moved(self, i: int, by: float) -> Convention:
        """The same with the zero of a joint elsewhere."""
        offsets = self.offsets.copy()
        offsets[i] += by
        return Convention(self.names, self.signs, offsets, self.mixing)

    def coupled(self, i: int, j: int, by: float) -> Convention:
        """The same with so much more of joint j in what is shown for joint i."""
        mixing = self.mixing.copy()
        mixing[i, j] += by
        return Convention(self.names, self.signs, self.offsets, mixing)

    def mistakes(self, assumed: Convention) -> tuple[Doubt, ...]:
        """What was wrong in another one if this is right, each with the value that mends it."""
        found = [
            Doubt("counts-other-way", (name,), numbers={"sign": int(sign)})
            for name, sign, other in zip(self.names, self.signs, assumed.signs, strict=True)
            if sign != other
        ]
        for i, j in zip(*np.nonzero(self.mixing != assumed.mixing), strict=True):
            factor = {"factor": float(self.mixing[i, j])}
            found.append(Doubt("coupled", (self.names[i], self.names[j]), numbers=factor))
        return tuple(found)


def conventions(robot: Robot, assumed: Convention, joints: Sequence[int]) -> Iterator[Convention]:
    """All signs of some joints, with every coupling there is or may be; the assumed one first.

    Forearms are coupled to the upper arm in the controllers of one maker at least; other couplings
    are tried where the assumed convention has them.

    Args:
        robot: The robot.
        assumed: The convention to start from.
        joints: Joints whose signs matter, as positions; of many the first eight are tried.
    """
    pairs = _pairs(robot, assumed)[:_MOST_PAIRS]
    signs = product((False, True), repeat=len(joints[:_MOST_SIGNS]))
    flips = [np.array(flip, dtype=bool) for flip in signs]
    for factors in product(_FACTORS, repeat=len(pairs)):
        other = assumed
        for (i, j), by in zip(pairs, factors, strict=True):
            # Of what is there, every one of the three factors; the assumed one comes first.
            wanted = _FACTORS[
                (_FACTORS.index(_near(assumed.mixing[i, j])) + _FACTORS.index(by)) % 3
            ]
            other = other.coupled(i, j, wanted - other.mixing[i, j]) if by else other
        for flip in flips:
            yield other.turned(np.array(joints[:_MOST_SIGNS], dtype=int)[flip])


def _near(factor: float) -> float:
    """Which of the usual factors a coupling has, as good as."""
    return float(min(_FACTORS, key=lambda usual: abs(usual - factor)))


def _pairs(robot: Robot, assumed: Convention) -> list[tuple[int, int]]:
    """(i, j): what is shown for joint i may have some of joint j in it."""
    apart = assumed.mixing - np.diag(np.diag(assumed.mixing))
    pairs = [(int(i), int(j)) for i, j in zip(*np.nonzero(apart), strict=True)]
    if has_forearm(robot):
        second, third = np.flatnonzero(~robot.prismatic)[1:3].tolist()
        if (third, second) not in pairs:
            pairs.append((third, second))
    return pairs
