"""From what a tracker wrote to a calibrated arm: base, geometry, compliances, drift, and a check.

Nothing is known of where the tracker stood and little of where the reflectors are. The same by
commands: see absolute/README.md.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastocal.calibration.calibrate import calibrate
from elastocal.calibration.calibrated_robot import put_away
from elastocal.calibration.stations import station_motions, steadied
from elastocal.calibration.validate import check_set_up
from elastocal.files.measurements.positions_file import read_positions
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.fitting.robust import LOSSES
from elastocal.measuring.positions import Positions
from elastocal.study.absolute import AbsoluteStudy, arm_model, unknowns_of
from elastocal.wording import worded

FOLDER = Path(__file__).parent / "absolute"


def readings(study: AbsoluteStudy, series: str) -> Positions:
    """What was read in a series, as if the tracker had stood still."""
    files = [FOLDER / f"{series}_{what}.csv" for what in ("tracker", "joints")]
    read = read_positions(files, study, FOLDER / "mapping.yaml")
    motions = station_motions(read)
    print(
        f"{series}: {len(read)} readings of {len(read.cases)} poses, tracker {motions[0].verdict}"
    )
    steady = steadied(read, motions)
    for doubt in steady.doubts:
        print(f"  {worded(doubt)}")
    return steady


def main() -> None:
    """Calibrate with one series, check with another that has base and reflectors of its own."""
    study = read_absolute_study(FOLDER / "study.yaml")
    read = readings(study, "calibrate")
    model = arm_model(study)
    found = calibrate(model, read, unknowns_of(study, model, read), loss=LOSSES["bisquare"])
    known = found.redundancy
    print(f"{known.told} of {len(found.parameters)} unknowns together are told by the readings:")
    values = dict(zip(study.springs.names, found.state.compliance, strict=True))
    for u in found.parameters.of("compliance"):
        name, half = found.parameters.names[u], found.width * found.standard_error[u]
        print(f"  {name}: {1e6 * values[name]:.3f} ± {1e6 * half:.3f} µrad/(N·m)")
    left = np.sqrt(np.median((found.left_out**2).sum(axis=1)))
    print(f"half of the poses left out in turn are within {1e6 * left:.0f} µm of the model")
    other = readings(study, "check")
    there = check_set_up(put_away(found), other, 8)
    print(
        f"other poses, with base and reflectors from eight of them: {1e6 * there.rms:.0f} µm "
        f"(root mean square), {1e6 * there.expected:.0f} expected"
    )


if __name__ == "__main__":
    main()
