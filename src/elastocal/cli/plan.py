"""`plan` and `evaluate`: make a plan, judge plans."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal.cli.common import (
    Json,
    Seed,
    StudyPath,
    app,
    guarded,
    overridden,
    print_json,
    progress,
    study_at,
    writable,
)
from elastocal.errors import InfeasibleError, InputError

if TYPE_CHECKING:
    from elastocal.planning.certificate import Bound
    from elastocal.planning.plan import Plan
    from elastocal.study.study import Study


@app.command()
@guarded
def plan(
    study: StudyPath,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Plan to write; the run sheet goes beside it.")
    ] = Path("plan.json"),
    count: Annotated[int | None, typer.Option(help="Experiments, instead of the study's.")] = None,
    max_configurations: Annotated[
        int | None, typer.Option(help="Most distinct configurations, instead of the study's.")
    ] = None,
    criterion: Annotated[
        str | None, typer.Option(help="Criterion, instead of the study's.")
    ] = None,
    after: Annotated[
        list[Path] | None,
        typer.Option(help="What was measured already (CSV): plan the rest of the campaign."),
    ] = None,
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Plan the experiments; write plan.json and the run sheet plan.csv."""
    writable(out, study, suffix=".json")
    writable(out.with_suffix(".csv"), study)
    what = study_at(study)
    if after:
        what = _rest(what, after)
    what = overridden(what, count, max_configurations, criterion)
    made = planned(what, out, seed)
    if as_json:
        from elastocal.files.plans.plan_file import plan_document

        print_json(plan_document(made))
        return
    from elastocal.terminal.plans import show_plan

    show_plan(made)
    print(f"wrote {out} and {out.with_suffix('.csv')}")


def _rest(study: Study, measured: list[Path]) -> Study:
    """The study of what is left after the experiments in `measured`."""
    from elastocal.cli.identify import readings, show_remarks
    from elastocal.planning.remaining import done, remaining

    data = readings(study, measured)
    show_remarks(data)
    return remaining(study, done(study, data))


def planned(study: Study, out: Path, seed: int) -> Plan:
    """Plan a study, and write the plan and its run sheet beside it."""
    from elastocal.files.plans.plan_file import write_plan, write_run_sheet
    from elastocal.planning.plan import plan as make

    with progress("planning") as tell:
        made = make(study, seed=seed, progress=tell)
    write_plan(made, out)
    write_run_sheet(made, out.with_suffix(".csv"))
    return made


@app.command()
@guarded
def evaluate(
    study: StudyPath,
    plans: Annotated[
        list[Path], typer.Argument(help="Plans (JSON or CSV), side by side.", show_default=False)
    ],
    random: Annotated[
        int, typer.Option(help="Random feasible plans to compare with; 0 for none.", min=0)
    ] = 1000,
    seed: Seed = 1,
    as_json: Json = False,
) -> None:
    """Judge plans from the study alone; refuse what breaks a constraint or claims too much."""
    from elastocal.files.plans.plan_file import study_hash
    from elastocal.files.plans.proposal_file import read_proposal
    from elastocal.planning.evaluation import evaluate as judge
    from elastocal.planning.remaining import knowing
    from elastocal.planning.trade_off import random_plans
    from elastocal.study.study import with_count

    what = study_at(study)
    results = {}
    bounds: dict[tuple[str, str, int], Bound] = {}
    studies: dict[int, Study] = {}
    for path in plans:
        proposal = read_proposal(path, what)
        name = path.name if path.name not in results else str(path)
        if proposal.study_hash and proposal.study_hash != study_hash(what):
            print(f"note: {name} was made from another version of the study", file=sys.stderr)
        if proposal.robot_hash and proposal.robot_hash != what.robot.sha256:
            print(f"note: {name} was made with another robot file", file=sys.stderr)
        m = int(proposal.repeats.sum())
        if proposal.done is not None:
            print(
                f"note: {name} counts the information of {proposal.done.experiments} experiments "
                f"measured before it ({proposal.done.source})",
                file=sys.stderr,
            )
        # A plan is judged by the criterion it was made for.
        wanted = replace(what, criterion=proposal.criterion or what.criterion)
        if proposal.done is not None:
            wanted = knowing(wanted, proposal.done)
        before = "" if proposal.done is None else proposal.done.sha256
        key = (wanted.criterion, before, m if wanted.prior.any() else 0)
        studies[m] = wanted
        if key not in bounds:
            bounds[key] = bound(wanted, m, seed)
        result = judge(
            wanted,
            proposal.load_cases,
            proposal.repeats,
            proposal.claims,
            bounds[key],
            proposal.via,
        )
        results[name] = (m, len(proposal.repeats), result)
    rho0 = {}
    for m, wanted in studies.items() if random else ():
        rho0[m] = random_plans(with_count(wanted, m), random, seed=seed)
    if as_json:
        print_json({name: _evaluation(*entry) for name, entry in results.items()})
    else:
        from elastocal.terminal.plans import show_evaluations

        show_evaluations(what, results, rho0)
    _refuse(results)


def bound(study: Study, count: int, seed: int) -> Bound:
    """A bound computed anew, from another stream of random numbers than the planner's."""
    import numpy as np

    from elastocal.planning.certificate import lower_bound
    from elastocal.study.study import with_count

    with progress("bound") as tell:
        rng = np.random.default_rng([seed, 1])
        return lower_bound(with_count(study, count), rng, progress=tell)


def _refuse(results: dict[str, Any]) -> None:
    """Leave with the exit code of the first plan that does not hold."""
    from elastocal.errors import IdentifiabilityError
    from elastocal.wording import worded

    for name, (_, _, result) in results.items():
        if result.assessment.violations:
            raise InfeasibleError(f"{name}: {worded(result.assessment.violations[0])}")
        if result.collisions:
            raise InfeasibleError(f"{name}: {worded(result.collisions[0])}")
        if result.unidentified:
            raise IdentifiabilityError(f"{name}: {worded(result.unidentified[0])}")
        if result.objections:
            raise InputError(f"{name}: {worded(result.objections[0])}")


def _evaluation(count: int, configurations: int, result: Any) -> dict[str, Any]:
    from elastocal.wording import worded

    worth, proof = result.assessment, result.certificate
    bound = proof.position_bound
    return {
        "experiments": count,
        "configurations": configurations,
        "rho0_mm": 1e3 * worth.rho0,
        "lower_bound_mm": None if bound is None else 1e3 * bound,
        "efficiency": proof.efficiency,
        "standard_error": [float(v) for v in worth.standard_error],
        "seen": None
        if result.view is None
        else dict(zip(result.view.markers, result.view.seen.tolist(), strict=True)),
        "accepted": result.accepted,
        "objections": [worded(doubt) for doubt in (*result.objections, *result.unidentified)],
    }
