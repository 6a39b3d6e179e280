"""`report`: a campaign, as far as it has come, as a page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal.cli.common import (
    Seed,
    app,
    guarded,
    progress,
    study_at,
    writable,
)
from elastocal.cli.identify import Known, Mapping, Prior
from elastocal.cli.stages import Files, stages, virtual_campaigns
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.planning.plan import Plan

Measured = Annotated[
    list[Path] | None, typer.Option("--measurements", help="Measured deflections (CSV).")
]


@app.command()
@guarded
def report(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN", help="Plan (JSON).")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Page to write.")] = Path("report.html"),
    study: Annotated[
        Path | None, typer.Option(help="Study, if not the one embedded in the plan.")
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
    confidence: Annotated[float, typer.Option(help="Confidence of the intervals.")] = 0.95,
    seed: Seed = 0,
) -> None:
    """Show a campaign, as far as it has come, as a page that works offline.

    Whatever follows the plan is computed again from the files that are named.
    """
    from elastocal.files.models.model_file import read_model
    from elastocal.files.plans.plan_file import read_plan
    from elastocal.files.plans.proposal_file import read_proposal
    from elastocal.planning.assessment import assess

    files = Files(measurements or [], model, mapping, prior, known, validation or [], path, truth)
    if campaigns is not None and truth is None:
        raise InputError("--campaigns needs --truth: true compliances to simulate with")
    writable(out, plan_file, *([study] if study else []), *(vs or []), *files.all)
    given = None if study is None else study_at(study)
    with progress("bound") as tell:
        shown = read_plan(plan_file, given, seed=seed, progress=tell)
    what = shown.study
    named = {}
    for file in vs or []:
        named[file.name if file.name not in named else str(file)] = file
    proposed = {name: read_proposal(file, what) for name, file in named.items()}
    others = {name: assess(what, o.load_cases, o.repeats) for name, o in proposed.items()}
    further = stages(what, files, tool, confidence)
    if campaigns is not None and truth is not None:
        model_true = read_model(truth, what.robot)
        plans = {name: (o.load_cases, o.repeats) for name, o in proposed.items()}
        further["monte_carlo"] = virtual_campaigns(shown, plans, model_true, campaigns)
    write_report(shown, out, others, quick, seed, further)


def write_report(
    shown: Plan,
    out: Path,
    others: dict[str, Any],
    quick: bool,
    seed: int,
    further: dict[str, Any] | None = None,
) -> None:
    """Write the page of a plan, with random plans and, unless quick, curves beside it.

    `further` are the stages after the plan, as arguments of `report.html`.
    """
    from elastocal.files.texts import write_text
    from elastocal.planning.trade_off import random_plans, trade_off
    from elastocal.report import html

    curves = None
    if not quick:
        with progress("curves") as tell:
            curves = trade_off(shown.study, seed=seed, progress=tell)
    random = random_plans(shown.study, 2000, seed=seed)
    write_text(out, html(shown, trade_off=curves, random=random, others=others, **(further or {})))
    print(f"wrote {out}")
