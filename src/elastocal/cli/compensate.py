"""`compensate`: correct a path so that the loaded tool is where the task wants it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import Json, StudyPath, app, guarded, print_json, study_at, writable
from elastocal.errors import InfeasibleError, InputError

if TYPE_CHECKING:
    from elastocal.arrays import Array
    from elastocal.compensation.compensate import Compensation
    from elastocal.files.paths.path_file import ToolPath
    from elastocal.robot.chain import Tool
    from elastocal.study.study import Study

Vector = tuple[float, float, float]


@app.command()
@guarded
def compensate(
    study: StudyPath,
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
    force_n: Annotated[
        Vector | None, typer.Option(help="Force of every point, base frame.", show_default=False)
    ] = None,
    torque_nm: Annotated[
        Vector | None, typer.Option(help="Torque of every point, base frame.", show_default=False)
    ] = None,
    start: Annotated[
        str | None,
        typer.Option(help='Near the first point, for paths of poses: "A1=0deg A2=-90deg …".'),
    ] = None,
    truth: Annotated[
        Path | None, typer.Option(help="True compliances, to judge the correction by.")
    ] = None,
    to: Annotated[
        str | None,
        typer.Option(help="Robot program to write beside: krl, rapid, fanuc, urscript, ros, csv."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Correct a path for the deflection under its load; say what error remains."""
    import numpy as np

    from elastocal.compensation import compensate as rules
    from elastocal.elastic.compliance_model import merged_models
    from elastocal.files.models.model_file import read_model
    from elastocal.files.paths.corrected_file import corrected_document, write_corrected
    from elastocal.files.paths.path_file import read_path

    given = [study, model, path, *(more or []), *([truth] if truth else [])]
    writable(out, *given, suffix=".csv")
    known = {"nonlinear": rules.compensate, "linear": rules.compensate_linearly}
    if rule not in known:
        raise InputError(f"no rule {rule!r}; there are {', '.join(known)}")
    what = study_at(study)
    robot, used = what.robot, task_tool(what, tool)
    compliances = merged_models([read_model(file, robot) for file in (model, *(more or []))])
    wrench = None
    if force_n is not None or torque_nm is not None:
        wrench = np.array([*(force_n or (0.0, 0.0, 0.0)), *(torque_nm or (0.0, 0.0, 0.0))])
    task = read_path(path, robot, used, start_of(what, used, start), wrench)
    arm = replace(what.arm, springs=compliances.springs, tool=used)
    done = known[rule](arm, compliances, task.cases)
    residual = None
    if truth is not None:
        true = read_model(truth, robot)
        residual = rules.residual(replace(arm, springs=true.springs), true, done)
    if as_json:
        print_json(corrected_document(done, task, residual))
    else:
        from elastocal.terminal.compensations import show_compensation

        show_compensation(done, task, residual)
    _refuse(done, task)
    # The program first: it can be refused.
    files = _program(what, done, task, to, out, given) if to else []
    write_corrected(done, task, out)
    if not as_json:
        print("wrote " + " and ".join(str(file) for file in (out, *files)))


def _program(
    study: Study, done: Compensation, task: ToolPath, to: str, out: Path, given: list[Path]
) -> list[Path]:
    """Write the corrected path as a robot program, named like the corrected file."""
    from elastocal.cli.export import write_program
    from elastocal.programs.robot_program import Provenance, path_program
    from elastocal.programs.writers import Settings

    program = path_program(
        study.robot,
        done.q,
        name=f"{out.stem} program" if to == "csv" else out.stem,
        purpose=f"Path {Path(task.source).name} corrected for its loads, {done.rule} rule.",
        provenance=Provenance(study.name, task.sha256),
    )
    coupled = study.controller is not None and not study.controller.is_identity
    settings = Settings(coupling=study.controller if coupled else None)
    return write_program(program, to, settings, out.parent, "", *given, out)


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


def task_tool(study: Study, name: str | None) -> Tool:
    """The tool called `name`, else the one of all test poses."""
    posed = {pose.tool.name: pose.tool for pose in study.test_poses if pose.tool is not None}
    if name is None:
        if len(posed) != 1:
            raise InputError(
                f"the test poses have {', '.join(posed) or 'no tool'}; name one with --tool"
            )
        return next(iter(posed.values()))
    calibration = study.experiments.tool
    tools = study.robot.tools | {calibration.name: calibration} | posed
    if name not in tools:
        raise InputError(f"no tool {name!r}; there are {', '.join(tools)}")
    return tools[name]


def start_of(study: Study, tool: Tool, text: str | None) -> Array:
    """Configuration to start from: as named, else a test pose, with the same tool if possible."""
    import numpy as np

    if text is not None:
        from elastocal.cli.export import home_values

        return home_values(text, study.robot, "start")
    poses = sorted(
        (pose for pose in study.test_poses if pose.case is not None and pose.tool is not None),
        key=lambda pose: pose.tool is None or pose.tool.name != tool.name,
    )
    if poses and poses[0].case is not None:
        return poses[0].case.q[0]
    return np.asarray(0.5 * (study.limits[0] + study.limits[1]))
