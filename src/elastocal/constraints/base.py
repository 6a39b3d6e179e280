"""What a constraint is."""

from __future__ import annotations

import abc

from elastocal.arrays import Array
from elastocal.posture import Posture
from elastocal.robot import Robot


class Constraint(abc.ABC):
    """A signed margin over configurations.

    Attributes:
        name: What the user reads: "height of M1 >= 800 mm".
        unit: "m" or "rad": the unit of the margin.
    """

    name: str
    unit: str

    @abc.abstractmethod
    def at(self, posture: Posture) -> tuple[Array, Array]:
        """Margins (N,) and their gradients (n, N) for N postures."""

    def margin(self, robot: Robot, q: Array) -> Array:
        """(N,) margins of configurations `q`, (N, n); feasible where >= 0."""
        return self.at(Posture(robot, q))[0]
