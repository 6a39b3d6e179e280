"""The KR 270 campaigns of the paper with a truth, for tests of statistics."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from elastocal.constraints import Clearance
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.files.models.model_file import read_model
from elastocal.files.study.study_file import read_study
from elastocal.study.study import Study
from tests.paper.published import CALIBRATION_FORCE, TABLE_5

FOLDER = Path(__file__).parents[1] / "examples" / "kr270"


def kr270_study() -> Study:
    """As in the paper, which asks nothing of the links and of the floor."""
    study = read_study(FOLDER / "study.yaml")
    asked = tuple(c for c in study.constraints if not isinstance(c, Clearance))
    return replace(study, constraints=asked)


def kr270_truth(study: Study) -> ComplianceModel:
    return read_model(FOLDER / "truth.json", study.robot)


def published_cases(m: int, force: np.ndarray = CALIBRATION_FORCE) -> LoadCases:
    """The m load cases of a row of Table 5."""
    q = np.radians([[0.0, *row] for row in TABLE_5[m]])
    return LoadCases(q, np.tile([*force, 0.0, 0.0, 0.0], (m, 1)))


def published_plans(experiments: int = 12) -> dict[str, tuple[LoadCases, np.ndarray]]:
    """The plans of Table 5, each repeated to as many experiments."""
    return {
        f"{m} configurations": (published_cases(m), np.full(m, experiments // m)) for m in TABLE_5
    }
