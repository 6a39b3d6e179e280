"""`export`: a plan for the robot's controller, or a calibrated robot for other programs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import (
    CONTROLLERS,
    ROBOT_FILES,
    Json,
    Overwrite,
    ScriptNode,
    app,
    note_parted,
    print_json,
)
from elastocal.errors import InfeasibleError, InputError

if TYPE_CHECKING:
    from elastocal.arrays import Array
    from elastocal.study.study import Study


@app.command("export")
def export_command(
    plan_file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Plan, or calibrated robot (model.json).")
    ],
    to: Annotated[str, typer.Option(help=f"{CONTROLLERS}; of a calibrated robot {ROBOT_FILES}.")],
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder, or a file whose name is the program's.")
    ] = Path("."),
    study_file: Annotated[
        Path | None,
        typer.Option("--study", help="Study, if not the one in the plan; with the robot as drawn."),
    ] = None,
    home: Annotated[
        str | None,
        typer.Option(help='Start and end, as the controller shows it: "A1=0deg rail=500mm".'),
    ] = None,
    prebias_deg: Annotated[
        float, typer.Option(help="Approach distance of turning joints, against backlash.")
    ] = 0.5,
    prebias_mm: Annotated[float, typer.Option(help="The same of sliding joints.")] = 1.0,
    settle_s: Annotated[float, typer.Option(help="Wait before every measurement.")] = 2.0,
    speed_percent: Annotated[float, typer.Option(help="Of the controller's full speed.")] = 10.0,
    external: Annotated[
        str | None, typer.Option(help='Joints that are external axes: "rail table".')
    ] = None,
    trigger: Annotated[
        str, typer.Option(help="Output that triggers the instrument: number or signal name.")
    ] = "",
    for_script_node: ScriptNode = False,
    force: Overwrite = False,
    as_json: Json = False,
) -> None:
    """Write a plan as a robot program, or a calibrated robot for other programs."""
    from elastocal.files.models.calibration_kind import is_calibration

    if is_calibration(plan_file):
        from elastocal.cli.calibrated import export_calibrated

        refused = {
            "--home": home is not None,
            "--external": external is not None,
            "--trigger": bool(trigger),
            "--for-script-node": for_script_node,
        }
        export_calibrated(plan_file, to, out, study_file, refused, force=force, as_json=as_json)
        return
    from dataclasses import replace

    import numpy as np

    from elastocal.cli.inputs import plan_and_study, sources_of
    from elastocal.cli.origins import note_origin, refuse_false_claims
    from elastocal.cli.programs import converted, said, write_program
    from elastocal.files.plans.plan_file import study_hash
    from elastocal.files.plans.proposal_file import study_for
    from elastocal.files.texts import file_hash
    from elastocal.programs.approach import Approach
    from elastocal.programs.campaign_program import campaign_program
    from elastocal.programs.writers import Settings, shows

    proposal, study = plan_and_study(plan_file, study_file)
    note_parted([plan_file])
    note_origin(plan_file.name, proposal, study, study_for(proposal, study).known)
    folder, name = _place(out, to)
    try:
        program = campaign_program(
            study,
            proposal.load_cases,
            proposal.repeats,
            name=name or study.name,
            home=_home(study, home),
            approach=Approach(float(np.radians(prebias_deg)), prebias_mm / 1e3, settle_s),
            speed=speed_percent / 100.0,
            digest=file_hash(plan_file),
            via=proposal.via,
        )
    except InfeasibleError as error:
        named = InfeasibleError(f"{plan_file.name}: {error}")
        raise named.with_doubts(*error.doubts) from None
    refuse_false_claims(plan_file.name, proposal, study)
    if study_file is not None:
        beside = (("study", file_hash(study_file)),)
        program = replace(program, provenance=replace(program.provenance, beside=beside))
    settings = Settings(
        coupling=converted(study),
        external=None if external is None else tuple(external.replace(",", " ").split()),
        trigger=trigger,
        name=name,
        script_node=for_script_node,
    )
    given = [plan_file, *([study_file] if study_file else [])]
    given += sources_of(study, given[-1])
    files = write_program(program, to, settings, folder, *given, force=force)
    if as_json:
        checked = {"file": (study_file or plan_file).name, "name": study.name}
        checked["sha256"] = study_hash(study)
        document = {"program": program.name, "files": [str(path) for path in files]}
        print_json(document | {"checked_by": checked})
        return
    from elastocal.terminal.programs import show_program

    doubtful = shows(to, study.robot, settings)
    show_program(program, to, coupled=settings.coupling is not None, shows=doubtful)
    print(f"Checked by {study_file.name if study_file else f'the study in {plan_file.name}'}.")
    print("\n".join(said(files, to, settings)))


def _home(study: Study, text: str | None) -> Array | None:
    """Home as given; that of the study where motions are watched; else none."""
    from elastocal.cli.inputs import joint_values

    if text is not None:
        return study.coupling.to_model(joint_values(text, study.robot, "home")[None])[0]
    return study.pace.home if study.motion_space.clearances else None


def _place(out: Path, to: str) -> tuple[Path, str]:
    """Folder and program name; no name if `out` is a folder."""
    from elastocal.programs.writers import ENDINGS, WRITERS

    if to not in WRITERS:
        hint = "; that is for calibrated robots" if to in re.findall(r"\w+", ROBOT_FILES) else ""
        raise InputError(f"no export to {to!r}; there are {', '.join(WRITERS)}{hint}")
    if out.is_dir():
        return out, ""
    if out.suffix.lower() != ENDINGS[to]:
        missing = " (there is no such folder)" if not out.suffix and not out.exists() else ""
        raise InputError(f"{out}: expected a folder{missing}, or a name that ends in {ENDINGS[to]}")
    return out.parent, out.stem
