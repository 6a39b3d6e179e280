"""Makes the readings of this folder: a true arm that no table made, and what a tracker reads on it.

Every frame is a little off, joints and weights bend it, joints wave with their turns and never
stand quite alike; the tracker drifts, and two of a hundred readings are bad. In the second series,
without bad ones, it stands elsewhere, and the reflectors are mounted anew.
"""

from __future__ import annotations

import csv
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.elastic.springs import joint_springs
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.measuring.positions import Positions
from elastocal.robot.rotations import from_rotation_vectors
from elastocal.simulation.absolute_campaign import (
    AbsoluteTruth,
    Foot,
    TrueStation,
    Visits,
    alike,
    simulated_positions,
)
from elastocal.simulation.absolute_truth import TrueArm, drawn_displacements
from elastocal.simulation.virtual_campaign import Outliers

FOLDER = Path(__file__).parent
COMPLIANCES = np.array([0.5, 0.9, 1.3, 4.2, 5.1, 6.4]) * 1e-6  # rad/(N·m)
FOOT = np.array([[0.5, 0.4, 0.05], [0.5, -0.4, 0.05], [-0.4, 0.4, 0.1], [-0.4, -0.4, 0.3]])
SIGMA = 15e-6  # m


def main(folder: Path) -> None:
    """Two series, each of a file of the tracker and one of the controller."""
    study = read_absolute_study(FOLDER / "study.yaml")
    rng = np.random.default_rng(2026)
    robot = study.robot
    arm = TrueArm(
        robot,
        drawn_displacements(robot, 3e-4, 4e-4, rng),
        joint_springs(robot),
        COMPLIANCES,
        study.gravity,
        study.payloads,
        wave=np.full(6, 4e-6),
        waves=np.array([2.0, 3.0, 2.0, 3.0, 2.0, 4.0]),
        phase=rng.uniform(0.0, 2.0 * np.pi, 6),
        loose=np.full(6, 8e-6),
    )
    drift = np.array([4e-8, -6e-8, 1e-8, 1e-8, 0.0, 2e-8])  # m/s, rad/s
    for name, poses, turn, at in (
        ("calibrate", 60, [0.01, -0.02, 2.3], [2.9, 1.4, -0.6]),
        ("check", 25, [0.0, 0.01, -0.8], [3.4, -1.1, -0.5]),
    ):
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = from_rotation_vectors(np.array([turn]))[0], at
        markers = study.tool.markers + 2e-3 * rng.normal(size=(3, 3))
        truth = AbsoluteTruth(arm, markers[None], (TrueStation(T, drift),), foot=Foot(FOOT, 6))
        low, high = 0.9 * robot.lower, 0.9 * robot.upper
        q = np.radians(np.round(np.degrees(rng.uniform(low, high, (poses, 6))), 3))
        visits = Visits(q, payload=np.arange(poses) % 2 - 1)
        read = simulated_positions(
            truth,
            replace(study.tool, rotation=False),
            visits,
            rng,
            covariance=alike(SIGMA),
            outliers=Outliers(0.02, 1e-3) if name == "calibrate" else None,
            seconds=9.0,
        )
        write(read, folder / f"{name}_tracker.csv", folder / f"{name}_joints.csv")


def write(read: Positions, tracker: Path, joints: Path) -> None:
    """The files of tracker and controller, in the order of the clock."""
    foot = read.foot
    assert foot is not None
    rows = [
        (time, f"P{case + 1:02d}_{read.tool.marker_names[marker]}", point)
        for time, case, marker, point in zip(
            read.time, read.case, read.marker, read.value, strict=True
        )
    ]
    rows += [
        (time, f"N{reflector + 1}", point)
        for time, reflector, point in zip(foot.time, foot.reflector, foot.position, strict=True)
    ]
    with tracker.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["Name", "Time", "X", "Y", "Z"])
        for time, name, point in sorted(rows, key=lambda row: row[0]):
            at = f"2026-05-04T{8 + int(time) // 3600:02d}:{int(time) % 3600 // 60:02d}"
            out.writerow([name, f"{at}:{int(time) % 60:02d}", *(f"{1e3 * x:.4f}" for x in point)])
    with joints.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["Pose", "A1", "A2", "A3", "A4", "A5", "A6", "Carries"])
        for i, q in enumerate(read.cases.q):
            carries = "weight" if read.payload[i] == 0 else "none"
            out.writerow([f"P{i + 1:02d}", *(f"{x:.3f}" for x in np.degrees(q)), carries])


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
