"""`report`: a campaign, as far as it has come, as a page."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from elastocal.cli.common import (
    Known,
    Mapping,
    Overwrite,
    Prior,
    Seed,
    app,
    note_parted,
    replaceable,
    writable,
)
from elastocal.errors import InputError

Measured = Annotated[
    list[Path] | None, typer.Option("--measurements", help="Measured deflections (CSV).")
]


@app.command("report")
def report_command(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN", help="Plan (JSON).")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Page to write.")] = Path("report.html"),
    study_file: Annotated[
        Path | None, typer.Option("--study", help="Study, if not the one embedded in the plan.")
    ] = None,
    vs: Annotated[list[Path] | None, typer.Option(help="Another plan to show beside.")] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Without the curves over experiments.")
    ] = False,
    measurements: Measured = None,
    model: Annotated[
        Path | None, typer.Option(help="Model of them, or to be judged without them.")
    ] = None,
    mapping: Mapping = None,
    prior: Prior = None,
    known: Known = None,
    validation: Annotated[
        list[Path] | None, typer.Option(help="Measurements kept aside (CSV).")
    ] = None,
    path: Annotated[Path | None, typer.Option(help="Path of the task (CSV), as wanted.")] = None,
    tool: Annotated[str | None, typer.Option(help="Tool, if the test poses have several.")] = None,
    truth: Annotated[
        Path | None, typer.Option(help="True compliances, to judge by; virtual campaigns only.")
    ] = None,
    campaigns: Annotated[
        int | None, typer.Option(help="Virtual campaigns of this plan and those with --vs.")
    ] = None,
    random: Annotated[
        int, typer.Option(help="Random plans beside them, with campaigns of their own.", min=0)
    ] = 0,
    confidence: Annotated[float, typer.Option(help="Confidence of the intervals.")] = 0.95,
    force: Overwrite = False,
    seed: Seed = 0,
) -> None:
    """Show a campaign, as far as it has come, as a page that works offline.

    Whatever follows the plan is computed again from the files that are named. In place of the
    plan may stand a robot calibrated from absolute readings, with its study and these readings.
    """
    from elastocal.files.models.calibration_kind import is_calibration

    if is_calibration(plan_file):
        from elastocal.cli.absolute import report_command as calibration_report

        named = [
            plan_file,
            *(measurements or []),
            *(validation or []),
            *([mapping] if mapping else []),
        ]
        writable(out, *named)
        replaceable(out, "report", force=force)
        calibration_report(
            plan_file, study_file, measurements or [], mapping, validation or [], out
        )
        return
    from elastocal.cli.inputs import (
        Files,
        plan_and_study,
        proposals,
        sources_of,
    )
    from elastocal.cli.origins import note_before, note_origin, note_proof, refuse_false_claims
    from elastocal.cli.planning import note_broken
    from elastocal.cli.stages import stages, virtual_campaigns, write_report
    from elastocal.files.models.truth_file import read_truth
    from elastocal.files.plans.plan_file import judged
    from elastocal.files.plans.proof_record import proof_beside
    from elastocal.files.plans.proposal_file import study_for
    from elastocal.planning.assessment import assess
    from elastocal.terminal.progress import progress

    files = Files(measurements or [], model, mapping, prior, known, validation or [], path, truth)
    if campaigns is not None and truth is None:
        raise InputError("--campaigns needs --truth: true compliances to simulate with")
    if random and campaigns is None:
        raise InputError("--random needs --campaigns: how many to simulate")
    named = [plan_file, *([study_file] if study_file else []), *(vs or []), *files.all]
    writable(out, *named)
    proposal, given = plan_and_study(plan_file, study_file)
    writable(out, *sources_of(study_for(proposal, given), study_file or plan_file))
    replaceable(out, "report", force=force)
    shown = study_for(proposal, given)
    note_parted([plan_file, *(vs or [])])
    note_origin(plan_file.name, proposal, given, shown.known)
    refuse_false_claims(plan_file.name, proposal, given)
    note_broken(plan_file.name, proposal, shown)
    proposed = proposals(vs or [], shown)
    for name, other in proposed.items():
        note_origin(name, other, given, shown.known)
        note_before(name, other, proposal)
        refuse_false_claims(name, other, given)
    proved, doubt = proof_beside(proposal, given, plan_file.parent)
    with progress("bound") as tell:
        plan = judged(proposal, given, seed=seed, proved=proved, progress=tell)
    note_proof(plan_file.name, plan.certificate, doubt)
    others = {name: assess(plan.study, o.load_cases, o.repeats) for name, o in proposed.items()}
    contents = stages(plan.study, files, tool, confidence)
    contents = replace(contents, plan=plan, others=others)
    if campaigns is not None and truth is not None:
        true = read_truth(truth, plan.study.robot)
        plans = {name: (o.load_cases, o.repeats) for name, o in proposed.items()}
        simulated = virtual_campaigns(plan, plans, true, campaigns, random)
        contents = replace(contents, monte_carlo=simulated)
    write_report(contents, out, quick=quick, seed=seed)
