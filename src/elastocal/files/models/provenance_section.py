"""The section `provenance` of a model file: hashes of everything a model was made from."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

from elastocal.files.models.model_file import model_sections
from elastocal.files.plans.plan_file import study_hash
from elastocal.measuring.measurements import Measurements
from elastocal.study.study import Study


def provenance_section(study: Study, data: Measurements, *models: Path | None) -> dict[str, Any]:
    """Study, measurements, and the other models that were used; None stands for no model."""
    return {
        "study": {"name": study.name, "sha256": study_hash(study)},
        "measurements": {"name": data.source, "sha256": data.sha256},
        "models": _models(models),
    }


def made_from(path: Path, data: Measurements) -> bool:
    """Whether the model in a file says that it was made from these measurements."""
    measurements = model_sections(path).get("provenance", {}).get("measurements", {})
    return bool(data.sha256) and measurements.get("sha256") == data.sha256


def made_with(path: Path, *models: Path | None) -> bool:
    """Whether the model in a file says that these and no other models were used."""
    return bool(model_sections(path).get("provenance", {}).get("models", []) == _models(models))


def _models(paths: tuple[Path | None, ...]) -> list[dict[str, str]]:
    return [
        {"name": path.name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}
        for path in paths
        if path is not None
    ]
