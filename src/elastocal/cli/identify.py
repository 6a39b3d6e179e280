"""`identify` and `validate`: from measurements to a model, and whether it holds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from elastocal.cli.common import (
    Json,
    Known,
    Mapping,
    Overwrite,
    Planned,
    Prior,
    Readings,
    StudyPath,
    app,
    print_json,
    replaceable,
    writable,
)
from elastocal.errors import InputError
from elastocal.identification.choices import Fitted, LossName, Model, Sigma


@app.command("identify")
def identify_command(
    study_file: StudyPath,
    measurements: Readings,
    out: Annotated[Path, typer.Option("--out", "-o", help="Model to write.")] = Path("model.json"),
    model: Annotated[
        Model, typer.Option(help="Equilibrium under load, or the linear model of the paper.")
    ] = "equilibrium",
    sigma: Annotated[
        Sigma, typer.Option(help="Noise as promised, or estimated from the residuals.")
    ] = "known",
    loss: Annotated[LossName, typer.Option(help="How outlying readings count.")] = "squares",
    fit: Annotated[
        Fitted,
        typer.Option(help="With the nuisance of the study, if it has any, or the joints alone."),
    ] = "mixed",
    nonnegative: Annotated[
        bool, typer.Option("--nonnegative", help="Rule out compliances below zero.")
    ] = False,
    mapping: Mapping = None,
    plan: Planned = None,
    prior: Prior = None,
    known: Known = None,
    confidence: Annotated[float, typer.Option(help="Confidence of the intervals.")] = 0.95,
    search: Annotated[
        bool, typer.Option("--search/--no-search", help="Look for what else explains them.")
    ] = True,
    force: Overwrite = False,
    as_json: Json = False,
) -> None:
    """Identify the compliances from measurements; write model.json."""
    from elastocal.files.study.absolute_file import is_absolute

    given = [
        study_file,
        *measurements,
        *(f for f in (mapping, plan, prior, known) if f is not None),
    ]
    writable(out, *given, suffix=".json")
    if is_absolute(study_file):
        from elastocal.cli.absolute import calibrate_command

        refused = {"--prior": prior, "--known": known, "--nonnegative": nonnegative or None}
        calibrate_command(
            study_file,
            measurements,
            mapping,
            out,
            loss,
            refused,
            plan=plan,
            force=force,
            as_json=as_json,
        )
        return
    from elastocal.cli.inputs import (
        known_in,
        known_model,
        sources_of,
    )
    from elastocal.cli.measured import readings, refuse_twice
    from elastocal.cli.refit import fitted
    from elastocal.files.models.identification_file import write_identification
    from elastocal.files.study.study_file import read_study
    from elastocal.identification.fit import Fit
    from elastocal.identification.search import searched
    from elastocal.terminal.fitted_along import in_short

    study = read_study(study_file, known_in(known))
    if study.known is not None and known is None:
        known = study_file.parent / study.known.source
    writable(out, *sources_of(study, study_file, known))
    replaceable(out, "model", force=force)
    known_compliances = known_model(None, study)
    data = readings(study, measurements, mapping, plan)
    refuse_twice(data, prior, study.known)
    if not as_json:  # before the fit: what looks odd explains why a fit fails
        from elastocal.terminal.measurements import show_remarks

        show_remarks(data)
    how = Fit(model, sigma, loss, nonnegative, confidence, fit)
    identification = fitted(study, data, how, prior, known_compliances)
    beyond = searched(identification, study.coupling) if search else None
    document = write_identification(study, identification, out, prior, beyond)
    if as_json:
        print_json(document)
        return
    from elastocal.study.at_test_poses import at_test_poses
    from elastocal.terminal.identifications import show_identification
    from elastocal.terminal.stiffness import show_errors_left, show_stiffness

    show_identification(identification, beyond)
    there = at_test_poses(study, identification.model, identification.width)
    show_errors_left(there, in_short(identification), nuisance=identification.nuisance is not None)
    show_stiffness(there)
    print(f"wrote {out}")


@app.command("validate")
def validate_command(
    study_file: StudyPath,
    model: Annotated[Path, typer.Argument(help="Model (JSON).", show_default=False)],
    measurements: Readings,
    mapping: Mapping = None,
    plan: Planned = None,
    prior: Prior = None,
    known: Known = None,
    set_up: Annotated[
        int | None,
        typer.Option(
            help="Of absolute readings: poses to find base and tool from, for another series.",
            min=1,
        ),
    ] = None,
    confidence: Annotated[float, typer.Option(help="Confidence of the predictions.")] = 0.95,
    as_json: Json = False,
) -> None:
    """Compare a model with experiments; with those it was made from, each is left out in turn."""
    from elastocal.files.study.absolute_file import is_absolute

    if is_absolute(study_file):
        from elastocal.cli.absolute import check_command

        check_command(study_file, model, measurements, mapping, set_up, plan=plan, as_json=as_json)
        return
    if set_up is not None:
        raise InputError("--set-up is for studies of absolute readings; deflections need no base")
    from elastocal.cli.inputs import errors_of, fit_of, identified_cases, known_in, known_model
    from elastocal.cli.measured import readings
    from elastocal.cli.origins import note_measurements, note_model
    from elastocal.cli.refit import refit
    from elastocal.files.measurements.suspicious import kept_aside
    from elastocal.files.models.identification_section import validation_document
    from elastocal.files.models.model_file import read_model
    from elastocal.files.models.provenance_section import made_from, made_with
    from elastocal.files.models.reading_marks import without_used
    from elastocal.files.study.study_file import read_study
    from elastocal.identification.validation import leave_one_out, validate

    study = read_study(study_file, known_in(known))
    data = readings(study, measurements, mapping, plan)
    note_model(model, study)
    if made_from(model, data):
        if not made_with(model, prior, study.known):
            raise InputError(
                f"{model}: was fitted to these measurements with a prior or known joints; leaving "
                "experiments out in turn needs the same --prior and --known"
            )
        again = refit(study, data, fit_of(model), model, prior, known_model(None, study))
        validation = leave_one_out(again, confidence=confidence)
    else:
        data = without_used(kept_aside(data), model)
        given = read_model(model, study.robot)
        note_measurements(model, data)
        before = identified_cases(model, study.robot)
        errors = errors_of(study) if fit_of(model).fitted == "mixed" else None
        validation = validate(
            study.arm, given, data, confidence=confidence, identified=before, errors=errors
        )
    if as_json:
        print_json(validation_document(validation))
        return
    from elastocal.terminal.identifications import show_validation
    from elastocal.terminal.measurements import show_remarks

    show_remarks(data)
    show_validation(validation)
