"""What measures the deflections: isotropic noise, or a tracker that stands somewhere; points only,
or whole poses."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from elastocal.errors import InputError
from elastocal.files.measurements.uncertainty import LEAST, MOST
from elastocal.files.sections import After, Section
from elastocal.files.values import (
    DegreeRange,
    Flag,
    Micrometres,
    MillimetreRange,
    MillimetreVector,
    Name,
    PositiveMicrometres,
    PositiveMillimetres,
    PositiveMilliradians,
)
from elastocal.files.yaml_lines import LocatedError
from elastocal.measuring.common_errors import CommonErrors
from elastocal.measuring.instrument import PRESETS, Instrument, Isotropic, LaserTracker, PoseProbe

_NOISE = ("along_um", "along_um_per_m", "across_um", "across_um_per_m")


def _plausible(scale: float) -> After:
    """Of standard deviations in SI that a file has in a unit, `scale` of which are one of SI."""

    def check(value: float) -> float:
        if not 0.99 * LEAST < value < 1.01 * MOST:  # with the rounding of units
            raise ValueError(
                f"expected a standard deviation from {scale * LEAST:g} to "
                f"{scale * MOST:g}, found {scale * value:g}"
            )
        return value

    return After(check)


_Millimetres = Annotated[PositiveMillimetres, _plausible(1e3)]
_Milliradians = Annotated[PositiveMilliradians, _plausible(1e3)]
_Micrometres = Annotated[PositiveMicrometres, _plausible(1e6)]


class TrackerFile(Section):
    """A laser tracker: where it stands, and its noise, one reading, one standard deviation."""

    position_mm: MillimetreVector
    preset: Name | None = None
    along_um: _Micrometres | None = None
    along_um_per_m: Micrometres | None = None
    across_um: _Micrometres | None = None
    across_um_per_m: Micrometres | None = None
    range_mm: MillimetreRange | None = None
    elevation_deg: DegreeRange | None = None
    azimuth_deg: DegreeRange | None = None
    line_of_sight: Flag = True
    beam_radius_mm: PositiveMillimetres = 10.0


class InstrumentFile(Section):
    """What is measured: points, or points and the rotation of the flange; and how well."""

    measures: Literal["position", "pose"] = "position"
    sigma_mm: _Millimetres | None = None
    tracker: TrackerFile | None = None
    sigma_mrad: _Milliradians | None = None
    common_mm: _Millimetres | None = None
    common_mrad: _Milliradians | None = None


def instrument_of(entry: InstrumentFile) -> Instrument:
    """What measures the deflections, with what the readings of one pose share."""
    own = _own(entry)
    if entry.common_mm is None and entry.common_mrad is None:
        return own
    return CommonErrors(own, entry.common_mm or 0.0, entry.common_mrad or 0.0)


def _own(entry: InstrumentFile) -> Instrument:
    """What each reading errs by itself."""
    if entry.measures == "position":
        if entry.sigma_mrad is not None:
            raise LocatedError(
                ("sigma_mrad",),
                "sigma_mrad is the noise of a rotation, and positions alone are measured; with a "
                "6-D probe give measures: pose",
            )
        return _of_points(entry)
    if entry.sigma_mrad is None:
        raise InputError(
            "measures: pose needs sigma_mrad, the standard deviation of one component of a "
            "measured rotation (0.01° are 0.175 mrad)"
        )
    return PoseProbe(_of_points(entry), entry.sigma_mrad)


def _of_points(entry: InstrumentFile) -> Instrument:
    """What measures positions."""
    if (entry.sigma_mm is None) == (entry.tracker is None):
        raise InputError("give exactly one of sigma_mm and tracker")
    if entry.sigma_mm is not None:
        return Isotropic(entry.sigma_mm)
    assert entry.tracker is not None
    return _tracker(entry.tracker)


def _tracker(entry: TrackerFile) -> LaserTracker:
    """A tracker from a preset or from its numbers."""
    position = np.array(entry.position_mm)
    given = [key for key in _NOISE if getattr(entry, key) is not None]
    if entry.preset is not None:
        if given:
            raise LocatedError(
                ("tracker", given[0]), f"give either preset or {given[0]}: a preset has its own"
            )
        if entry.preset not in PRESETS:
            raise LocatedError(
                ("tracker", "preset"),
                f"no preset {entry.preset!r}; there are {', '.join(PRESETS)}, or give "
                f"{', '.join(_NOISE)}",
            )
        return PRESETS[entry.preset].at(position)
    for key in ("along_um", "across_um"):
        if key not in given:
            raise LocatedError(
                ("tracker",), f"tracker: key {key!r} is missing; give it, or a preset"
            )
    return LaserTracker(position, *(getattr(entry, key) or 0.0 for key in _NOISE))
