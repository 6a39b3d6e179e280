"""The model file of an identification, with how it was found and what it was made from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from elastocal.files.models.identification_section import identification_sections
from elastocal.files.models.provenance_section import provenance_section
from elastocal.files.models.stiffness_section import pose_entries
from elastocal.files.models.writing import model_document, write_model
from elastocal.identification.result import Identification
from elastocal.identification.search import Searched
from elastocal.study.at_test_poses import at_test_poses
from elastocal.study.study import Study


def write_identification(
    study: Study,
    identification: Identification,
    out: Path,
    prior: Path | None = None,
    beyond: Searched | None = None,
) -> dict[str, Any]:
    """Write the model with all that was found out; `prior` and what the study knows are named."""
    data, sections = identification.measurements, identification_sections(identification, beyond)
    there = at_test_poses(study, identification.model, identification.width)
    sections["diagnostics"]["test_poses"] = pose_entries(there)
    origin = provenance_section(study, data, prior)
    how = {"provenance": origin, "sections": sections}
    write_model(identification.model, out, study.robot, **how)
    return model_document(identification.model, study.robot, **how)
