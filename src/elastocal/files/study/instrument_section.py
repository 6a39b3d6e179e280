"""The instrument section of a study file, as an instrument and the limits of its view."""

from __future__ import annotations

import numpy as np

from elastocal.errors import InputError
from elastocal.files.schema import InstrumentFile, TrackerFile
from elastocal.files.yaml_lines import LocatedError
from elastocal.measuring.instrument import PRESETS, Instrument, Isotropic, LaserTracker


def instrument_of(entry: InstrumentFile) -> Instrument:
    """What measures the deflections."""
    if (entry.sigma_mm is None) == (entry.tracker is None):
        raise InputError("give exactly one of sigma_mm and tracker")
    if entry.sigma_mm is not None:
        return Isotropic(entry.sigma_mm / 1e3)
    assert entry.tracker is not None
    return _tracker(entry.tracker)


_NOISE = ("along_um", "along_um_per_m", "across_um", "across_um_per_m")


def _tracker(entry: TrackerFile) -> LaserTracker:
    """A tracker from a preset or from its numbers."""
    position = np.array(entry.position_mm) / 1e3
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
        if getattr(entry, key) is None:
            raise LocatedError(
                ("tracker",), f"tracker: key {key!r} is missing; give it, or a preset"
            )
    along, along_per_m, across, across_per_m = (
        (getattr(entry, key) or 0.0) / 1e6 for key in _NOISE
    )
    return LaserTracker(position, along, along_per_m, across, across_per_m)
