"""A task of several poses: plan for their mean error, or for the worst of them.

The tool mills along a path at four places. `test-pose` makes the mean square error over them
small, `worst` the largest error.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import elastocal as ec

STUDY = Path(__file__).parent / "kr270" / "study.yaml"
BEGIN = np.array([0.0, -75.0, 120.0, 45.0, 76.0, 57.0])  # degrees
END = np.array([0.0, -25.0, 40.0, 20.0, 35.0, 57.0])
FORCE = [0.0, 280.0, -180.0, 0.0, 0.0, 0.0]  # N, N·m


def along_the_path(study: ec.Study, places: int) -> ec.Study:
    """The study with test poses at equal distances between BEGIN and END."""
    milling = study.robot.tools["milling"]
    poses = []
    for i, share in enumerate(np.linspace(0.0, 1.0, places)):
        case = ec.LoadCases(np.radians([(1.0 - share) * BEGIN + share * END]), [FORCE])
        name = f"place {i + 1}"
        poses.append(ec.test_pose(replace(study.arm, tool=milling), case, 1.0, name))
    return replace(study, test_poses=tuple(poses))


def main() -> None:
    study = along_the_path(ec.read_study(STUDY), 4)
    print(
        "planned for    error at each place [µm]                     mean    worst   no plan below"
    )
    for criterion in ("test-pose", "worst"):
        plan = ec.plan(replace(study, criterion=criterion), seed=0)
        worth = plan.assessment
        each = " ".join(f"{1e6 * rho0:7.3f}" for rho0 in worth.rho0_each)
        figures = (worth.rho0, worth.criteria["worst"], plan.certificate.lower_bound)
        mean, worst, bound = (f"{1e6 * figure:7.3f}" for figure in figures)
        print(f"{criterion:12s} {each} {mean}  {worst} {bound} ({criterion})")


if __name__ == "__main__":
    main()
