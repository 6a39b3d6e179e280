"""What a plan is worth along the paths of a study, as entries of documents for programs."""

from __future__ import annotations

from typing import Any

from elastocal.planning.assessment import Assessment
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath


def path_entries(study: Study, worth: Assessment) -> dict[str, dict[str, Any]]:
    """Points and worst point of each path, by its name: millimetres."""
    entries = {}
    for pose, worst in zip(study.test_poses, worth.worst_points, strict=True):
        if isinstance(pose, TestPath) and worst is not None:
            entries[pose.name] = {
                "points": len(pose.cases),
                "worst_mm": 1e3 * worst.rho0,
                "worst_point": worst.name,
            }
    return entries
