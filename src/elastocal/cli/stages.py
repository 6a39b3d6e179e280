"""Stages of a campaign, from values and files to values: what several commands do.

Imported by the commands when they run.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from elastocal.arrays import IntArray
from elastocal.cli.inputs import (
    Files,
    errors_of,
    fit_of,
    identified_cases,
    known_model,
    model_at,
    start_of,
    tool_called,
)
from elastocal.cli.measured import readings, refuse_twice
from elastocal.cli.origins import note_measurements, note_model
from elastocal.cli.refit import refit
from elastocal.compensation.compensate import Compensation, compensate, mirrored, residual
from elastocal.elastic.compliance_model import ComplianceModel, merged_models
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.files.measurements.suspicious import kept_aside
from elastocal.files.models.provenance_section import made_from
from elastocal.files.models.reading_marks import without_used
from elastocal.files.models.truth_file import read_truth
from elastocal.files.paths.path_file import read_path
from elastocal.fitting.goodness import quantile
from elastocal.identification.fit import Fit
from elastocal.identification.result import Identification
from elastocal.identification.search import searched
from elastocal.identification.validation import Validation, leave_one_out, validate
from elastocal.planning.plan import Plan
from elastocal.planning.trade_off import random_plans, trade_off
from elastocal.report import html
from elastocal.report.contents import Contents
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.simulation.monte_carlo import campaigns
from elastocal.simulation.true_robot import TrueRobot
from elastocal.simulation.virtual_campaign import Reality
from elastocal.study.at_test_poses import AtTestPose, at_test_poses
from elastocal.study.study import Study
from elastocal.terminal.progress import progress
from elastocal.writing import write_text

_RANDOM = 2000  # random plans to compare with


def stages(study: Study, files: Files, tool: str | None, confidence: float) -> Contents:
    """Identification, validation and compensation: recomputed from the files, not read of them."""
    Fit(confidence=confidence)  # refuses what is none
    truth = None if files.truth is None else read_truth(files.truth, study.robot)
    if files.model is not None:
        note_model(files.model, study)
    model = None if files.measurements else model_at(files.model, study.robot)
    fitted = _identified(study, files, confidence)
    known = known_model(files.known, study) if files.measurements or files.known else None
    model = fitted.model if fitted is not None else _with(model, known)
    contents = Contents(
        identification=fitted,
        searched=None if fitted is None else searched(fitted, study.coupling),
        references=_references(study, files),
        validation=_validated(study, files, model, fitted, confidence),
        at_test_poses=_at_test_poses(study, model, confidence),
    )
    if files.path is None:
        return contents
    if model is None:
        raise InputError(f"{files.path}: a path needs --measurements or --model to correct it")
    used = tool_called(study, tool)
    task = read_path(files.path, study.robot, used, start_of(study, used))
    arm = replace(study.arm, springs=model.springs, tool=used)
    return with_compensation(contents, compensate(arm, model, task.cases, errors_of(study)), truth)


def _at_test_poses(
    study: Study, model: ComplianceModel | None, confidence: float
) -> tuple[AtTestPose, ...]:
    """What the model says of the test poses, if there is one."""
    if model is None:
        return ()
    return at_test_poses(study, model, quantile(0.5 + 0.5 * confidence, model.dof))


def _with(model: ComplianceModel | None, known: ComplianceModel | None) -> ComplianceModel | None:
    """A model with that of further joints, unless it has them already."""
    if model is None or known is None or set(known.names) <= set(model.names):
        return model
    return merged_models([model, known])


def _identified(study: Study, files: Files, confidence: float) -> Identification | None:
    """The fit, once more; refused if it does not give the model that is named with it."""
    if not files.measurements:
        return None
    data = readings(study, files.measurements, files.mapping)
    refuse_twice(data, files.prior, files.known, study.known)
    how, known = fit_of(files.model, confidence), known_model(files.known, study)
    found = refit(study, data, how, files.model, files.prior, known)
    if files.model is not None:
        note_measurements(files.model, data, fitted=True)
    return found


def _references(study: Study, files: Files) -> dict[str, ComplianceModel]:
    """What is known from elsewhere, by name."""
    named = {"prior": files.prior, "known": files.known, "truth": files.truth}
    models = {name: model_at(path, study.robot) for name, path in named.items()}
    identified = set(study.springs.names)
    return {n: m for n, m in models.items() if m is not None and identified & set(m.names)}


def _validated(
    study: Study,
    files: Files,
    model: ComplianceModel | None,
    fitted: Identification | None,
    confidence: float,
) -> Validation | None:
    """On what was kept aside, else each experiment left out in turn."""
    if not files.validation:
        return None if fitted is None else leave_one_out(fitted, confidence=confidence)
    if model is None:
        raise InputError(
            f"{files.validation[0]}: validation needs --measurements or --model, to have something "
            "to validate"
        )
    kept = kept_aside(readings(study, files.validation, files.mapping))
    if fitted is not None and kept.sha256 and kept.sha256 == fitted.measurements.sha256:
        raise InputError(
            f"{files.validation[0]}: these are the measurements the model was made from; leave "
            "--validation out, then every experiment is left out in turn"
        )
    if fitted is None and files.model is not None:
        if made_from(files.model, kept):
            raise InputError(
                f"{files.validation[0]}: these are the measurements {files.model} was made from; "
                "name them with --measurements, then every experiment is left out in turn"
            )
        kept = without_used(kept, files.model)
        note_measurements(files.model, kept)
    before = fitted.measurements.cases if fitted else identified_cases(files.model, study.robot)
    errors = errors_of(study) if fit_of(files.model).fitted == "mixed" else None
    return validate(study.arm, model, kept, confidence=confidence, identified=before, errors=errors)


def with_compensation(contents: Contents, done: Compensation, truth: TrueRobot | None) -> Contents:
    """Contents with a corrected path, judged by the truth if that is known."""
    if truth is None:
        return replace(contents, compensation=done)
    arm, gain = replace(done.arm, springs=truth.model.springs), truth.process_gain
    return replace(
        contents,
        compensation=done,
        judged=residual(arm, truth.model, done, gain=gain),
        control=residual(arm, truth.model, mirrored(done), gain=gain),
    )


def virtual_campaigns(
    plan: Plan,
    others: dict[str, tuple[LoadCases, IntArray]],
    truth: TrueRobot,
    number: int,
    random: int = 0,
) -> MonteCarlo:
    """Many virtual campaigns of the plan, of others by name, and of random ones."""
    named = {"this plan": (plan.load_cases, plan.repeats)} | others
    with progress("campaigns") as tell:
        return campaigns(
            plan.study,
            truth.model,
            named,
            number,
            seed=plan.seed,
            reality=Reality(loads=truth.loads),
            random=random,
            progress=tell,
        )


def write_report(contents: Contents, path: Path, *, quick: bool, seed: int) -> None:
    """Write a page, with random plans and, unless quick, curves beside the plan it shows."""
    assert contents.plan is not None
    study, curves = contents.plan.study, None
    if not quick:
        with progress("curves") as tell:
            curves = trade_off(study, seed=seed, progress=tell)
    random = random_plans(study, _RANDOM, seed=seed)
    write_text(path, html(replace(contents, trade_off=curves, random=random)))
    print(f"wrote {path}")
