"""`simulate`: a virtual campaign as a measurement file, or many of them to compare plans."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal.cli.common import (
    Json,
    Seed,
    StudyPath,
    app,
    guarded,
    print_json,
    progress,
    study_at,
    writable,
)
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.elastic.compliance_model import ComplianceModel
    from elastocal.study.study import Study


@app.command()
@guarded
def simulate(
    study: StudyPath,
    plans: Annotated[
        list[Path],
        typer.Argument(help="Plan (JSON or CSV); with --campaigns several.", show_default=False),
    ],
    truth: Annotated[
        Path, typer.Option(help="True compliances, a model file.", show_default=False)
    ],
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            help="File to write: measurements.csv, or campaigns.json with --campaigns.",
            show_default=False,
        ),
    ] = None,
    linear: Annotated[
        bool, typer.Option("--linear", help="Deflections of the linear model, for statistics.")
    ] = False,
    load_error_percent: Annotated[
        float, typer.Option(help="Standard deviation of the size of the load, unrecorded.", min=0)
    ] = 0.0,
    load_direction_deg: Annotated[
        float, typer.Option(help="Standard deviation of the tilt of the load, unrecorded.", min=0)
    ] = 0.0,
    outliers_percent: Annotated[
        float, typer.Option(help="Share of grossly wrong readings.", min=0, max=100)
    ] = 0.0,
    outlier_mm: Annotated[float, typer.Option(help="How wrong they are.", min=0)] = 1.0,
    campaigns: Annotated[
        int | None, typer.Option(help="Campaigns of each plan: simulate, identify, judge.")
    ] = None,
    fit: Annotated[str, typer.Option(help="Fit of the campaigns: equilibrium or linear.")] = (
        "equilibrium"
    ),
    sigma: Annotated[str, typer.Option(help="σ of the campaigns: known or estimated.")] = "known",
    workers: Annotated[int, typer.Option(help="Processes for the campaigns.", min=1)] = 1,
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Simulate what a plan would measure on a robot whose compliances are known."""
    import numpy as np

    from elastocal.files.models.model_file import read_model
    from elastocal.simulation.virtual_campaign import LoadError, Outliers

    many = campaigns is not None
    out = out or Path("campaigns.json" if many else "measurements.csv")
    writable(out, study, truth, *plans, suffix=".json" if many else ".csv")
    what = study_at(study)
    true = read_model(truth, what.robot)
    errors = {
        "load_error": LoadError(load_error_percent / 100.0, float(np.radians(load_direction_deg))),
        "outliers": Outliers(outliers_percent / 100.0, outlier_mm / 1e3),
        "linear": linear,
    }
    if campaigns is None:
        _one(what, plans, true, out, seed, errors, as_json)
        return
    how = {"model": fit, "sigma": sigma}
    _many(what, plans, true, out, (campaigns, seed, workers), how, errors, as_json)


def _one(
    study: Study,
    plans: list[Path],
    truth: ComplianceModel,
    out: Path,
    seed: int,
    errors: dict[str, Any],
    as_json: bool,
) -> None:
    """Write the measurements of one virtual campaign."""
    import numpy as np

    from elastocal.files.measurements.measurement_file import write_measurements
    from elastocal.files.plans.proposal_file import read_proposal
    from elastocal.simulation.virtual_campaign import simulate as run

    if len(plans) != 1:
        raise InputError(f"one campaign needs one plan, found {len(plans)}; see --campaigns")
    plan = read_proposal(plans[0], study)
    rng = np.random.default_rng(seed)
    made = run(study, truth, plan.load_cases, plan.repeats, rng, **errors)
    write_measurements(made, study.robot, out)
    largest = float(np.linalg.norm(made.deflection, axis=1).max())
    if as_json:
        print_json(
            {
                "experiments": len(made.cases),
                "readings": len(made),
                "largest_deflection_mm": 1e3 * largest,
                "source": made.source,
            }
        )
    else:
        print(
            f"wrote {out}: {len(made.cases)} experiments, {len(made)} readings, deflections up "
            f"to {1e3 * largest:.4g} mm"
        )


def _many(
    study: Study,
    plans: list[Path],
    truth: ComplianceModel,
    out: Path,
    run: tuple[int, int, int],
    how: dict[str, Any],
    errors: dict[str, Any],
    as_json: bool,
) -> None:
    """Compare plans by many virtual campaigns."""
    from elastocal.files.models.campaign_file import campaigns_document, write_campaigns
    from elastocal.files.plans.proposal_file import read_proposal
    from elastocal.identification.fit import Fit
    from elastocal.simulation.monte_carlo import campaigns

    named = {}
    for path in plans:
        plan = read_proposal(path, study)
        named[path.name if path.name not in named else str(path)] = (plan.load_cases, plan.repeats)
    number, seed, workers = run
    with progress("campaigns") as tell:
        found = campaigns(
            study,
            truth,
            named,
            number,
            seed=seed,
            workers=workers,
            how=Fit(**how),
            progress=tell,
            **errors,
        )
    write_campaigns(found, study.springs, out)
    if as_json:
        print_json(campaigns_document(found, study.springs))
        return
    from elastocal.terminal.campaigns import show_campaigns

    show_campaigns(found)
    print(f"wrote {out}")
