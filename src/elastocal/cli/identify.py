"""`identify` and `validate`: from measurements to a model, and whether it holds."""

from __future__ import annotations

import hashlib
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal.cli.common import Json, StudyPath, app, guarded, print_json, study_at, writable
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.elastic.compliance_model import ComplianceModel
    from elastocal.identification.result import Identification
    from elastocal.measuring.measurements import Measurements
    from elastocal.study.study import Study


class Model(StrEnum):
    """What the deflections are fitted with."""

    equilibrium = "equilibrium"
    linear = "linear"


class Sigma(StrEnum):
    """Whether the noise is known."""

    known = "known"
    estimated = "estimated"


class Losses(StrEnum):
    """How outlying readings count."""

    squares = "squares"
    huber = "huber"
    bisquare = "bisquare"


Readings = Annotated[
    list[Path],
    typer.Argument(metavar="MEASUREMENTS", help="Measured deflections (CSV).", show_default=False),
]

Mapping = Annotated[
    Path | None, typer.Option(help="What foreign columns mean (YAML).", show_default=False)
]
Prior = Annotated[Path | None, typer.Option(help="Model from before, weighed by its covariance.")]
Known = Annotated[Path | None, typer.Option(help="Model of further joints, taken as it is.")]


@app.command()
@guarded
def identify(
    study: StudyPath,
    measurements: Readings,
    out: Annotated[Path, typer.Option("--out", "-o", help="Model to write.")] = Path("model.json"),
    model: Annotated[
        Model, typer.Option(help="Equilibrium under load, or the linear model of the paper.")
    ] = Model.equilibrium,
    sigma: Annotated[
        Sigma, typer.Option(help="Noise as promised, or estimated from the residuals.")
    ] = Sigma.known,
    loss: Annotated[Losses, typer.Option(help="How outlying readings count.")] = Losses.squares,
    nonnegative: Annotated[
        bool, typer.Option("--nonnegative", help="Rule out compliances below zero.")
    ] = False,
    mapping: Mapping = None,
    prior: Prior = None,
    known: Known = None,
    confidence: Annotated[float, typer.Option(help="Confidence of the intervals.")] = 0.95,
    as_json: Json = False,
) -> None:
    """Identify the compliances from measurements; write model.json."""
    from elastocal.files.models.identification_section import identification_sections
    from elastocal.files.models.model_file import model_document, write_model
    from elastocal.identification.fit import Fit
    from elastocal.identification.identify import identify as fit

    models = [file for file in (mapping, prior, known) if file is not None]
    writable(out, study, *measurements, *models, suffix=".json")
    what = study_at(study)
    data = readings(what, measurements, mapping)
    if not as_json:  # before the fit: what looks odd explains why a fit fails
        show_remarks(data)
    found = fit(
        what.arm,
        data,
        Fit(model.value, sigma.value, loss.value, nonnegative, confidence),
        prior=model_at(prior, what),
        known=model_at(known, what),
    )
    sections, origin = identification_sections(found), provenance(what, data, prior, known)
    write_model(found.model, out, what.robot, provenance=origin, sections=sections)
    if as_json:
        print_json(model_document(found.model, what.robot, provenance=origin, sections=sections))
        return
    from elastocal.terminal.identifications import show_identification

    show_identification(found)
    print(f"wrote {out}")


def show_remarks(data: Measurements) -> None:
    """What looks odd in readings."""
    from rich.text import Text

    from elastocal.terminal.console import out

    for remark in data.remarks:
        out.print(Text(f"Note: {remark}" + ("" if remark[-1:] in ".?" else "."), style="yellow"))


def readings(study: Study, paths: list[Path], mapping: Path | None = None) -> Measurements:
    """The readings in one file, or in several that belong together."""
    from elastocal.files.measurements.measurement_file import read_measurements

    chosen: Any = paths[0] if len(paths) == 1 else paths
    return read_measurements(chosen, study, mapping)


def provenance(study: Study, data: Measurements, *models: Path | None) -> dict[str, Any]:
    """Hashes of everything a model was made from."""
    from elastocal.files.plans.plan_file import study_hash

    return {
        "study": {"name": study.name, "sha256": study_hash(study)},
        "measurements": {"name": data.source, "sha256": data.sha256},
        "models": [
            {"name": path.name, "sha256": hashlib.sha256(path.read_bytes()).hexdigest()}
            for path in models
            if path is not None
        ],
    }


@app.command()
@guarded
def validate(
    study: StudyPath,
    model: Annotated[Path, typer.Argument(help="Model (JSON).", show_default=False)],
    measurements: Readings,
    mapping: Mapping = None,
    prior: Prior = None,
    known: Known = None,
    confidence: Annotated[float, typer.Option(help="Confidence of the predictions.")] = 0.95,
    as_json: Json = False,
) -> None:
    """Compare a model with experiments; with those it was made from, each is left out in turn."""
    from elastocal.files.measurements.suspicious import kept_aside
    from elastocal.files.models.identification_section import validation_document
    from elastocal.files.models.model_file import model_sections, read_model
    from elastocal.identification.validation import Validation, leave_one_out
    from elastocal.identification.validation import validate as compare

    what = study_at(study)
    data = readings(what, measurements, mapping)
    sections = model_sections(model)
    origin = sections.get("provenance", {})
    found: Validation
    if data.sha256 and origin.get("measurements", {}).get("sha256") == data.sha256:
        given = provenance(what, data, prior, known)["models"]
        if origin.get("models", []) != given:
            raise InputError(
                f"{model}: was fitted to these measurements with a prior or known joints; leaving "
                "experiments out in turn needs the same --prior and --known"
            )
        again = fitted_again(what, data, sections, model_at(prior, what), model_at(known, what))
        found = leave_one_out(again, confidence=confidence)
    else:
        data = kept_aside(data, what)
        found = compare(what.arm, read_model(model, what.robot), data, confidence=confidence)
    if as_json:
        print_json(validation_document(found))
        return
    from elastocal.terminal.identifications import show_validation

    show_remarks(data)
    show_validation(found)


def model_at(path: Path | None, study: Study) -> ComplianceModel | None:
    """The model in a file, None if no file is named."""
    from elastocal.files.models.model_file import read_model

    return None if path is None else read_model(path, study.robot)


def fitted_again(
    study: Study,
    data: Measurements,
    sections: dict[str, Any],
    prior: ComplianceModel | None,
    known: ComplianceModel | None,
    confidence: float = 0.95,
) -> Identification:
    """The fit that made a model, once more; by default settings if its `sections` do not say."""
    from elastocal.identification.fit import Fit
    from elastocal.identification.identify import identify as fit

    how = sections.get("identification", {})
    chosen = Fit(
        how.get("model", "equilibrium"),
        how.get("sigma", "known"),
        how.get("loss", "squares"),
        bool(how.get("nonnegative", False)),
        confidence,
    )
    return fit(study.arm, data, chosen, prior=prior, known=known)
