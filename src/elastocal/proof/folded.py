"""The arm of a statement without the joints that stand still: what is behind them is moved there.

Source: ours. exp(ξ_2 c) exp(ξ_3 q) = exp(ξ_3' q) exp(ξ_2 c), with ξ_3' moved by exp(ξ_2 c).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastocal.arrays import Array, BoolArray, IntArray
from elastocal.errors import InputError
from elastocal.proof.statement import Statement
from elastocal.robot.rotations import from_rotation_vectors


@dataclass(frozen=True)
class Folded:
    """An arm whose a joints move.

    Attributes:
        variables: (a,) their variables among those of the statement.
        axis: (a, 3) with all of them at zero and the others where they stand, base frame.
        point: (a, 3) [m].
        slides: (a,) which slide.
        links: (a,) q_i = x_i - links_i x_{i-1} + starts_i.
        starts: (a,) [rad or m].
        least: (a,) limits of q_i that the root does not hold; infinite where it does.
        most: (a,) likewise.
        bodies: (c,) how many of the joints move each spring that counts, in order.
        spring_axis: (c, 3).
        spring_point: (c, 3) [m].
        spring_slides: (c,) which are linear.
        values: (c, r) their rows of V.
        turn: (3, 3) what joints that stand still turn all behind them by.
        shift: (3,) and then move it by [m].
    """

    variables: IntArray
    axis: Array
    point: Array
    slides: BoolArray
    links: Array
    starts: Array
    least: Array
    most: Array
    bodies: IntArray
    spring_axis: Array
    spring_point: Array
    spring_slides: BoolArray
    values: Array
    turn: Array
    shift: Array

    def placed(self, point: Array) -> Array:
        """(3,) a point of the last body [m]."""
        return np.asarray(self.turn @ point + self.shift)

    def turned(self, axis: Array) -> Array:
        """(3,) a direction of the last body."""
        return np.asarray(self.turn @ axis)


def folded(statement: Statement) -> Folded:
    """The arm of a statement as its root leaves it.

    A variable without width stays where another one that has some moves its joint.

    Raises:
        InputError: coordinates are mixed otherwise than the core can.
    """
    s, joints = statement, statement.joints
    moves = np.zeros(len(joints), dtype=bool)
    moves[s.active] = True
    kept = (s.mix[:, moves] != 0.0).any(axis=1)
    values = s.seen
    counts = (values != 0.0).any(axis=1)
    turn, shift = np.eye(3), np.zeros(3)
    axis: list[Array] = []
    point: list[Array] = []
    springs: list[tuple[int, int, Array, Array]] = []
    for i in range(len(joints) + 1):
        for c in np.flatnonzero((s.springs.body == i) & counts).tolist():
            springs.append(
                (c, len(axis), turn @ s.springs.axis[c], turn @ s.springs.point[c] + shift)
            )
        if i == len(joints):
            break
        if kept[i]:
            axis.append(turn @ joints.axis[i])
            point.append(turn @ joints.point[i] + shift)
            continue
        value = float(s.mix[i] @ s.root[0])
        step, own = value * joints.axis[i], np.eye(3)
        if not joints.slides[i]:
            own = from_rotation_vectors(value * joints.axis[i][None])[0]
            step = joints.point[i] - own @ joints.point[i]
        turn, shift = turn @ own, turn @ step + shift
    index = np.flatnonzero(kept)
    links, starts = np.zeros(len(index)), np.zeros(len(index))
    for a, i in enumerate(index.tolist()):
        for j in np.flatnonzero(s.mix[i, :i]).tolist():
            follows = a and index[a - 1] == j and j == i - 1
            if (moves[j] and not follows) or joints.slides[i] != joints.slides[j]:
                raise InputError("sums of coordinates are for joints that follow each other")
            if follows:
                links[a] = -s.mix[i, j]
            else:  # it stands still
                starts[a] += s.mix[i, j] * s.root[0, j]
    limited = s.limited[index]
    found = [c for c, *_ in springs]
    return Folded(
        variables=index,
        axis=np.reshape(axis, (-1, 3)),
        point=np.reshape(point, (-1, 3)),
        slides=joints.slides[index],
        links=links,
        starts=starts,
        least=np.where(limited, joints.lower[index], -np.inf),
        most=np.where(limited, joints.upper[index], np.inf),
        bodies=np.array([body for _, body, *_ in springs], dtype=np.int64),
        spring_axis=np.reshape([a for *_, a, _ in springs], (-1, 3)),
        spring_point=np.reshape([p for *_, p in springs], (-1, 3)),
        spring_slides=s.springs.slides[found],
        values=values[found],
        turn=turn,
        shift=shift,
    )
