"""`compensate`: correct a path so that the loaded tool is where the task wants it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

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
from elastocal.errors import InputError


@app.command("compensate")
def compensate_command(
    study_file: StudyPath,
    model: Annotated[
        Path, typer.Argument(help="Compliances, or calibrated robot (JSON).", show_default=False)
    ],
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
    station: Annotated[
        str | None, typer.Option(help="Of a calibrated robot: station in whose frame the task is.")
    ] = None,
    tracker: Annotated[
        bool, typer.Option("--tracker", help="Poses of the path are in the frame of the station.")
    ] = False,
    mounting: Annotated[
        str | None, typer.Option(help="Of a calibrated robot: mounting of its tool.")
    ] = None,
    payload: Annotated[
        str | None, typer.Option(help="Of a calibrated robot: what hangs on its flange, or none.")
    ] = None,
    point: Annotated[
        str | None, typer.Option(help="Of a calibrated robot: TCP, or the reflector to be there.")
    ] = None,
    force: Overwrite = False,
    as_json: Json = False,
) -> None:
    """Correct a path for the deflection under its load, and for what else a calibration found."""
    from elastocal.files.models.calibration_kind import is_calibration

    given_besides = {
        "--station": station,
        "--tracker": tracker or None,
        "--mounting": mounting,
        "--payload": payload,
        "--point": point,
    }
    if is_calibration(model):
        from elastocal.cli.calibrated import Task, compensate_by_calibration

        refused = {
            "--model": more,
            "--tool": tool,
            "--truth": truth,
            "--rule": None if rule == "nonlinear" else rule,
        }
        wanted = Task(path, force_n, torque_nm, start, station, tracker, mounting, payload, point)
        compensate_by_calibration(
            study_file, model, wanted, out, to, refused,
            script_node=for_script_node, force=force, as_json=as_json,
        )  # fmt: skip
        return
    if others := [option for option, value in given_besides.items() if value is not None]:
        raise InputError(f"{others[0]} is for calibrated robots, which {model} is not")
    from elastocal.cli.corrected import path_program_of, refuse_undrivable
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
    refuse_undrivable(done, task)
    # The program first: it can be refused.
    models = [model, *(more or [])]
    settings = Settings(coupling=converted(study), script_node=for_script_node)
    told = path_program_of(study, done, task, to, settings, out, given, models, force) if to else []
    write_corrected(done, task, out)
    if not as_json:
        print("\n".join([*told, f"wrote {out}"]))
