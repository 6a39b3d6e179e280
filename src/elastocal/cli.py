"""The command line: every command reads files, calls one function, writes a file.

Exit codes: 0 done, 2 bad input, 3 infeasible, 4 not identifiable, 130 stopped by the user.
Everything heavy is imported inside the commands, so that --help answers at once.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal import __version__
from elastocal.errors import ElastocalError, InfeasibleError, InputError

if TYPE_CHECKING:
    from elastocal.certification import Bound
    from elastocal.planning import Plan
    from elastocal.study import Study

app = typer.Typer(
    help="Plan elastostatic calibration experiments for robot arms, with a proof of quality.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)

StudyPath = Annotated[Path, typer.Argument(help="Study file (YAML).", show_default=False)]
Seed = Annotated[int, typer.Option(help="Same seed, same result.", min=0)]
Json = Annotated[bool, typer.Option("--json", help="Print JSON for programs.")]


def _guarded(command: Callable[..., None]) -> Callable[..., None]:
    """Turn our errors into one sentence and an exit code."""

    @wraps(command)
    def run(*args: Any, **kwargs: Any) -> None:
        try:
            command(*args, **kwargs)
        except ElastocalError as error:
            print(f"error: {error}", file=sys.stderr)
            raise typer.Exit(error.exit_code) from None
        except KeyboardInterrupt:
            print("stopped; no file was changed", file=sys.stderr)
            raise typer.Exit(130) from None
        except BrokenPipeError:
            sys.stderr.close()
            raise typer.Exit(0) from None
        except OSError as error:
            print(f"error: {error.strerror or error}", file=sys.stderr)
            raise typer.Exit(2) from None

    return run


def _version(wanted: bool) -> None:
    if wanted:
        print(f"elastocal {__version__}")
        raise typer.Exit


@app.callback()
def main(
    version: Annotated[
        bool, typer.Option("--version", help="Show the version.", callback=_version, is_eager=True)
    ] = False,
) -> None:
    """Plan elastostatic calibration experiments for robot arms, with a proof of quality."""


@app.command()
@_guarded
def init(
    path: Annotated[Path, typer.Argument(help="File to write.")] = Path("study.yaml"),
) -> None:
    """Write a commented study file to start from."""
    from elastocal.io.files import read_text, write_text

    if path.exists():
        raise InputError(f"{path}: exists already; choose another name")
    write_text(path, read_text(_template()))
    print(f"wrote {path}: edit it, then run 'elastocal check {path}'")


def _template() -> Path:
    return Path(__file__).parent / "io" / "study_template.yaml"


@app.command()
@_guarded
def check(study: StudyPath, as_json: Json = False) -> None:
    """Say what a study means: robot, reach, units, loads, what is identifiable."""
    from elastocal.checkup import check as look
    from elastocal.io.study_file import read_study

    what = read_study(study)
    found = look(what)
    if as_json:
        _print_json(
            {
                "reach_mm": 1e3 * found.reach,
                "feasible_share": found.feasible_share,
                "bottleneck": found.bottleneck,
                "remarks": list(found.remarks),
                "problem": None if found.problem is None else str(found.problem),
            }
        )
    else:
        from elastocal.terminal import show_check

        show_check(what, found)
    if found.problem is not None:
        raise found.problem


@app.command()
@_guarded
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
    seed: Seed = 0,
    as_json: Json = False,
) -> None:
    """Plan the experiments; write plan.json and the run sheet plan.csv."""
    _writable(out, study, suffix=".json")
    _writable(out.with_suffix(".csv"), study)
    what = _overridden(_study(study), count, max_configurations, criterion)
    made = _planned(what, out, seed)
    if as_json:
        from elastocal.io.plan_file import plan_document

        _print_json(plan_document(made))
        return
    from elastocal.terminal import show_plan

    show_plan(made)
    print(f"wrote {out} and {out.with_suffix('.csv')}")


def _planned(study: Study, out: Path, seed: int) -> Plan:
    """Plan a study, and write the plan and its run sheet beside it."""
    from elastocal.io.plan_file import write_plan, write_run_sheet
    from elastocal.planning import plan as make

    with _progress("planning") as tell:
        made = make(study, seed=seed, progress=tell)
    write_plan(made, out)
    write_run_sheet(made, out.with_suffix(".csv"))
    return made


@app.command()
@_guarded
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
    from elastocal.comparison import random_plans
    from elastocal.evaluation import evaluate as judge
    from elastocal.io.plan_file import read_proposal, study_hash
    from elastocal.study import with_count

    what = _study(study)
    results = {}
    bounds: dict[tuple[str, int], Bound] = {}
    for path in plans:
        proposal = read_proposal(path, what)
        name = path.name if path.name not in results else str(path)
        if proposal.study_hash and proposal.study_hash != study_hash(what):
            print(f"note: {name} was made from another version of the study", file=sys.stderr)
        m = int(proposal.repeats.sum())
        # A plan is judged by the criterion it was made for.
        wanted = replace(what, criterion=proposal.criterion or what.criterion)
        key = (wanted.criterion, m if what.prior.any() else 0)
        if key not in bounds:
            bounds[key] = _bound(wanted, m, seed)
        result = judge(wanted, proposal.load_cases, proposal.repeats, proposal.claims, bounds[key])
        results[name] = (m, len(proposal.repeats), result)
    rho0 = {}
    for m in {count for count, _, _ in results.values()} if random else ():
        rho0[m] = random_plans(with_count(what, m), random, seed=seed)
    if as_json:
        _print_json({name: _evaluation(*entry) for name, entry in results.items()})
    else:
        from elastocal.terminal import show_evaluations

        show_evaluations(what, results, rho0)
    _refuse(results)


def _refuse(results: dict[str, Any]) -> None:
    """Leave with the exit code of the first plan that does not hold."""
    from elastocal.errors import IdentifiabilityError

    for name, (_, _, result) in results.items():
        if result.assessment.violations:
            raise InfeasibleError(f"{name}: {result.assessment.violations[0]}")
        if result.unidentified:
            raise IdentifiabilityError(f"{name}: {result.unidentified[0]}")
        if result.objections:
            raise InputError(f"{name}: {result.objections[0]}")


def _evaluation(count: int, configurations: int, result: Any) -> dict[str, Any]:
    worth, proof = result.assessment, result.certificate
    return {
        "experiments": count,
        "configurations": configurations,
        "rho0_mm": 1e3 * worth.rho0,
        "lower_bound_mm": 1e3 * proof.lower_bound if proof.criterion == "test-pose" else None,
        "efficiency": proof.efficiency,
        "standard_error": [float(v) for v in worth.standard_error],
        "accepted": result.accepted,
        "objections": list(result.objections) + list(result.unidentified),
    }


@app.command()
@_guarded
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
    from elastocal.io.plan_file import read_proposal, study_text
    from elastocal.io.study_file import parse_study
    from elastocal.planning import Plan
    from elastocal.study import with_count

    _writable(out, plan_file, *(vs or []))
    text = study_text(plan_file) if study is None else None
    what = _study(study) if study is not None else parse_study(text or "", plan_file)
    proposal = read_proposal(plan_file, what)
    m = int(proposal.repeats.sum())
    if proposal.criterion:
        what = replace(what, criterion=proposal.criterion)
    what = with_count(what, m, what.experiments.max_configurations)
    result = judge(what, proposal.load_cases, proposal.repeats, {}, _bound(what, m, seed))
    shown = Plan(
        load_cases=proposal.load_cases,
        repeats=proposal.repeats,
        assessment=result.assessment,
        certificate=result.certificate,
        criterion=what.criterion,
        seed=proposal.seed or 0,
        study=what,
    )
    others = {}
    for path in vs or []:
        other = read_proposal(path, what)
        name = path.name if path.name not in others else str(path)
        others[name] = assess(what, other.load_cases, other.repeats)
    _write_report(shown, out, others, quick, seed)


def _write_report(shown: Plan, out: Path, others: dict[str, Any], quick: bool, seed: int) -> None:
    from elastocal.comparison import random_plans, trade_off
    from elastocal.io.files import write_text
    from elastocal.report import html

    curves = None
    if not quick:
        with _progress("curves") as tell:
            curves = trade_off(shown.study, seed=seed, progress=tell)
    random = random_plans(shown.study, 2000, seed=seed)
    write_text(out, html(shown, trade_off=curves, random=random, others=others))
    print(f"wrote {out}")


@app.command()
@_guarded
def demo(
    folder: Annotated[Path, typer.Argument(help="Folder to write to.")] = Path("demo"),
    seed: Seed = 0,
) -> None:
    """Plan the KUKA KR 270 campaign of the paper: study, plan, run sheet, report."""
    from elastocal.io.files import read_text, write_text
    from elastocal.terminal import show_plan

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    study_path = folder / "study.yaml"
    template = read_text(_template())
    if study_path.exists() and read_text(study_path) != template:
        raise InputError(f"{study_path}: exists and is not the demo's; choose another folder")
    write_text(study_path, template)
    made = _planned(_study(study_path), folder / "plan.json", seed)
    show_plan(made)
    _write_report(made, folder / "report.html", {}, False, seed)
    print(f"wrote {study_path}, {folder / 'plan.json'}, {folder / 'plan.csv'}")


def _study(path: Path) -> Study:
    from elastocal.io.study_file import read_study

    return read_study(path)


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


def _bound(study: Study, count: int, seed: int) -> Bound:
    """A bound computed anew, from another stream of random numbers than the planner's."""
    import numpy as np

    from elastocal.certification import lower_bound
    from elastocal.study import with_count

    with _progress("bound") as tell:
        rng = np.random.default_rng([seed, 1])
        return lower_bound(with_count(study, count), rng, progress=tell)


def _progress(title: str) -> Any:
    from elastocal.terminal import progress

    return progress(title)


def _writable(path: Path, *inputs: Path, suffix: str = "") -> None:
    """Refuse at once what would fail after the work is done, or destroy what it starts from."""
    import os

    if not path.parent.is_dir():
        raise InputError(f"{path}: the folder {path.parent} does not exist")
    if path.is_dir():
        raise InputError(f"{path}: is a folder, expected a file name")
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: is not an ordinary file")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: the folder {path.parent} cannot be written to")
    if suffix and path.suffix.lower() != suffix:
        raise InputError(f"{path}: expected a name that ends in {suffix}")
    if any(path.resolve() == given.resolve() for given in inputs):
        raise InputError(f"{path}: would be written over the file it is made from")


def _print_json(document: Any) -> None:
    import json

    from elastocal.io.files import finite

    print(json.dumps(finite(document), indent=2, ensure_ascii=False, allow_nan=False))
