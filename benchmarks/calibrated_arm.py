"""A measured light arm under a laser tracker: geometry, compliances, base and tool in one fit.

    python benchmarks/calibrated_arm.py FOLDER [--frames 100]

The folder has `series_b.csv` of christianlandgraf/ipa-robot-accuracy (MIT; Landgraf et al., CASE
2021): 1495 configurations of a UR10 with a tracker's probe on its flange, positions in the frame of
the tracker; and `split_b.csv`, which says which of its lines are fitted and which are predicted.
They are not part of this repository.

Printed: errors of the fit and of the other rows for models that grow, what the readings tell, and
the time of each; how often another frame of the tracker ends elsewhere; and the time of a fit to
20 000 virtual rows of the same arm.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.calibrated_robot import put_away
from elastocal.calibration.prediction import predicted
from elastocal.calibration.validate import check, rms_of
from elastocal.elastic.load_cases import LoadCases
from elastocal.files.measurements.positions_file import read_positions
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.measuring.positions import Positions
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.study.absolute import AbsoluteStudy, arm_model, unknowns_of

_STUDY = """\
elastocal: 1
name: UR10
robot:
  name: UR10
  convention: classic
  dh:
    - {{joint: shoulder_pan, d_mm: 127.3, alpha_deg: 90, mass_kg: 7.778}}
    - {{joint: shoulder_lift, a_mm: -612, mass_kg: 12.93, center_mm: [380, 0, 158]}}
    - {{joint: elbow, a_mm: -572.3, mass_kg: 3.87, center_mm: [240, 0, 68]}}
    - {{joint: wrist_1, d_mm: 163.941, alpha_deg: 90, mass_kg: 1.96, center_mm: [0, 7, 18]}}
    - {{joint: wrist_2, d_mm: 115.7, alpha_deg: -90, mass_kg: 1.96, center_mm: [0, 7, 18]}}
    - {{joint: wrist_3, d_mm: 92.2, mass_kg: 0.202, center_mm: [0, 0, -26]}}
identify: [{identify}]
payloads: {{probe: {{mass_kg: 1.5, center_mm: [0, 0, 80]}}}}
experiments: {{payload: probe}}
instrument: {{sigma_mm: 0.02}}
"""
_MAPPING = """\
elastocal: 1
files: [{{}}, {{join: line, columns: {{line: file line}}}}]
keep: {{use: [{use}]}}
columns:
  q [rad]: [shoulder_pan_joint, shoulder_lift_joint, elbow_joint, wrist_1_joint, wrist_2_joint,
            wrist_3_joint]
  x y z [mm]: [measurement_x, measurement_y, measurement_z]
  ux uy uz [mm]: [measurement_std_x, measurement_std_y, measurement_std_z]
"""
_MODELS = (
    ("base, tool",),
    ("base, tool, shoulder_lift, elbow",),
    ("base, tool, geometry",),
    ("base, tool, geometry, shoulder_lift, elbow",),
    ("base, tool, geometry, shoulder_lift, elbow, wrist_1, wrist_2",),
)


def study_of(identify: str, folder: Path) -> AbsoluteStudy:
    """The study that identifies these."""
    file = folder / "study.yaml"
    file.write_text(_STUDY.format(identify=identify), encoding="utf-8")
    return read_absolute_study(file)


def rows_of(data: Path, use: str, study: AbsoluteStudy, folder: Path) -> Positions:
    """The rows of the series that are for this use."""
    file = folder / f"{use}.yaml"
    file.write_text(_MAPPING.format(use=use), encoding="utf-8")
    return read_positions([data / "series_b.csv", data / "split_b.csv"], study, file)


def fitted(study: AbsoluteStudy, positions: Positions) -> Calibration:
    """The calibration of a study."""
    model = arm_model(study)
    return calibrate(model, positions, unknowns_of(study, model, positions))


def elsewhere(positions: Positions, rng: np.random.Generator) -> Positions:
    """The same readings of a tracker that stands somewhere else."""
    turn = from_rotation_vectors(np.pi * rng.uniform(-1, 1, (1, 3)))[0]
    return replace(positions, value=positions.value @ turn.T + rng.uniform(-5, 5, 3))


def many(found: Calibration, count: int, rng: np.random.Generator) -> Positions:
    """So many virtual rows of the arm that was found."""
    poses = rng.integers(0, len(found.positions.cases), count)
    q = found.positions.cases.q[poses] + rng.uniform(-0.3, 0.3, (count, 6))
    empty = replace(
        found.positions,
        cases=LoadCases(q, np.zeros((count, 6))),
        names=tuple(map(str, range(count))),
        case=np.arange(count),
        marker=np.zeros(count),
        station=np.zeros(count),
        mounting=np.zeros(count),
        payload=np.zeros(count),
        time=np.zeros(0),
        value=np.zeros((count, 3)),
        covariance=np.tile(4e-10 * np.eye(3), (count, 1, 1)),
    )
    there = -predicted(found.model, empty, found.parameters, found.state).error
    return replace(empty, value=there + 2e-5 * rng.normal(size=there.shape))


def millimetres(errors: Array) -> str:
    return f"{1e3 * rms_of(errors):.4f}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--frames", type=int, default=100)
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    print(
        "| identified | unknowns | told | fit mm | left out mm | other rows mm | seconds of CPU |"
    )
    print("|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        there = Path(folder)
        for (identify,) in _MODELS:
            study = study_of(identify, there)
            fit, other = (rows_of(options.folder, use, study, there) for use in ("fit", "other"))
            start = time.process_time()
            found = fitted(study, fit)
            seconds = time.process_time() - start
            error = check(put_away(found), other).error
            cells = [
                identify,
                str(len(found.parameters)),
                str(found.redundancy.told),
                *map(millimetres, (found.error, found.left_out, error)),
                f"{seconds:.2f}",
            ]
            print(f"| {' | '.join(cells)} |")
            for name, u in zip(study.springs.names, found.parameters.of("compliance"), strict=True):
                k = found.state.compliance[study.springs.names.index(name)]
                print(f"  {name}: {1e6 * k:.2f} ± {1e6 * found.standard_error[u]:.2f} µrad/(N·m)")
        study = study_of("base, tool, geometry, shoulder_lift, elbow", there)
        found = fitted(study, fit)
        right = wrong = 0
        for _ in range(options.frames):
            again = fitted(study, elsewhere(fit, rng))
            same = abs(rms_of(again.error) - rms_of(found.error)) < 1e-6
            right, wrong = right + same, wrong + (not same)
        print(f"\n{options.frames} other frames of the tracker: {right} right, {wrong} wrong")
        rows = many(found, 20_000, rng)
        start = time.process_time()
        large = fitted(study, rows)
        seconds = time.process_time() - start
        print(f"20 000 rows: {seconds:.1f} s of CPU, fit {millimetres(large.error)} mm")


if __name__ == "__main__":
    main()
