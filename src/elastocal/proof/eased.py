"""The design behind a proof where it leaves out what errs: V for the larger information there is.

The V of a bound is good for the errors it knows. A statement that leaves some of them out has
more information everywhere, of another shape, and another V bounds it closer.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.design.continuous import ContinuousDesign, continuous_design
from elastocal.design.criterion import InformationFunction
from elastocal.design.test_pose import TestPosePrecision
from elastocal.measuring.instrument import Instrument, Isotropic, PoseProbe
from elastocal.planning.aim import Aim
from elastocal.planning.certificate import with_floor
from elastocal.stopping import Stop, stoppable

_CLOSE = 1e-3  # gap at which the search may end
_OPEN = 0.1  # gap that a singular optimum leaves
_POINTS = 500  # load cases of which a floor is made


def eased_design(
    aim: Aim,
    sigma: float,
    sigma_turn: float | None,
    rng: np.random.Generator,
    stop: Stop | None = None,
) -> ContinuousDesign:
    """The best continuous design without errors of load cases and with the same noise everywhere.

    Of the unknowns that make springs; those that turn all loads are taken as known.

    Args:
        aim: What plans are to be good for.
        sigma: Noise of one coordinate [m].
        sigma_turn: Of one component of a rotation that is read [rad]; None if none is.
        rng: Source of candidates and starts.
        stop: Asked now and then whether to end.

    Raises:
        Stopped: it was to end.
    """
    points: Instrument = Isotropic(sigma)
    instrument = points if sigma_turn is None else PoseProbe(points, sigma_turn)
    space = replace(aim.space, errors=None, instrument=instrument)
    p, criterion = space.parameters, aim.criterion
    assert isinstance(criterion, InformationFunction)
    if isinstance(criterion, TestPosePrecision):
        criterion = TestPosePrecision(criterion.weight[:p, :p])
    base: Array = aim.base[:p, :p]
    eased = replace(aim, space=space, criterion=criterion, base=base, told=None)
    with stoppable(stop):
        design = continuous_design(space, criterion, rng, base=base / aim.count, tolerance=_CLOSE)
        if design.gap < _OPEN and not design.singular:
            return design
        target = with_floor(eased, criterion, space.sample(_POINTS, rng))
        return continuous_design(
            space, target, rng, certified=criterion, base=base / aim.count, tolerance=_CLOSE
        )
