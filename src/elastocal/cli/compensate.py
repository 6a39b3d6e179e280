"""`compensate`: correct a path so that the loaded tool is where the task wants it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import (
    CONTROLLERS,
    Force,
    Json,
    Overwrite,
    ScriptNode,
    Start,
    StudyPath,
    Torque,
    app,
    print_json,
    replaceable,
    writable,
)
from elastocal.errors import InfeasibleError, InputError

if TYPE_CHECKING:
    from elastocal.compensation.compensate import Compensation
    from elastocal.files.paths.path_file import ToolPath
    from elastocal.programs.writers import Settings
    from elastocal.study.study import Study


@app.command("compensate")
def compensate_command(
    study_file: StudyPath,
    model: Annotated[Path, typer.Argument(help="Compliances (JSON).", show_default=False)],
    path: Annotated[Path, typer.Argument(help="Path (CSV).", show_default=False)],
    out: Annotated[Path, typer.Option("--out", "-o", help="Corrected path to write.")] = Path(
        "corrected.csv"
    ),
    more: Annotated[
        list[Path] | None, typer.Option("--model", help="Further compliances, of other joints.")
    ] = None,
    tool: Annotated[str | None, typer.Option(help="Tool, if the test poses have several.")] = None,
    rule: Annotated[str, typer.Option(help="nonlinear or linear.")] = "nonlinear",
    force_n: Force = None,
    torque_nm: Torque = None,
    start: Start = None,
    truth: Annotated[
        Path | None, typer.Option(help="True compliances, to judge the correction by.")
    ] = None,
    to: Annotated[
        str | None,
        typer.Option(help=f"Robot program to write beside: {CONTROLLERS}."),
    ] = None,
    for_script_node: ScriptNode = False,
    force: Overwrite = False,
    as_json: Json = False,
) -> None:
    """Correct a path for the deflection under its load; say what error remains."""
    from elastocal.cli.inputs import errors_of, load, models_at, sources_of, start_of, tool_called
    from elastocal.cli.programs import converted
    from elastocal.compensation.compensate import RULES, residual
    from elastocal.files.models.stiffness_section import pose_entries
    from elastocal.files.models.truth_file import read_truth
    from elastocal.files.paths.corrected_file import corrected_document, write_corrected
    from elastocal.files.paths.path_file import read_path
    from elastocal.files.study.study_file import read_study
    from elastocal.fitting.goodness import quantile
    from elastocal.programs.writers import Settings
    from elastocal.study.at_test_poses import at_test_poses

    given = [study_file, model, path, *(more or []), *([truth] if truth else [])]
    writable(out, *given, suffix=".csv")
    if rule not in RULES:
        raise InputError(f"no rule {rule!r}; there are {', '.join(RULES)}")
    study = read_study(study_file)
    given += sources_of(study, study_file)
    writable(out, *given)
    replaceable(out, "corrected path", force=force)
    used = tool_called(study, tool)
    compliances = models_at([model, *(more or [])], study.robot)
    wrench = load(force_n, torque_nm)
    task = read_path(path, study.robot, used, start_of(study, used, start), wrench)
    arm = replace(study.arm, springs=compliances.springs, tool=used)
    done = RULES[rule](arm, compliances, task.cases, errors_of(study))
    remaining = None
    if truth is not None:
        true = read_truth(truth, study.robot)
        bent = replace(arm, springs=true.model.springs)
        remaining = residual(bent, true.model, done, gain=true.process_gain)
    there = at_test_poses(study, compliances, quantile(0.975, compliances.dof))
    if as_json:
        document = corrected_document(done, task, remaining)
        print_json(document | {"test_poses": pose_entries(there)})
    else:
        from elastocal.terminal.compensations import show_compensation
        from elastocal.terminal.stiffness import show_stiffness

        show_compensation(done, task, remaining)
        show_stiffness(there)
    _refuse(done, task)
    # The program first: it can be refused.
    models = [model, *(more or [])]
    settings = Settings(coupling=converted(study), script_node=for_script_node)
    told = _program(study, done, task, to, settings, out, given, models, force) if to else []
    write_corrected(done, task, out)
    if not as_json:
        print("\n".join([*told, f"wrote {out}"]))


def _program(
    study: Study,
    done: Compensation,
    task: ToolPath,
    to: str,
    settings: Settings,
    out: Path,
    given: list[Path],
    models: list[Path],
    force: bool,
) -> list[str]:
    """Write the corrected path as a robot program, named after the corrected file; what to tell."""
    from elastocal.cli.programs import said, write_program
    from elastocal.files.texts import file_hash
    from elastocal.programs.robot_program import Provenance, path_program

    program = path_program(
        study.robot,
        done.q,
        name=out.stem,
        purpose=f"Path {Path(task.source).name} corrected for its loads, {done.rule} rule.",
        provenance=Provenance(
            study.name,
            task.sha256,
            of="path",
            beside=tuple(
                (what, file_hash(file))
                for what, files in (("model", models), ("study", given[:1]))
                for file in files
            ),
        ),
    )
    files = write_program(program, to, settings, out.parent, *given, out, force=force)
    return said(files, to, settings)


def _refuse(done: Compensation, task: ToolPath) -> None:
    """Write nothing that cannot be driven: name the first point and how many there are."""
    from elastocal.wording import together

    for wrong, what in (
        (~done.converged, "cannot be corrected"),
        (done.beyond_limits.any(axis=1), "would leave the joint limits"),
    ):
        if wrong.any():
            i = int(wrong.argmax())
            raise InfeasibleError(
                f"{task.source}: {int(wrong.sum())} of {len(done)} points {what}, the first is "
                f"point {task.names[i]} in line {task.lines[i]}: {together(done.doubts[i])}"
            )
