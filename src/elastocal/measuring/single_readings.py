"""Noise of single absolute readings, in the frame of the station that makes them.

A standard deviation that a study of absolute readings states is that of one reading. A tracker that
is known by its noise along and across the beam says that of deflections, differences of two
readings of nearly the same point: a single one has half of their covariance.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastocal.arrays import Array
from elastocal.errors import InputError
from elastocal.measuring.common_errors import CommonErrors
from elastocal.measuring.instrument import Instrument, LaserTracker, PoseProbe, positions_of


def reading_covariance(instrument: Instrument, points: Array) -> Array:
    """(N, 3, 3) covariance of single readings of `points`, (N, 3), frame of the station [m²].

    A tracker stands at the origin of its frame. What it errs by in all readings of a pose together
    is in each of them.
    """
    own = positions_of(instrument.single)
    if isinstance(own, LaserTracker):
        found = 0.5 * replace(own, position=np.zeros(3)).covariance(np.asarray(points))
    else:
        found = own.covariance(np.asarray(points))
    if isinstance(instrument, CommonErrors):
        found = found + instrument.translation**2 * np.eye(3)
    return np.asarray(found)


def turn_covariance(instrument: Instrument) -> Array:
    """(3, 3) covariance of a single orientation, as a small turn [rad²].

    Raises:
        InputError: the instrument does not say how well it reads orientations.
    """
    if instrument.sigma_rotation is None:
        raise InputError(
            "the instrument says nothing of orientations; expected sigma_mrad in it, or a "
            "column such as 'ur [mrad]'"
        )
    return np.asarray(instrument.sigma_rotation**2 * np.eye(3))


def of_readings(instrument: Instrument) -> Instrument:
    """The instrument whose noise of a deflection is what this one has of a single reading.

    Of a tracker it is less by the root of two; what is stated by itself is that of a reading.
    """
    if isinstance(instrument, LaserTracker):
        names = ("along", "along_per_metre", "across", "across_per_metre")
        return replace(instrument, **{n: getattr(instrument, n) / np.sqrt(2.0) for n in names})
    if isinstance(instrument, PoseProbe):
        return replace(instrument, points=of_readings(instrument.points))
    return instrument
