"""The whole job with a virtual robot: plan, measure, identify, validate, compensate, report.

Imported by `demo` when it runs.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.text import Text

from elastocal.arrays import IntArray
from elastocal.cli.common import demo_file, replaceable, writable
from elastocal.cli.inputs import errors_of, known_model, start_of, tool_called
from elastocal.cli.planning import planned
from elastocal.cli.stages import (
    virtual_campaigns,
    with_compensation,
    write_report,
)
from elastocal.compensation.compensate import compensate
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
from elastocal.files.measurements.suspicious import kept_aside
from elastocal.files.models.identification_file import write_identification
from elastocal.files.models.model_file import read_model
from elastocal.files.paths.corrected_file import write_corrected
from elastocal.files.paths.path_file import read_path
from elastocal.files.study.known import known_at
from elastocal.files.study.study_file import parse_study, read_study
from elastocal.files.texts import read_text
from elastocal.identification.identify import identify
from elastocal.identification.nuisance_found import in_short
from elastocal.identification.result import Identification
from elastocal.identification.search import searched
from elastocal.identification.validation import Validation, validate
from elastocal.measuring.measurements import Measurements
from elastocal.planning.plan import Plan, plan
from elastocal.report.contents import Contents
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.simulation.true_robot import TrueRobot
from elastocal.simulation.virtual_campaign import simulate
from elastocal.study.at_test_poses import at_test_poses
from elastocal.study.study import Study
from elastocal.study.two_steps import with_known
from elastocal.terminal.compensations import show_compensation
from elastocal.terminal.console import micrometres
from elastocal.terminal.console import out as console
from elastocal.terminal.identifications import show_identification, show_validation
from elastocal.terminal.plans import show_plan
from elastocal.terminal.progress import progress
from elastocal.terminal.stiffness import show_errors_left, show_stiffness
from elastocal.writing import write_text

GIVEN = ("study_path.yaml", "study_a1.yaml", "truth.json", "path.csv")
MADE = {
    "plan": ("plan.json", "plan_a1.json"),
    "run sheet": ("plan.csv", "plan_a1.csv"),
    "measurements": ("measurements.csv", "measurements_a1.csv", "validation.csv"),
    "model": ("model_a2_a6.json", "model.json"),
    "corrected path": ("corrected.csv",),
    "report": ("report.html",),
}
"""Files that the demo makes, by their kind."""
_KEPT_ASIDE = 8  # random experiments to validate with
_CAMPAIGNS = 2000


def do_job(folder: Path, seed: int, force: bool) -> None:
    """Do the whole job on the robot of the paper, writing every file to a folder."""
    _prepare(folder, force)
    studies = [read_study(folder / name) for name in ("study_path.yaml", "study_a1.yaml")]
    truth = read_model(folder / "truth.json", studies[0].robot)
    rng = np.random.default_rng([seed, 2])
    _say("1. Plan, for a milling path, the experiments that identify A2 to A6 under a hung weight")
    made = _plan(studies[0], folder / "plan.json", seed)
    _compare_with_one_pose(made, seed)
    _say("2. Measure and identify (a virtual robot bends; a virtual laser tracker measures)")
    first = _measure(
        studies[0], truth, (made.load_cases, made.repeats), folder / "measurements.csv", rng
    )
    identification = _identify(studies[0], first, folder / "model_a2_a6.json")
    _say("3. The same for A1, which only a sideways force can move")
    known = known_at(folder / "model_a2_a6.json", studies[1].robot, parse_study)
    after = with_known(studies[1], known)
    other = _plan(after, folder / "plan_a1.json", seed)
    second = _measure(
        after, truth, (other.load_cases, other.repeats), folder / "measurements_a1.csv", rng
    )
    whole = _identify(after, second, folder / "model.json")
    _say(f"4. Validate on {_KEPT_ASIDE} experiments that were not used")
    validation = _validate(studies[0], whole.model, truth, folder / "validation.csv", rng)
    contents = Contents(
        made,
        identification=identification,
        references={"truth": truth},
        validation=validation,
        at_test_poses=at_test_poses(studies[0], whole.model, whole.width),
    )
    _say("5. Correct a milling path of 200 points for the process force")
    contents = _compensate(contents, whole.model, truth, folder)
    _say(f"6. Report, with {_CAMPAIGNS} campaigns like this one")
    contents = replace(contents, monte_carlo=_campaigns(made, truth, rng))
    write_report(contents, folder / "report.html", quick=False, seed=seed)
    print(f"everything is in {folder}: " + ", ".join(sorted(p.name for p in folder.iterdir())))


def _say(what: str) -> None:
    """The name of a step."""
    console.print(Text(f"\n{what}\n", style="bold"))


def _prepare(folder: Path, force: bool) -> None:
    """The files of the example, in a folder that holds no others of their names."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    given = {name: read_text(demo_file(name)) for name in GIVEN}
    for name, text in given.items():
        writable(folder / name)
        replaceable(folder / name, "example", force=force, text=text)
    for kind, names in MADE.items():
        for name in names:
            writable(folder / name)
            replaceable(folder / name, kind, force=force)
    for name, text in given.items():
        write_text(folder / name, text)


def _plan(study: Study, out: Path, seed: int) -> Plan:
    """A plan, written and shown."""
    made = planned(study, out, seed)
    show_plan(made)
    return made


def _compare_with_one_pose(path_plan: Plan, seed: int) -> None:
    """Say what a plan for the single pose of the study would leave along its path."""
    study = path_plan.study
    pose, path = study.test_poses
    poses = (replace(pose, weight=1.0), replace(path, weight=0.0))
    with progress("planning for one pose") as tell:
        alone = plan(replace(study, test_poses=poses), seed=seed, progress=tell).assessment
    at, worst = alone.rho0_each[1], alone.worst_points[1]
    assert worst is not None
    more = at / path_plan.assessment.rho0 - 1.0
    console.print(
        Text(
            f"A plan for the one pose {pose.name!r} would leave {micrometres(at)} along the path, "
            f"{micrometres(worst.rho0)} at its worst point: {100 * more:.0f} % more from as many "
            "experiments."
        )
    )


def _measure(
    study: Study,
    truth: ComplianceModel,
    plan: tuple[LoadCases, IntArray],
    out: Path,
    rng: np.random.Generator,
) -> Measurements:
    """Load cases with repeats, measured, written and read back as of a real campaign."""
    write_measurements(simulate(study, truth, *plan, rng), study.robot, out)
    return read_measurements(out, study)


def _identify(study: Study, data: Measurements, out: Path) -> Identification:
    """A model, written and shown with the error that it leaves and the stiffness at the task."""
    identification = identify(study.arm, data, known=known_model(None, study))
    beyond = searched(identification, study.coupling)
    write_identification(study, identification, out, beyond=beyond)
    show_identification(identification, beyond)
    there = at_test_poses(study, identification.model, identification.width)
    show_errors_left(there, in_short(identification), nuisance=identification.nuisance is not None)
    if not there or not there[0].cartesian.rigid:
        show_stiffness(there)
    return identification


def _validate(
    study: Study,
    model: ComplianceModel,
    truth: ComplianceModel,
    out: Path,
    rng: np.random.Generator,
) -> Validation:
    """Random experiments the model has not seen, and how well it predicts them."""
    data = _measure(study, truth, _random_plan(study, _KEPT_ASIDE, rng), out, rng)
    validation = validate(study.arm, model, kept_aside(data), errors=errors_of(study))
    show_validation(validation)
    return validation


def _random_plan(study: Study, count: int, rng: np.random.Generator) -> tuple[LoadCases, IntArray]:
    """Random load cases that the study allows, each measured once."""
    cases = study.space.load_cases(study.space.sample(count, rng))
    return cases, np.ones(len(cases), dtype=np.int64)


def _compensate(
    contents: Contents, model: ComplianceModel, truth: ComplianceModel, folder: Path
) -> Contents:
    """The contents with a corrected path, and what is left of its error on the true robot."""
    assert contents.plan is not None
    study = contents.plan.study
    tool = tool_called(study, None)
    task = read_path(folder / "path.csv", study.robot, tool, start_of(study, tool))
    arm = replace(study.arm, springs=model.springs, tool=tool)
    done = compensate(arm, model, task.cases, errors_of(study))
    contents = with_compensation(contents, done, TrueRobot(truth))
    write_corrected(done, task, folder / "corrected.csv")
    show_compensation(done, task, contents.judged)
    return contents


def _campaigns(plan: Plan, truth: ComplianceModel, rng: np.random.Generator) -> MonteCarlo:
    """Thousands of such campaigns, beside those of a random plan of as many experiments."""
    others = {"a random plan": _random_plan(plan.study, plan.count, rng)}
    return virtual_campaigns(plan, others, truth, _CAMPAIGNS)
