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
from elastocal.cli.inputs import errors_of, start_of, tool_called
from elastocal.cli.planning import planned
from elastocal.cli.stages import (
    virtual_campaigns,
    with_compensation,
    write_report,
)
from elastocal.compensation.compensate import compensate
from elastocal.compensation.remaining import rms
from elastocal.elastic.compliance_model import ComplianceModel
from elastocal.elastic.load_cases import LoadCases
from elastocal.errors import InputError
from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
from elastocal.files.measurements.suspicious import kept_aside
from elastocal.files.models.identification_file import write_identification
from elastocal.files.models.model_file import read_model
from elastocal.files.models.truth_file import write_truth
from elastocal.files.paths.corrected_file import write_corrected
from elastocal.files.paths.path_file import read_path
from elastocal.files.study.study_file import read_study
from elastocal.files.texts import read_text
from elastocal.identification.identify import identify
from elastocal.identification.result import Identification
from elastocal.identification.search import searched
from elastocal.identification.validation import Validation, validate
from elastocal.measuring.measurements import Measurements
from elastocal.planning.plan import Plan
from elastocal.planning.to_validate import to_validate
from elastocal.report.contents import Contents
from elastocal.simulation.campaigns import MonteCarlo
from elastocal.simulation.true_robot import TrueRobot, true_robot
from elastocal.simulation.virtual_campaign import Reality, simulate
from elastocal.study.at_test_poses import at_test_poses
from elastocal.study.study import Study
from elastocal.terminal.compensations import show_compensation
from elastocal.terminal.console import micrometres
from elastocal.terminal.console import out as console
from elastocal.terminal.fitted_along import in_short
from elastocal.terminal.identifications import show_identification, show_validation
from elastocal.terminal.plans import show_plan
from elastocal.terminal.stiffness import show_errors_left, show_stiffness
from elastocal.writing import write_text

GIVEN = ("study_aslant.yaml", "truth.json", "path.csv")
MADE = {
    "plan": ("plan.json",),
    "run sheet": ("plan.csv",),
    "measurements": ("measurements.csv", "validation.csv"),
    "model": ("true_robot.json", "model.json"),
    "corrected path": ("corrected.csv",),
    "report": ("report.html",),
}
"""Files that the demo makes, by their kind."""
_KEPT_ASIDE = 8  # experiments to validate with
_CAMPAIGNS = 25  # each on another robot


def do_job(folder: Path, seed: int, force: bool) -> None:
    """Do the whole job on the robot of the paper, writing every file to a folder."""
    _prepare(folder, force)
    study = read_study(folder / "study_aslant.yaml")
    joints = read_model(folder / "truth.json", study.robot)
    rng = np.random.default_rng([seed, 2])
    _say("1. Plan, for a milling path, the experiments that identify all joints, pulled aslant")
    made = _plan(study, folder / "plan.json", seed)
    _say("2. Measure and identify (a virtual robot bends; a virtual laser tracker measures)")
    true = true_robot(study, joints, rng)
    write_truth(true, folder / "true_robot.json", study.robot)
    _introduce(study, true)
    data = _measure(study, true, (made.load_cases, made.repeats), folder / "measurements.csv", rng)
    found = _identify(study, data, folder / "model.json")
    _say(f"3. Validate on {_KEPT_ASIDE} experiments far from those that were used")
    others = to_validate(study, made.load_cases, _KEPT_ASIDE, seed=seed)
    apart = others.load_cases, others.repeats
    validation = _validate(study, found.model, true, apart, folder / "validation.csv", rng)
    contents = Contents(
        made,
        identification=found,
        references={"truth": joints},
        validation=validation,
        at_test_poses=at_test_poses(study, found.model, found.width),
    )
    _say("4. Correct a milling path of 200 points for the process force")
    contents = _compensate(contents, found, true, folder)
    _say(f"5. Report, with {_CAMPAIGNS} campaigns like this one, each on another robot")
    contents = replace(contents, monte_carlo=_campaigns(made, joints))
    write_report(contents, folder / "report.html", quick=True, seed=seed)
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


def _introduce(study: Study, true: TrueRobot) -> None:
    """What the virtual robot is, which nothing of the campaign knows."""
    assert study.nuisance is not None
    beside = len(true.model.names) - len(study.robot.joints)
    gain = 0.0 if true.loads is None else true.loads.gain
    console.print(
        Text(
            f"The robot has {beside} springs beside its joints, drawn by chance as typical ones "
            f"are; all loads are {100 * gain:+.2f} % of what is recorded, and each load case has "
            "friction and a discrepancy of its own. Its deflections are those of its equilibrium. "
            "Only true_robot.json knows.\n"
        )
    )


def _measure(
    study: Study,
    true: TrueRobot,
    plan: tuple[LoadCases, IntArray],
    out: Path,
    rng: np.random.Generator,
) -> Measurements:
    """Load cases with repeats, measured, written and read back as of a real campaign."""
    reality = Reality(loads=true.loads, errors=true.errors)
    write_measurements(simulate(study, true.model, *plan, rng, reality=reality), study.robot, out)
    return read_measurements(out, study)


def _identify(study: Study, data: Measurements, out: Path) -> Identification:
    """A model, written and shown with the error that it leaves and the stiffness at the task."""
    identification = identify(study.arm, data, nuisance=study.nuisance)
    beyond = searched(identification, study.coupling)
    write_identification(study, identification, out, beyond=beyond)
    show_identification(identification, beyond)
    there = at_test_poses(study, identification.model, identification.width)
    show_errors_left(there, in_short(identification), nuisance=identification.nuisance is not None)
    if not there or not there[0].cartesian.rigid:
        show_stiffness(there[:1])
    return identification


def _validate(
    study: Study,
    model: ComplianceModel,
    true: TrueRobot,
    apart: tuple[LoadCases, IntArray],
    out: Path,
    rng: np.random.Generator,
) -> Validation:
    """Experiments the model has not seen, and how well it predicts them."""
    data = _measure(study, true, apart, out, rng)
    validation = validate(study.arm, model, kept_aside(data), errors=errors_of(study))
    show_validation(validation)
    return validation


def _compensate(
    contents: Contents, found: Identification, true: TrueRobot, folder: Path
) -> Contents:
    """The contents with a corrected path, and what is left of its error on the true robot."""
    assert contents.plan is not None
    study = contents.plan.study
    tool = tool_called(study, None)
    task = read_path(folder / "path.csv", study.robot, tool, start_of(study, tool))
    model = found.model
    arm = replace(study.arm, springs=model.springs, tool=tool)
    done = compensate(arm, model, task.cases, errors_of(study))
    contents = with_compensation(contents, done, true)
    write_corrected(done, task, folder / "corrected.csv")
    show_compensation(done, task, contents.judged)
    if found.alone is not None:
        _compare_with_joints_alone(contents, found.alone.model, true)
    return contents


def _compare_with_joints_alone(contents: Contents, model: ComplianceModel, true: TrueRobot) -> None:
    """Say what the fit of the joints alone, from the same readings, would leave in truth."""
    done = contents.compensation
    assert done is not None
    arm = replace(done.arm, springs=model.springs)
    alone = with_compensation(Contents(), compensate(arm, model, done.cases), true)
    assert alone.judged is not None
    assert alone.compensation is not None
    claimed, left = rms(alone.compensation.rho0), rms(alone.judged)
    console.print(
        Text(
            "From the same readings, fitted as if nothing but the joints gave way, "
            f"{micrometres(left)} are left in truth, where {micrometres(claimed)} are claimed."
        )
    )


def _campaigns(plan: Plan, joints: ComplianceModel) -> MonteCarlo:
    """Such campaigns, each on another robot."""
    return virtual_campaigns(plan, {}, TrueRobot(joints), _CAMPAIGNS)
