"""The section `provenance` of a model file: hashes of everything a model was made from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from elastocal.files.models.model_file import model_sections, readings_in
from elastocal.files.models.reading_marks import reading_marks
from elastocal.files.texts import file_hash, text_hash
from elastocal.measuring.measurements import Measurements
from elastocal.study.known import Known
from elastocal.study.study import Study


def provenance_section(study: Study, data: Measurements, prior: Path | None) -> dict[str, Any]:
    """Study, measurements, and the other models that were used: a prior, what the study knows.

    Every file with readings that any of them counts is named by its hash, so that none can count
    twice, however far back.
    """
    before = {
        *(readings_in(prior) if prior else ()),
        *(study.known.readings if study.known else ()),
    }
    return {
        "study": {"name": study.name, "sha256": text_hash(study.text)},
        "measurements": {"name": data.source, "sha256": data.sha256},
        "models": _models(prior, study.known),
        "readings": sorted({*data.readings, *before}),
        "marks": reading_marks(data),
    }


def made_from(path: Path, data: Measurements) -> bool:
    """Whether the model in a file says that it was made from these measurements."""
    named = model_sections(path)["provenance"].get("measurements") or {}
    return bool(data.sha256) and named.get("sha256") == data.sha256


def made_with(path: Path, prior: Path | None, known: Known | None) -> bool:
    """Whether the model in a file says that these and no other models were used."""
    used = model_sections(path)["provenance"].get("models") or []
    return [one.get("sha256") for one in used] == [one["sha256"] for one in _models(prior, known)]


def _models(prior: Path | None, known: Known | None) -> list[dict[str, str]]:
    models = []
    if prior is not None:
        models.append({"name": prior.name, "sha256": file_hash(prior)})
    if known is not None:
        models.append({"name": Path(known.source).name, "sha256": known.sha256})
    return models
