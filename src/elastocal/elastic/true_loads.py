"""How the loads of a virtual robot, all together, differ from what is recorded of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from elastocal.arrays import Array, freeze


@dataclass(frozen=True)
class TrueLoads:
    """How all loads differ from what is recorded of them.

    Attributes:
        gain: By which share they are larger.
        turn: (3,) rotation by which all of them point elsewhere [rad].
        process_gain: By which share the process force is larger than what is said of it.
    """

    gain: float = 0.0
    turn: Array = field(default_factory=lambda: np.zeros(3))
    process_gain: float = 0.0

    def __post_init__(self) -> None:
        freeze(self, turn=np.reshape(self.turn, 3))
