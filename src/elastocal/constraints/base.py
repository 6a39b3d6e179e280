"""What a constraint is."""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence

import numpy as np

from elastocal.arrays import Array
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture

Pull = Callable[[Array], Array]


class Constraint(abc.ABC):
    """A signed margin over configurations.

    Attributes:
        name: What the user reads: "height of M1 >= 800 mm".
        unit: "m" or "rad": the unit of the margin.
        costly: Whether it takes much longer than the others, so that it is asked last.
        one_by_one: Whether it measures configurations one by one, so that several cores help.
        measuring: Whether it says how to measure and load, so that it need not hold on the way.
    """

    name: str
    unit: str
    costly = False
    one_by_one = False
    measuring = False

    @abc.abstractmethod
    def at(self, posture: Posture) -> tuple[Array, Pull]:
        """Margins (N,) of N postures, and their gradients as a function.

        The function takes weights (N,) and returns the gradients in q times these, (n, N). Most
        margins are not near zero most of the time, so gradients are made only when asked for.
        """

    @property
    def on_the_way(self) -> Constraint:
        """What of it holds where the robot only passes, nothing is measured."""
        return self

    def room(self, posture: Posture) -> Array:
        """(N,) margins to be shown; `at` may stop measuring where there is plenty."""
        return self.at(posture)[0]

    def names_at(self, posture: Posture) -> list[str]:
        """N names that say what of the constraint is nearest to being broken at each posture."""
        return [self.name] * posture.count

    def margin(self, robot: Robot, q: Array) -> Array:
        """(N,) margins of configurations `q`, (N, n); feasible where >= 0."""
        return self.at(Posture(robot, q))[0]

    def gradient(self, robot: Robot, q: Array) -> Array:
        """(N, n) gradients of the margins of configurations `q`, (N, n)."""
        return self.at(Posture(robot, q))[1](np.ones(len(q))).T


def margins_at(constraints: Sequence[Constraint], posture: Posture) -> Array:
    """(C, N) margins of C constraints at N postures, as the search sees them."""
    margins = [constraint.at(posture)[0] for constraint in constraints]
    return np.array(margins).reshape(len(constraints), posture.count)


def room_at(constraints: Sequence[Constraint], posture: Posture) -> Array:
    """(C, N) margins of C constraints at N postures, to be shown; see `Constraint.room`."""
    room = [constraint.room(posture) for constraint in constraints]
    return np.array(room).reshape(len(constraints), posture.count)
