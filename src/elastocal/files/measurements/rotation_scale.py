"""Whether rotations fit to the positions beside them: a wrong unit or sign does not.

In: measurements with both. Out: doubts. The positions alone are fitted by the linear model, which
then says what the rotations should be, but for noise and the square of the load.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from elastocal.elastic.load_cases import LoadCases
from elastocal.elastic.regressor import regressor
from elastocal.errors import Doubt
from elastocal.files.tables.units import UNITS, factor
from elastocal.measuring.measurements import Measurements
from elastocal.study.study import Study

_MOST = 500  # experiments that are asked; a unit is the same for all
_SURE = 0.9  # cosine of what is read and what should be, from which on a factor means something
_NEAR = 1.3  # how far a factor may be off that between two units
_MEANT = ("mrad", "rad", "deg", "urad")


def rotations_unlike_positions(
    found: Measurements, study: Study, units: Mapping[str, str]
) -> Iterator[Doubt]:
    """Rotations that are off by a factor between units, or by their sign.

    Args:
        found: What was read.
        study: The campaign it belongs to: its springs are fitted.
        units: Units of the columns in the file, by key.
    """
    count = min(len(found.cases), _MOST)
    used = found.case < count
    turned = found.rotations & used
    placed = ~found.rotations & used
    if not (turned.any() and placed.any()):
        return
    cases = LoadCases(found.cases.q[:count], found.cases.wrench[:count])
    rows = regressor(replace(study.arm, springs=study.sought, tool=found.tool), cases)
    rows = rows.reshape(count, len(found.tool.targets), 3, -1)
    positions, rotations = (
        rows[found.case[own], found.marker[own]].reshape(-1, rows.shape[-1])
        for own in (placed, turned)
    )
    scale = np.linalg.norm(positions, axis=0)
    scale[scale == 0.0] = 1.0
    fitted = np.linalg.lstsq(positions / scale, found.deflection[placed].ravel(), rcond=1e-6)[0]
    expected, read = rotations @ (fitted / scale), found.deflection[turned].ravel()
    sizes = float(np.linalg.norm(expected) * np.linalg.norm(read))
    if sizes == 0.0 or abs(expected @ read) < _SURE * sizes:
        return
    ratio = float((expected @ read) / (expected @ expected))
    if ratio < 0.0:
        yield Doubt("rotation-sign")
    keys = (key for key in units if key.split("@")[0] == "drx")
    unit = units.get(next(keys, ""), "mrad")
    for meant in _MEANT:
        between = (factor(unit, "rotation") or 1.0) / UNITS["rotation"][meant]
        alike = abs(np.log(abs(ratio) / between)) < np.log(_NEAR)
        if alike and abs(np.log(between)) > 2.0 * np.log(_NEAR):
            yield Doubt("rotation-unit", (meant,), (unit,), {"ratio": abs(ratio)})
