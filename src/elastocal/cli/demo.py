"""`demo`: the whole job on the robot of the paper, with a virtual robot in place of a real one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import Seed, app, demo_file, guarded
from elastocal.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from elastocal.arrays import IntArray
    from elastocal.elastic.compliance_model import ComplianceModel
    from elastocal.elastic.load_cases import LoadCases
    from elastocal.identification.result import Identification
    from elastocal.identification.validation import Validation
    from elastocal.measuring.measurements import Measurements
    from elastocal.planning.plan import Plan
    from elastocal.report.contents import Contents
    from elastocal.simulation.monte_carlo import MonteCarlo
    from elastocal.study.study import Study

GIVEN = ("study.yaml", "study_a1.yaml", "truth.json", "path.csv")
_KEPT_ASIDE = 8  # random experiments to validate with
_CAMPAIGNS = 2000


@app.command("demo")
@guarded
def demo_command(
    folder: Annotated[Path, typer.Argument(help="Folder to write to.")] = Path("demo"),
    seed: Seed = 0,
) -> None:
    """Do the whole job on the KUKA KR 270 of the paper, from plan to corrected path and report."""
    import numpy as np

    from elastocal.cli.stages import write_report
    from elastocal.files.models.model_file import read_model
    from elastocal.files.study.study_file import read_study
    from elastocal.report.contents import Contents

    _prepare(folder)
    studies = [read_study(folder / name) for name in ("study.yaml", "study_a1.yaml")]
    truth = read_model(folder / "truth.json", studies[0].robot)
    rng = np.random.default_rng([seed, 2])
    _say("1. Plan the experiments that identify A2 to A6 under a hung weight")
    plan = _plan(studies[0], folder / "plan.json", seed)
    _say("2. Measure and identify (a virtual robot bends; a virtual laser tracker measures)")
    first = _measure(plan, truth, folder / "measurements.csv", rng)
    identification = _identify(studies[0], first, folder / "model_a2_a6.json")
    _say("3. The same for A1, which only a sideways force can move")
    other = _plan(studies[1], folder / "plan_a1.json", seed)
    second = _measure(other, truth, folder / "measurements_a1.csv", rng)
    whole = _identify(studies[1], second, folder / "model.json", identification.model)
    _say(f"4. Validate on {_KEPT_ASIDE} experiments that were not used")
    validation = _validate(studies[0], whole.model, truth, folder / "validation.csv", rng)
    contents = Contents(
        plan,
        identification=identification,
        references={"truth": truth},
        validation=validation,
    )
    _say("5. Correct a milling path of 200 points for the process force")
    contents = _compensate(contents, whole.model, truth, folder)
    _say(f"6. Report, with {_CAMPAIGNS} campaigns like this one")
    contents = replace(contents, monte_carlo=_campaigns(plan, truth, rng))
    write_report(contents, folder / "report.html", quick=False, seed=seed)
    print(f"everything is in {folder}: " + ", ".join(sorted(p.name for p in folder.iterdir())))


def _say(what: str) -> None:
    """The name of a step."""
    from rich.text import Text

    from elastocal.terminal.console import out

    out.print(Text(f"\n{what}\n", style="bold"))


def _prepare(folder: Path) -> None:
    """The files of the example, in a folder that holds nothing else."""
    from elastocal.files.texts import read_text, write_text

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror})") from None
    for name in GIVEN:
        text = read_text(demo_file(name))
        if (folder / name).exists() and read_text(folder / name) != text:
            raise InputError(
                f"{folder / name}: exists and is not the demo's; choose another folder"
            )
        write_text(folder / name, text)


def _plan(study: Study, out: Path, seed: int) -> Plan:
    """A plan, written and shown."""
    from elastocal.cli.planning import planned
    from elastocal.terminal.plans import show_plan

    made = planned(study, out, seed)
    show_plan(made)
    return made


def _measure(
    plan: Plan, truth: ComplianceModel, out: Path, rng: np.random.Generator
) -> Measurements:
    """A virtual campaign, written and read back as a real one would be."""
    return _measured(plan.study, truth, (plan.load_cases, plan.repeats), out, rng)


def _measured(
    study: Study,
    truth: ComplianceModel,
    plan: tuple[LoadCases, IntArray],
    out: Path,
    rng: np.random.Generator,
) -> Measurements:
    """Load cases with repeats, measured by the virtual robot."""
    from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
    from elastocal.simulation.virtual_campaign import simulate

    write_measurements(simulate(study, truth, *plan, rng), study.robot, out)
    return read_measurements(out, study)


def _identify(
    study: Study, data: Measurements, out: Path, known: ComplianceModel | None = None
) -> Identification:
    """A model, written and shown."""
    from elastocal.cli.stages import write_identification
    from elastocal.identification.identify import identify
    from elastocal.terminal.identifications import show_identification

    identification = identify(study.arm, data, known=known)
    write_identification(study, identification, out)
    show_identification(identification)
    return identification


def _validate(
    study: Study,
    model: ComplianceModel,
    truth: ComplianceModel,
    out: Path,
    rng: np.random.Generator,
) -> Validation:
    """Random experiments the model has not seen, and how well it predicts them."""
    from elastocal.files.measurements.suspicious import kept_aside
    from elastocal.identification.validation import validate
    from elastocal.terminal.identifications import show_validation

    data = _measured(study, truth, _random_plan(study, _KEPT_ASIDE, rng), out, rng)
    validation = validate(study.arm, model, kept_aside(data, study))
    show_validation(validation)
    return validation


def _random_plan(study: Study, count: int, rng: np.random.Generator) -> tuple[LoadCases, IntArray]:
    """Random load cases that the study allows, each measured once."""
    import numpy as np

    cases = study.space.load_cases(study.space.sample(count, rng))
    return cases, np.ones(count, dtype=np.int64)


def _compensate(
    contents: Contents, model: ComplianceModel, truth: ComplianceModel, folder: Path
) -> Contents:
    """The contents with a corrected path, and what is left of its error on the true robot."""
    from elastocal.cli.inputs import start_of, tool_called
    from elastocal.cli.stages import with_compensation
    from elastocal.compensation.compensate import compensate
    from elastocal.files.paths.corrected_file import write_corrected
    from elastocal.files.paths.path_file import read_path
    from elastocal.terminal.compensations import show_compensation

    assert contents.plan is not None
    study = contents.plan.study
    tool = tool_called(study, None)
    task = read_path(folder / "path.csv", study.robot, tool, start_of(study, tool))
    arm = replace(study.arm, springs=model.springs, tool=tool)
    done = compensate(arm, model, task.cases)
    contents = with_compensation(contents, done, truth)
    write_corrected(done, task, folder / "corrected.csv")
    show_compensation(done, task, contents.judged)
    return contents


def _campaigns(plan: Plan, truth: ComplianceModel, rng: np.random.Generator) -> MonteCarlo:
    """Thousands of such campaigns, beside those of a random plan of as many experiments."""
    from elastocal.cli.stages import virtual_campaigns

    others = {"a random plan": _random_plan(plan.study, plan.count, rng)}
    return virtual_campaigns(plan, others, truth, _CAMPAIGNS)
