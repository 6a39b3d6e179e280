"""`plan` and `evaluate`: make a plan, judge plans."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import (
    Force,
    Json,
    Mapping,
    Overwrite,
    Seed,
    Start,
    StudyPath,
    Torque,
    Workers,
    app,
    note_parted,
    print_json,
    replaceable,
    writable,
)
from elastocal.cli.proof_options import (
    Prove,
    ProveGap,
    ProveSeconds,
    Record,
    belongs_to_prove,
    refuse_record,
)
from elastocal.errors import InfeasibleError, InputError

if TYPE_CHECKING:
    from elastocal.measuring.measurements import Measurements
    from elastocal.planning.as_measured import Measured
    from elastocal.planning.certificate import Bound
    from elastocal.planning.evaluation import Evaluation
    from elastocal.planning.plan import Plan
    from elastocal.planning.proved import Proved
    from elastocal.planning.to_validate import ToValidate
    from elastocal.study.study import Study


@app.command("plan")
def plan_command(
    study_file: StudyPath,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Plan to write; the run sheet goes beside it.")
    ] = Path("plan.json"),
    count: Annotated[
        int | None,
        typer.Option(help="Experiments in all, those of --after included; not as in the study."),
    ] = None,
    max_configurations: Annotated[
        int | None,
        typer.Option(help="Most distinct configurations that are planned; not as in the study."),
    ] = None,
    criterion: Annotated[
        str | None, typer.Option(help="Criterion, instead of the study's.")
    ] = None,
    after: Annotated[
        list[Path] | None,
        typer.Option(help="What was measured already (CSV): plan the rest of the campaign."),
    ] = None,
    mapping: Mapping = None,
    known: Annotated[
        Path | None,
        typer.Option(help="What is known of further joints: model.json, or plan.json of a step 1."),
    ] = None,
    validate: Annotated[
        int,
        typer.Option(
            help="Also plan so many load cases to validate with, into plan.validate.csv.", min=0
        ),
    ] = 0,
    force: Overwrite = False,
    seed: Seed = 0,
    seconds: Annotated[
        float | None,
        typer.Option(help="Stop after that long, with the best plan so far.", min=0.0),
    ] = None,
    workers: Workers = None,
    prove: Prove = False,
    prove_seconds: ProveSeconds = 60.0,
    prove_gap: ProveGap = 0.01,
    proof: Record = None,
    as_json: Json = False,
) -> None:
    """Plan the experiments; write plan.json and the run sheet plan.csv.

    Ctrl-C ends the search with the best plan so far, and then the proof with what is proved so far;
    a second one ends the program.
    """
    from elastocal.cli.inputs import known_in, sources_of
    from elastocal.cli.planning import planned_for_now
    from elastocal.files.study.study_file import read_study
    from elastocal.study.criteria import renamed
    from elastocal.wording import worded

    if mapping is not None and not after:
        raise InputError("--mapping belongs to --after, which is not given")
    given = [study_file, *(after or []), *([mapping] if mapping else [])]
    writable(out, *given, suffix=".json")
    sheet = out.with_suffix(".csv")
    study = read_study(study_file, known_in(known))
    others = out.with_suffix(".validate.csv")
    written = [(out, "plan"), (sheet, "run sheet")] + [(others, "run sheet")] * bool(validate)
    for file, kind in written:
        writable(file, *given, *sources_of(study, study_file, known))
        replaceable(file, kind, force=force)
    study = _overridden(study, count, max_configurations, criterion)
    if after:
        study = _rest(study, after, mapping, as_json)
    belongs_to_prove(prove, proof)
    if prove:
        from elastocal.cli.proving import Proving, record_of, refuse_unprovable

        how = Proving(prove_seconds, prove_gap / 100.0, record_of(out, proof), force)
        writable(how.record, *given, out, sheet)
        refuse_unprovable(study, how)
    for doubt in renamed(study):
        print(f"note: {worded(doubt)}", file=sys.stderr)
    made = planned_for_now(study, out, seed, workers, seconds)
    if prove:
        from elastocal.cli.proving import proved_plan

        again = partial(planned_for_now, study, out, seed, workers, seconds)
        made = proved_plan(made, out, how, again)
    beside = _to_validate(made, validate, others, seed) if validate else None
    if as_json:
        from elastocal.files.plans.plan_file import plan_document

        print_json(plan_document(made))
        return
    from elastocal.terminal.plans import show_plan

    show_plan(made)
    if beside is not None:
        from elastocal.terminal.plans import show_to_validate

        show_to_validate(made.study.robot, beside)
    names = [str(out), str(sheet)]
    names += [str(how.record)] if prove and how.record.exists() else []
    names += [] if beside is None else [str(others)]
    print(f"wrote {', '.join(names[:-1])} and {names[-1]}")


def _to_validate(made: Plan, count: int, out: Path, seed: int) -> ToValidate:
    """Load cases to validate with, written."""
    from elastocal.files.plans.plan_file import write_validation_sheet
    from elastocal.planning.to_validate import to_validate

    found = to_validate(made.study, made.load_cases, count, seed=seed)
    write_validation_sheet(made.study.robot, found, out)
    return found


def _rest(study: Study, measured: list[Path], mapping: Path | None, as_json: bool) -> Study:
    """The study of what is left after the experiments in `measured`."""
    from elastocal.cli.measured import readings, refuse_twice
    from elastocal.planning.remaining import done, remaining

    data = readings(study, measured, mapping)
    refuse_twice(data, study.known)
    _note(data, as_json)
    return remaining(study, done(study, data))


def _note(data: Measurements, as_json: bool) -> None:
    """Say what looks odd in readings, beside a document on standard error."""
    from elastocal.terminal.measurements import show_remarks
    from elastocal.wording import worded

    if not as_json:
        show_remarks(data)
        return
    for remark in (*data.remarks, *map(worded, data.doubts)):
        print(f"note: {remark}", file=sys.stderr)


def _overridden(
    study: Study, count: int | None, configurations: int | None, criterion: str | None
) -> Study:
    """The study with what the command line says instead."""
    experiments = study.experiments
    if count is not None:
        experiments = replace(experiments, count=count)
    if configurations is not None:
        experiments = replace(experiments, max_configurations=configurations)
    if criterion is not None:
        study = replace(study, criterion=criterion)
    return replace(study, experiments=experiments)


@app.command("evaluate")
def evaluate_command(
    study_file: StudyPath,
    plans: Annotated[
        list[Path],
        typer.Argument(
            help="Plans (JSON or CSV), side by side; measurements (CSV) are judged as a plan.",
            show_default=False,
        ),
    ],
    mapping: Mapping = None,
    random: Annotated[
        int, typer.Option(help="Random feasible plans to compare with; 0 for none.", min=0)
    ] = 1000,
    at_test_poses: Annotated[
        bool,
        typer.Option(
            "--at-test-poses", help="Also judge measuring in the test poses, as often as planned."
        ),
    ] = False,
    path: Annotated[
        Path | None, typer.Option(help="Path (CSV) at whose points the plans are judged, too.")
    ] = None,
    tool: Annotated[
        str | None, typer.Option(help="Tool of the path, if the test poses have several.")
    ] = None,
    force_n: Force = None,
    torque_nm: Torque = None,
    start: Start = None,
    seed: Seed = 1,
    workers: Workers = None,
    prove: Prove = False,
    prove_seconds: ProveSeconds = 60.0,
    prove_gap: ProveGap = 0.01,
    proof: Record = None,
    force: Overwrite = False,
    as_json: Json = False,
) -> None:
    """Judge plans from the study alone; refuse what breaks a constraint or claims too much."""
    from elastocal.cli.inputs import baselines, knowing_as, load, proposals, with_path
    from elastocal.cli.measured import as_proposal, measured_among, recomputed
    from elastocal.cli.origins import note_origin
    from elastocal.cli.planning import bound
    from elastocal.cli.proving import (
        Proving,
        proved_for,
        record_of,
        refuse_unprovable,
        with_claimed_proof,
        with_what_is_proved,
    )
    from elastocal.files.plans.proposal_file import study_for
    from elastocal.files.study.study_file import read_study
    from elastocal.planning.aim import is_for_promise
    from elastocal.planning.along_paths import better_along
    from elastocal.planning.as_measured import evaluate_measured
    from elastocal.planning.evaluation import evaluate
    from elastocal.planning.trade_off import random_plans
    from elastocal.study.study import with_count

    study = read_study(study_file)
    belongs_to_prove(prove, proof)
    if path is None:
        given = {"--tool": tool, "--force-n": force_n, "--torque-nm": torque_nm, "--start": start}
        if lone := [option for option, value in given.items() if value is not None]:
            raise InputError(f"{lone[0]} belongs to --path, which is not given")
    else:
        study = with_path(study, path, tool, load(force_n, torque_nm), start)
    results = {}
    bounds: dict[tuple[str, str, str, int, int], Bound] = {}
    proofs: dict[tuple[str, str, str, int, int], Proved | None] = {}
    studies: dict[int, Study] = {}
    note_parted(plans)
    read = measured_among(plans, mapping)
    made = [file for file in plans if file not in read]
    proposed = proposals(made, study)
    files = dict(zip(proposed, made, strict=False))
    measured: dict[str, Measured] = {}
    if read:
        done = _measured(study, read, mapping, as_json)
        campaign = as_proposal(read, done, proposed)
        proposed[campaign.name], measured[campaign.name] = campaign, done
    written, study = study, knowing_as(study, proposed)
    bases = baselines(study, proposed) if at_test_poses else {}
    for name, proposal in (proposed | bases).items():
        note_origin(name, proposal, written, study.known)
        m, before = proposal.count, proposal.done
        if before is not None:
            true = recomputed(before, study, files.get(name, Path(name)))
            checked = "" if true else ", as it says: that is not checked, for they are not there"
            print(
                f"note: {name} counts the information of {before.experiments} experiments "
                f"measured before it ({before.source}){checked}",
                file=sys.stderr,
            )
        # A plan is judged by the criterion it was made for.
        wanted = studies[m] = study_for(proposal, study)
        known = "" if wanted.known is None else wanted.known.sha256
        key = (
            wanted.criterion,
            "" if before is None else before.sha256 + str(hash(before.information.tobytes())),
            known,
            m if prove or wanted.prior.any() else 0,
            wanted.experiments.max_configurations or 0 if is_for_promise(wanted) else 0,
        )
        if key not in bounds:
            how = Proving(
                prove_seconds,
                prove_gap / 100.0,
                record_of(files.get(name, Path(name)), proof, more=".evaluated"),
                force,
            )
            if prove:
                refuse_record(how.record, [study_file, *plans], taken=bool(bounds and proof))
                refuse_unprovable(wanted, how)
            bounds[key] = bound(wanted, seed, workers)
            if prove:
                bounds[key], proofs[key] = proved_for(wanted, bounds[key], proposal.load_cases, how)
        result = (
            evaluate_measured(wanted, measured[name], bounds[key])
            if name in measured
            else evaluate(
                wanted,
                proposal.load_cases,
                proposal.repeats,
                proposal.claims,
                bounds[key],
                proposal.via,
                asked=written.experiments if name in proposed else None,
            )
        )
        result = with_what_is_proved(result, bounds[key], proofs.get(key))
        if name in files:
            result = with_claimed_proof(result, proposal, written, files[name].parent)
        results[name] = result
    rho0 = {}
    for m, wanted in studies.items() if random else ():
        rho0[m] = random_plans(with_count(wanted, m), random, seed=seed)
    better = better_along(study, {name: result.assessment for name, result in results.items()})
    if as_json:
        from elastocal.files.plans.evaluation_document import evaluation_document

        own = {name: {pose: shares[name] for pose, shares in better.items()} for name in results}
        print_json({n: evaluation_document(r, study, own[n]) for n, r in results.items()})
    else:
        from elastocal.terminal.plans import show_evaluations

        show_evaluations(study, results, rho0, better, tuple(bases))
    _refuse({name: results[name] for name in proposed})


def _measured(study: Study, files: list[Path], mapping: Path | None, as_json: bool) -> Measured:
    """The campaign in measurement files; what looks odd in it is said."""
    from elastocal.cli.measured import readings
    from elastocal.files.measurements.suspicious import kept_aside
    from elastocal.planning.as_measured import as_measured

    data = kept_aside(readings(study, files, mapping))
    _note(data, as_json)
    return as_measured(data, study.robot)


def _refuse(results: dict[str, Evaluation]) -> None:
    """Leave with the exit code of the first plan that does not hold."""
    from elastocal.errors import IdentifiabilityError
    from elastocal.wording import worded

    for name, result in results.items():
        if result.assessment.violations:
            raise InfeasibleError(f"{name}: {worded(result.assessment.violations[0])}")
        if result.collisions:
            raise InfeasibleError(f"{name}: {worded(result.collisions[0])}")
        if result.unidentified:
            raise IdentifiabilityError(f"{name}: {worded(result.unidentified[0])}")
        if result.objections:
            raise InputError(f"{name}: {worded(result.objections[0])}")
