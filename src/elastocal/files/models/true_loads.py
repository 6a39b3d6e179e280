"""How loads of a virtual robot differ from what is recorded of them, as a section of a model."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from elastocal.elastic.true_loads import TrueLoads
from elastocal.errors import InputError
from elastocal.files.sections import After, Section, fresh
from elastocal.files.values import Finite, FiniteVector

_LARGEST = 0.5


def _gain(value: float) -> float:
    if abs(value) > _LARGEST:
        raise ValueError(f"expected a share from {-_LARGEST:g} to {_LARGEST:g}, found {value:g}")
    return value


_Gain = Annotated[Finite, After(_gain)]


class TrueLoadsFile(Section):
    """Shares by which forces are larger than is said, and how they all are turned."""

    gain: _Gain = 0.0
    process_gain: _Gain = 0.0
    turn_deg: FiniteVector = fresh(lambda: [0.0, 0.0, 0.0])

    def loads(self) -> TrueLoads:
        """In SI units.

        Raises:
            InputError: they are turned by more than a right angle.
        """
        turn = np.radians(self.turn_deg)
        if np.linalg.norm(turn) > math.pi / 2:
            raise InputError("turn_deg: expected a rotation of at most 90°")
        return TrueLoads(self.gain, turn, self.process_gain)


def true_loads_section(loads: TrueLoads) -> dict[str, Any]:
    """The section of these."""
    return {
        "gain": loads.gain,
        "process_gain": loads.process_gain,
        "turn_deg": np.degrees(loads.turn).tolist(),
    }
