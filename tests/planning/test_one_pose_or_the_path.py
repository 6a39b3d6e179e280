"""The tables of how-to-choose: what plans for a pose and for a path are worth.

Plans as they were found with seed 0, rounded to 0.01°; what they are worth is computed here.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.planning.along_paths import better_along
from elastocal.planning.assessment import Assessment

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "how-to-choose.md").read_text("utf-8")
PLANS = {
    "the one pose": [
        (0.0, -1.6854, -3.7988, -58.2496, 39.5364, 168.8156, 2),
        (0.0, -50.7919, 63.0591, -32.5611, 101.6604, -93.7905, 7),
        (0.0, -55.4568, -72.4032, -119.3944, -56.5916, -179.2671, 3),
    ],
    "the path": [
        (0.0, -124.91, 124.67, -155.10, -49.74, 10.81, 2),
        (0.0, -51.83, -117.50, 30.45, 95.10, 89.57, 5),
        (0.0, -41.88, -15.79, 143.11, 57.85, -2.25, 5),
    ],
    "its worst point": [
        (0.0, -134.8647, 131.9391, -157.2629, -51.4344, 14.2729, 2),
        (0.0, -41.5074, -13.1316, -146.4347, 60.2201, 6.1714, 5),
        (0.0, -60.6726, -110.8070, -30.7090, 94.1604, -91.3412, 5),
    ],
}


def judged(rows: list[tuple[float, ...]]) -> Assessment:
    """What a plan is worth at the pose and along the path."""
    table = np.array(rows)
    cases = ec.LoadCases(np.radians(table[:, :6]), np.tile([0, 0, -2500, 0, 0, 0], (len(rows), 1)))
    return ec.assess(study(), cases, table[:, 6].astype(int))


def study() -> ec.Study:
    return ec.read_study(ROOT / "examples" / "kr270" / "study_path.yaml")


@pytest.mark.parametrize("name", PLANS)
def test_the_table_of_the_guide(name: str) -> None:
    (line,) = [text for text in GUIDE.splitlines() if text.startswith(f"| {name} (")]
    along, worst, pose = (float(re.sub(r"[^\d.]", "", c)) for c in line.split("|")[2:5])
    worth = judged(PLANS[name])
    at_pose, at_path = worth.rho0_each
    point = worth.worst_points[1]
    assert point is not None
    assert 1e6 * at_path == pytest.approx(along, abs=6e-4)
    assert 1e6 * point.rho0 == pytest.approx(worst, abs=6e-4)
    assert 1e6 * at_pose == pytest.approx(pose, abs=6e-4)
    assert worth.rho0 == pytest.approx(at_path, rel=1e-12)
    assert all(doubt.numbers["by"] < 1e-4 for doubt in worth.violations)  # rounded angles


def test_the_plan_for_the_path_is_better_at_most_points() -> None:
    (share,) = re.findall(r"At (\d+) % of the points", GUIDE)
    plans = {name: judged(rows) for name, rows in PLANS.items()}
    found = better_along(study(), plans)["milling path"]
    assert 100.0 * found["the path"]["the one pose"] == pytest.approx(float(share), abs=0.5)
    assert found["the one pose"]["the path"] == pytest.approx(1 - found["the path"]["the one pose"])


def test_the_study_of_the_path_is_that_of_the_pose_otherwise() -> None:
    pose = ec.read_study(ROOT / "examples" / "kr270" / "study.yaml")
    swapped = replace(study(), test_poses=pose.test_poses, name=pose.name, text=pose.text)
    for field in ("springs", "limits", "sigma", "prior"):
        assert str(getattr(swapped, field)) == str(getattr(pose, field))
    assert [c.name for c in swapped.constraints] == [c.name for c in pose.constraints]
    assert swapped.experiments.count == pose.experiments.count
    assert swapped.experiments.max_configurations == pose.experiments.max_configurations
