"""`report` and `demo`: show a plan as a page; the whole job on one example."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal.cli.common import (
    Seed,
    app,
    guarded,
    progress,
    study_at,
    study_of_plan,
    template_path,
    writable,
)
from elastocal.cli.plan import bound, planned
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.planning import Plan


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
    seed: Seed = 0,
) -> None:
    """Show a plan as a page that works offline."""
    from elastocal.assessment import assess
    from elastocal.evaluation import evaluate as judge
    from elastocal.io.proposal_file import read_proposal
    from elastocal.planning import Plan
    from elastocal.replanning import knowing
    from elastocal.study import with_count

    writable(out, plan_file, *(vs or []))
    what = study_of_plan(plan_file, study)
    proposal = read_proposal(plan_file, what)
    m = int(proposal.repeats.sum())
    if proposal.done is not None:
        what = knowing(what, proposal.done)
    if proposal.criterion:
        what = replace(what, criterion=proposal.criterion)
    what = with_count(what, m, what.experiments.max_configurations)
    result = judge(what, proposal.load_cases, proposal.repeats, {}, bound(what, m, seed))
    shown = Plan(
        load_cases=proposal.load_cases,
        repeats=proposal.repeats,
        assessment=result.assessment,
        certificate=result.certificate,
        criterion=what.criterion,
        seed=proposal.seed or 0,
        study=what,
        via=proposal.via,
    )
    others = {}
    for path in vs or []:
        other = read_proposal(path, what)
        name = path.name if path.name not in others else str(path)
        others[name] = assess(what, other.load_cases, other.repeats)
    write_report(shown, out, others, quick, seed)


def write_report(shown: Plan, out: Path, others: dict[str, Any], quick: bool, seed: int) -> None:
    """Write the page of a plan, with random plans and, unless quick, curves beside it."""
    from elastocal.comparison import random_plans, trade_off
    from elastocal.io.files import write_text
    from elastocal.report import html

    curves = None
    if not quick:
        with progress("curves") as tell:
            curves = trade_off(shown.study, seed=seed, progress=tell)
    random = random_plans(shown.study, 2000, seed=seed)
    write_text(out, html(shown, trade_off=curves, random=random, others=others))
    print(f"wrote {out}")


@app.command()
@guarded
def demo(
    folder: Annotated[Path, typer.Argument(help="Folder to write to.")] = Path("demo"),
    seed: Seed = 0,
) -> None:
    """Plan the KUKA KR 270 campaign of the paper: study, plan, run sheet, report."""
    from elastocal.io.files import read_text, write_text
    from elastocal.terminal.plans import show_plan

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    study_path = folder / "study.yaml"
    template = read_text(template_path())
    if study_path.exists() and read_text(study_path) != template:
        raise InputError(f"{study_path}: exists and is not the demo's; choose another folder")
    write_text(study_path, template)
    made = planned(study_at(study_path), folder / "plan.json", seed)
    show_plan(made)
    write_report(made, folder / "report.html", {}, False, seed)
    print(f"wrote {study_path}, {folder / 'plan.json'}, {folder / 'plan.csv'}")
