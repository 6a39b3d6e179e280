"""A measured heavy arm: what is promised of poses that were not used, and what is seen.

    python benchmarks/measured_arm.py FOLDER [--splits 300]

The folder has three tables of 43 poses of a FANUC R-2000iC pulled by a cable, matched by row, as
published (MIT) by longton2001-pixel, breakthrough-surge-suppression-in-high-speed-robotic-drilling,
`data/stiffness_data/`: joint_angles.csv (controller, rad), forces.csv (N, base), deltaX.csv (m).
They are not part of this repository.

Printed, for campaigns of 6 to 42 of the poses: the error of predictions of the others by the
joints alone and by the mixed fit with the preset `typical`, and what each promises; then the joints
alone with the noise of the instrument known and estimated, as `compensate` would promise.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.nuisance import Nuisance
from elastocal.files.measurements.measurement_file import read_measurements
from elastocal.files.study.study_file import read_study
from elastocal.identification.fit import Fit
from elastocal.identification.identify import identify
from elastocal.identification.left_out_error import left_out_error
from elastocal.identification.validation import validate
from elastocal.measuring.measurements import Measurements, chosen
from elastocal.study.study import Study

_STUDY = """\
elastocal: 1
name: FANUC R-2000iC, 43 loaded poses
robot:
  name: r2000ic
  convention: modified
  dh:
    - {joint: joint_1, d_mm: 670, limits_deg: [-185, 185]}
    - {joint: joint_2, a_mm: 312, alpha_deg: -90, theta_deg: -90, limits_deg: [-60, 76]}
    - {joint: joint_3, a_mm: 1075, limits_deg: [-132, 172]}
    - {joint: joint_4, a_mm: 225, alpha_deg: -90, d_mm: 1280, limits_deg: [-360, 360]}
    - {joint: joint_5, alpha_deg: 90, limits_deg: [-125, 125]}
    - {joint: joint_6, alpha_deg: -90, d_mm: 215, limits_deg: [-360, 360]}
controller:
  signs: {joint_3: -1, joint_4: -1, joint_5: -1, joint_6: -1}
  couple: {joint_3: {joint_2: -1}}
tools:
  spindle: {tcp_mm: [6.9, 245.3, 319.3], load_point_mm: [6.9, 245.3, 319.3],
            markers_mm: {M1: [6.9, 245.3, 319.3]}}
test_poses:
  - {name: drilling, tool: spindle, q_deg: [-90, 10, 0, 0, 60, -170], force_N: [0, 300, -500]}
experiments: {tool: spindle, max_force_N: 1200, direction: free, count: 43}
instrument: {sigma_mm: 0.03}
constraints: {collision: off, floor: off}
nuisance:
  preset: typical
  compliance_urad_per_Nm: {joint_1: 1.16, joint_2: .368, joint_3: .51,
                           joint_4: 3.69, joint_5: 2.355, joint_6: 4.85}
"""
_MAPPING = """\
elastocal: 1
joints: controller
columns:
  "joint_1 [rad]": theta1
  "joint_2 [rad]": theta2
  "joint_3 [rad]": theta3
  "joint_4 [rad]": theta4
  "joint_5 [rad]": theta5
  "joint_6 [rad]": theta6
  "Fx [N]": Base_Fx
  "Fy [N]": Base_Fy
  "Fz [N]": Base_Fz
  "dx [m]": deltax
  "dy [m]": deltay
  "dz [m]": deltaz
"""
_TABLES = ("joint_angles.csv", "forces.csv", "deltaX.csv")
LINEAR = Fit("linear")


def read(folder: Path) -> tuple[Study, Measurements]:
    """The arm as a study, and its readings."""
    with tempfile.TemporaryDirectory() as made:
        study, mapping = Path(made) / "study.yaml", Path(made) / "mapping.yaml"
        study.write_text(_STUDY, encoding="utf-8")
        mapping.write_text(_MAPPING, encoding="utf-8")
        known = read_study(study)
        tables = [folder / name for name in _TABLES]
        return known, read_measurements(tables, known, mapping)


def split(
    study: Study, data: Measurements, count: int, splits: int, nuisance: Nuisance
) -> tuple[float, float, float, float]:
    """Errors of predictions [m]: joints alone, mixed, promised; share of splits mixed is better."""
    rng, squares, better = np.random.default_rng(count), [], 0
    for _ in range(splits):
        used = np.zeros(len(data.cases), dtype=bool)
        used[rng.permutation(len(used))[:count]] = True
        rest = chosen(data, ~used)
        mixed = identify(study.arm, chosen(data, used), LINEAR, nuisance=nuisance)
        assert mixed.alone is not None
        by = [predicted(study, model, rest, None) for model in (mixed.alone.model,)]
        by.append(predicted(study, mixed.model, rest, nuisance))
        squares.append((by[0][0], by[1][0], by[1][1]))
        better += by[1][0] < by[0][0]
    alone, seen, promised = np.sqrt(np.mean(squares, axis=0))
    return alone, seen, promised, better / splits


def predicted(
    study: Study, model: ComplianceModel, rest: Measurements, nuisance: Nuisance | None
) -> tuple[float, float]:
    """Mean square error of readings kept aside, seen and promised [m²]."""
    found = validate(study.arm, model, rest, errors=nuisance and nuisance.errors)
    seen = np.mean(np.sum(found.after**2, axis=1))
    return float(seen), float(np.mean(np.sum(found.deviation**2, axis=1)))


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folder", type=Path, help="Folder with the three tables.")
    parser.add_argument("--splits", type=int, default=300)
    options = parser.parse_args()
    study, data = read(options.folder)
    assert study.nuisance is not None
    print("| poses used | joints alone, seen mm | mixed, seen | promised | better in |")
    print("|---|---|---|---|---|")
    for count in (6, 12, 20, 30):
        alone, seen, promised, better = split(study, data, count, options.splits, study.nuisance)
        print(
            f"| {count} | {1e3 * alone:.3f} | {1e3 * seen:.3f} | {1e3 * promised:.3f} | "
            f"{100 * better:.0f} % of {options.splits} splits |",
            flush=True,
        )
    mixed = identify(study.arm, data, LINEAR, nuisance=study.nuisance)
    assert mixed.alone is not None
    left, alone = left_out_error(mixed), left_out_error(mixed.alone)
    print(
        f"| 42, leave one out | {1e3 * alone.seen:.3f} | {1e3 * left.seen:.3f} | "
        f"{1e3 * left.promised:.3f} | |\n"
    )
    half = replace(study.nuisance, deviation=0.5 * study.nuisance.deviation)
    twice = replace(study.nuisance, deviation=2.0 * study.nuisance.deviation)
    for name, other in (("halved", half), ("doubled", twice)):
        left = left_out_error(identify(study.arm, data, LINEAR, nuisance=other))
        print(f"springs {name}: left out {1e3 * left.seen:.3f} mm")
    for sigma in ("known", "estimated"):
        joints = identify(study.arm, data, Fit("linear", sigma))
        left = left_out_error(joints)
        print(
            f"joints alone, sigma {sigma}: left out {1e3 * left.seen:.3f} mm, of which the noise "
            f"and the fit promise {1e3 * left.promised:.3f}; carried into promises: "
            f"{1e3 * joints.model.model_error:.3f} mm"
        )


if __name__ == "__main__":
    main()
