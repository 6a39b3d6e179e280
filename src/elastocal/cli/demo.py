"""`demo`: the whole job on the robot of the paper, with a virtual robot in place of a real one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from elastocal.cli.common import Seed, app, demo_file, guarded
from elastocal.cli.plan import planned
from elastocal.errors import InputError

if TYPE_CHECKING:
    import numpy as np

    from elastocal.elastic.compliance_model import ComplianceModel
    from elastocal.elastic.load_cases import LoadCases
    from elastocal.identification.result import Identification
    from elastocal.measuring.measurements import Measurements
    from elastocal.planning.plan import Plan
    from elastocal.study.study import Study

GIVEN = ("study.yaml", "study_a1.yaml", "truth.json", "path.csv")
_KEPT_ASIDE = 8  # random experiments to validate with
_CAMPAIGNS = 2000


@app.command()
@guarded
def demo(
    folder: Annotated[Path, typer.Argument(help="Folder to write to.")] = Path("demo"),
    seed: Seed = 0,
) -> None:
    """Do the whole job on the KUKA KR 270 of the paper, from plan to corrected path and report."""
    import numpy as np

    from elastocal.cli.report import write_report
    from elastocal.files.models.model_file import read_model

    _prepare(folder)
    studies = [_study(folder / name) for name in ("study.yaml", "study_a1.yaml")]
    truth = read_model(folder / "truth.json", studies[0].robot)
    rng = np.random.default_rng([seed, 2])
    _say("1. Plan the experiments that identify A2 to A6 under a hung weight")
    made = _plan(studies[0], folder / "plan.json", seed)
    _say("2. Measure and identify (a virtual robot bends; a virtual laser tracker measures)")
    first = _measure(studies[0], truth, made, folder / "measurements.csv", rng)
    found = _identify(studies[0], first, folder / "model_a2_a6.json")
    _say("3. The same for A1, which only a sideways force can move")
    other = _plan(studies[1], folder / "plan_a1.json", seed)
    second = _measure(studies[1], truth, other, folder / "measurements_a1.csv", rng)
    whole = _identify(studies[1], second, folder / "model.json", found.model)
    _say(f"4. Validate on {_KEPT_ASIDE} experiments that were not used")
    judged = _validate(studies[0], whole.model, truth, folder / "validation.csv", rng)
    _say("5. Correct a milling path of 200 points for the process force")
    path = _compensate(studies[0], whole.model, truth, folder)
    _say(f"6. Report, with {_CAMPAIGNS} campaigns like this one")
    further = {"identification": found, "validation": judged, "references": {"truth": truth}}
    further |= path | _campaigns(made, truth, rng)
    write_report(made, folder / "report.html", {}, False, seed, further)
    print(f"everything is in {folder}: " + ", ".join(sorted(p.name for p in folder.iterdir())))


def _say(what: str) -> None:
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


def _study(path: Path) -> Study:
    from elastocal.files.study.study_file import read_study

    return read_study(path)


def _plan(study: Study, out: Path, seed: int) -> Plan:
    from elastocal.terminal.plans import show_plan

    made = planned(study, out, seed)
    show_plan(made)
    return made


def _measure(
    study: Study, truth: ComplianceModel, plan: Plan, out: Path, rng: np.random.Generator
) -> Measurements:
    """A virtual campaign, written and read back as a real one would be."""
    return _measured(study, truth, plan.load_cases, plan.repeats, out, rng)


def _measured(
    study: Study, truth: ComplianceModel, cases: LoadCases, repeats: Any, out: Path,
    rng: np.random.Generator,
) -> Measurements:  # fmt: skip
    from elastocal.files.measurements.measurement_file import read_measurements, write_measurements
    from elastocal.simulation.virtual_campaign import simulate

    write_measurements(simulate(study, truth, cases, repeats, rng), study.robot, out)
    return read_measurements(out, study)


def _identify(
    study: Study, data: Measurements, out: Path, known: ComplianceModel | None = None
) -> Identification:
    from elastocal.cli.identify import provenance
    from elastocal.files.models.identification_section import identification_sections
    from elastocal.files.models.model_file import write_model
    from elastocal.identification.identify import identify
    from elastocal.terminal.identifications import show_identification

    found = identify(study.arm, data, known=known)
    origin, sections = provenance(study, data), identification_sections(found)
    write_model(found.model, out, study.robot, provenance=origin, sections=sections)
    show_identification(found)
    return found


def _validate(
    study: Study,
    model: ComplianceModel,
    truth: ComplianceModel,
    out: Path,
    rng: np.random.Generator,
) -> Any:
    """Random experiments the model has not seen, and how well it predicts them."""
    import numpy as np

    from elastocal.files.measurements.suspicious import kept_aside
    from elastocal.identification.validation import validate
    from elastocal.terminal.identifications import show_validation

    cases = study.space.load_cases(study.space.sample(_KEPT_ASIDE, rng))
    once = np.ones(len(cases), dtype=np.int64)
    data = kept_aside(_measured(study, truth, cases, once, out, rng), study)
    judged = validate(study.arm, model, data)
    show_validation(judged)
    return judged


def _compensate(
    study: Study, model: ComplianceModel, truth: ComplianceModel, folder: Path
) -> dict[str, Any]:
    """The corrected path, and what is left of its error on the true robot."""
    from elastocal.cli.compensate import start_of, task_tool
    from elastocal.cli.stages import compensated
    from elastocal.files.paths.corrected_file import write_corrected
    from elastocal.files.paths.path_file import read_path
    from elastocal.terminal.compensations import show_compensation

    done = compensated(study, folder / "path.csv", model, truth, None)
    tool = task_tool(study, None)
    task = read_path(folder / "path.csv", study.robot, tool, start_of(study, tool, None))
    write_corrected(done["compensation"], task, folder / "corrected.csv")
    show_compensation(done["compensation"], task, done["judged"])
    return done


def _campaigns(plan: Plan, truth: ComplianceModel, rng: np.random.Generator) -> dict[str, Any]:
    """Thousands of such campaigns, beside those of a random plan of as many experiments."""
    import numpy as np

    from elastocal.cli.stages import virtual_campaigns

    space, count = plan.study.space, plan.count
    random = space.load_cases(space.sample(count, rng))
    others = {"a random plan": (random, np.ones(count, dtype=np.int64))}
    return {"monte_carlo": virtual_campaigns(plan, others, truth, _CAMPAIGNS)}
