"""`simulate`: a virtual campaign as a measurement file, or many of them to compare plans."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast, get_args

import typer

from elastocal.cli.common import (
    Json,
    Overwrite,
    Seed,
    StudyPath,
    app,
    note_parted,
    print_json,
    replaceable,
    writable,
)
from elastocal.errors import InputError
from elastocal.identification.choices import Model, Sigma

if TYPE_CHECKING:
    from elastocal.measuring.measurements import Measurements
    from elastocal.simulation.campaigns import MonteCarlo
    from elastocal.study.study import Study


_FITS, _SIGMAS = " or ".join(get_args(Model)), " or ".join(get_args(Sigma))


@app.command("simulate")
def simulate_command(
    study_file: StudyPath,
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
    no_nuisance: Annotated[
        bool,
        typer.Option("--no-nuisance", help="A robot without what the study says of nuisance."),
    ] = False,
    truth_out: Annotated[
        Path | None,
        typer.Option(
            help="Robot that was drawn, a model file; beside the measurements if not named.",
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
    number: Annotated[
        int | None,
        typer.Option("--campaigns", help="Campaigns of each plan: simulate, identify, judge."),
    ] = None,
    fit: Annotated[str, typer.Option(help=f"Fit of the campaigns: {_FITS}.")] = "equilibrium",
    sigma: Annotated[str, typer.Option(help=f"σ of the campaigns: {_SIGMAS}.")] = "known",
    random: Annotated[
        int, typer.Option(help="Random plans beside, with campaigns of their own.", min=0)
    ] = 0,
    picture: Annotated[
        Path | None,
        typer.Option(help="Draw the errors to this file (SVG).", show_default=False),
    ] = None,
    workers: Annotated[int, typer.Option(help="Processes for the campaigns.", min=1)] = 1,
    force: Overwrite = False,
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Simulate what a plan would measure on a robot whose compliances are known.

    A study with nuisance has it on a robot that has some, too: what the truth does not say of it is
    drawn by chance, and written to a file. With that as truth further campaigns are on that robot.
    """
    import numpy as np

    from elastocal.files.study.absolute_file import is_absolute

    if is_absolute(study_file):
        from elastocal.cli.simulated import simulate_positions
        from elastocal.simulation.virtual_campaign import Outliers

        simulate_positions(
            study_file,
            plans,
            truth,
            out or Path("positions.csv"),
            truth_out,
            Outliers(outliers_percent / 100.0, outlier_mm / 1e3),
            seed,
            {
                "--campaigns": number,
                "--random": random,
                "--picture": picture,
                "--linear": linear,
                "--no-nuisance": no_nuisance,
                "--load-error-percent": load_error_percent,
                "--load-direction-deg": load_direction_deg,
            },
            force=force,
            as_json=as_json,
        )
        return
    from elastocal.cli.inputs import (
        knowing_as,
        only_proposal,
        proposals,
        sources_of,
    )
    from elastocal.cli.origins import note_origin, refuse_false_claims
    from elastocal.files.measurements.measurement_file import write_measurements
    from elastocal.files.models.campaign_file import write_campaigns
    from elastocal.files.models.truth_file import read_truth, write_truth
    from elastocal.files.plans.proposal_file import study_for
    from elastocal.files.study.study_file import read_study
    from elastocal.identification.fit import Fit
    from elastocal.simulation.monte_carlo import campaigns
    from elastocal.simulation.true_robot import true_robot
    from elastocal.simulation.virtual_campaign import LoadError, Outliers, Reality, simulate
    from elastocal.study.two_steps import with_nuisance

    out = out or Path("measurements.csv" if number is None else "campaigns.json")
    if number is None and (random or picture is not None):
        raise InputError("--random and --picture need --campaigns: how many to simulate")
    if truth_out is not None and (number is not None or no_nuisance):
        raise InputError(
            "--truth-out is the robot of one campaign with nuisance; leave it out with --campaigns "
            "and --no-nuisance"
        )
    given = [study_file, truth, *plans]
    kind, suffix = ("measurements", ".csv") if number is None else ("campaigns", ".json")
    if picture is not None:
        writable(picture, *given, suffix=".svg")
    writable(out, *given, suffix=suffix)
    study = read_study(study_file)
    for file, what in ((out, kind), (picture, "picture")):
        if file is not None:
            writable(file, *sources_of(study, study_file))
            replaceable(file, what, force=force)
    true = read_truth(truth, study.robot)
    reality = Reality(
        LoadError(load_error_percent / 100.0, float(np.radians(load_direction_deg))),
        Outliers(outliers_percent / 100.0, outlier_mm / 1e3),
        linear,
        None if no_nuisance else true.loads,
    )
    note_parted(plans)
    if number is None:
        plan = only_proposal(plans, study)
        note_origin(plan.name, plan, study, study_for(plan, study).known)
        refuse_false_claims(plan.name, plan, study)
        study = with_nuisance(study, None) if no_nuisance else study
        rng = np.random.default_rng(seed)
        robot = true_robot(study, true.model, np.random.default_rng([seed, 1]), true.loads)
        reality = replace(reality, loads=robot.loads, errors=robot.errors)
        kept = None
        if robot.drawn:
            kept = truth_out or out.with_name(f"{out.stem}_truth.json")
            writable(kept, *given, *sources_of(study, study_file), out, suffix=".json")
            replaceable(kept, "model", force=force)
        elif truth_out is not None:
            raise InputError(f"{truth_out}: nothing is drawn, {truth} says all of the robot")
        made = simulate(study, robot.model, plan.load_cases, plan.repeats, rng, reality=reality)
        write_measurements(made, study.robot, out)
        if kept is not None:
            write_truth(robot, kept, study.robot)
        _say_measurements(made, out, kept, as_json)
        return
    proposed = proposals(plans, study)
    written, study = study, knowing_as(study, proposed)
    for name, proposal in proposed.items():
        note_origin(name, proposal, written, study.known)
        refuse_false_claims(name, proposal, written)
    study = with_nuisance(study, None) if no_nuisance else study
    named = {name: (p.load_cases, p.repeats) for name, p in proposed.items()}
    if study.prior[np.ix_(study.wanted, study.wanted)].any():
        print(
            "note: virtual campaigns are fitted without the prior of the study; ρ0 here is that "
            "of the experiments alone",
            file=sys.stderr,
        )
    from elastocal.terminal.progress import progress

    with progress("campaigns") as tell:
        result = campaigns(
            study,
            true.model,
            named,
            number,
            seed=seed,
            workers=workers,
            how=Fit(cast(Model, fit), cast(Sigma, sigma)),
            reality=reality,
            random=random,
            progress=tell,
        )
    write_campaigns(result, study.sought, out)
    if picture is not None:
        _draw(result, picture)
    _say_campaigns(result, study, out, picture, as_json)


def _draw(result: MonteCarlo, picture: Path) -> None:
    """Write the histograms."""
    from elastocal.report.sections.monte_carlo import campaigns_picture
    from elastocal.writing import write_text

    write_text(picture, campaigns_picture(result))


def _say_measurements(made: Measurements, out: Path, truth: Path | None, as_json: bool) -> None:
    """What one virtual campaign came to."""
    import numpy as np

    size = np.linalg.norm(made.deflection, axis=1)
    largest = float(size[~made.rotations].max())
    turned = float(size[made.rotations].max()) if made.tool.rotation else None
    if as_json:
        print_json(
            {
                "experiments": len(made.cases),
                "readings": len(made),
                "largest_deflection_mm": 1e3 * largest,
                **({} if turned is None else {"largest_rotation_mrad": 1e3 * turned}),
                "source": made.source,
                **({} if truth is None else {"truth": str(truth)}),
            }
        )
    else:
        from elastocal.wording.lists import counted

        rotations = "" if turned is None else f", rotations up to {1e3 * turned:.4g} mrad"
        print(
            f"wrote {out}: {counted(len(made.cases), 'experiment')}, "
            f"{counted(len(made), 'reading')}, deflections up to {1e3 * largest:.4g} mm{rotations}"
        )
        if truth is not None:
            print(f"wrote {truth}: the robot that was measured, its nuisance by chance")


def _say_campaigns(
    result: MonteCarlo, study: Study, out: Path, picture: Path | None, as_json: bool
) -> None:
    """What many of them came to."""
    from elastocal.files.models.campaign_file import campaigns_document
    from elastocal.terminal.campaigns import show_campaigns

    if as_json:
        print_json(campaigns_document(result, study.sought))
        return
    show_campaigns(result)
    print(f"wrote {out}" + (f" and {picture}" if picture is not None else ""))
