"""Models that grow: each with its error on poses not used, so that none is larger than it helps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.parameters import Parameters
from elastocal.errors import InputError
from elastocal.fitting.robust import Loss
from elastocal.measuring.positions import Positions


@dataclass(frozen=True)
class Rung:
    """One model of a ladder.

    Attributes:
        name: What it has that those before have not.
        calibration: The fit of it; None if it came not to rest.
        error: Root mean square length of the errors of the fit [m].
        left_out: The same of poses left out in turn [m].
        margin: Standard error of the square of that [m²].
    """

    name: str
    calibration: Calibration | None
    error: float = np.inf
    left_out: float = np.inf
    margin: float = np.inf

    @property
    def unknowns(self) -> int:
        """Number of its unknowns."""
        return 0 if self.calibration is None else len(self.calibration.parameters)


@dataclass(frozen=True)
class Ladder:
    """Models that grow.

    Attributes:
        rungs: From the smallest to the largest.
        best: Number of the one with the least error on poses left out.
        proposed: Number of the smallest one that is within one standard error of it.
    """

    rungs: tuple[Rung, ...]
    best: int
    proposed: int


def ladder(
    models: Sequence[tuple[str, ArmModel, Parameters]],
    positions: Positions,
    loss: Loss | None = None,
    whole: Calibration | None = None,
) -> Ladder:
    """Fit models that grow to the same readings.

    Args:
        models: Their names, arms and unknowns, the smallest first.
        positions: The readings.
        loss: How outlying readings count; squares if None.
        whole: The fit of the last of them, if it is there.

    Source: one standard error: Breiman et al. (1984); poses are left out to first order.
    """
    rungs = []
    for name, model, parameters in models:
        last = whole is not None and parameters.names == whole.parameters.names
        try:
            found = whole if last else calibrate(model, positions, parameters, loss=loss)
        except InputError:
            rungs.append(Rung(name, None))
            continue
        assert found is not None
        rungs.append(_rung(name, found))
    squares = np.array([rung.left_out**2 for rung in rungs])
    best = int(squares.argmin())
    within = squares <= squares[best] + rungs[best].margin
    return Ladder(tuple(rungs), best, int(np.flatnonzero(within)[0]))


def _rung(name: str, found: Calibration) -> Rung:
    """A fit with its errors; of positions, or of rotations if there are no positions."""
    p = found.positions
    mine = ~p.rotations if not p.rotations.all() else np.ones(len(p), dtype=bool)
    squares = (found.left_out[mine] ** 2).sum(axis=1)
    count = np.bincount(p.case[mine], minlength=len(p.cases))
    by_pose = np.bincount(p.case[mine], squares, len(p.cases))[count > 0]
    # Readings of a pose go together: what varies is the sum of each pose.
    spread = by_pose - count[count > 0] * squares.mean()
    margin = float(np.sqrt((spread**2).sum()) / len(squares))
    fit = float(np.sqrt((found.error[mine] ** 2).sum(axis=1).mean()))
    return Rung(name, found, fit, float(np.sqrt(squares.mean())), margin)
