"""`export`: the plan as a program for the robot's controller."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import Json, app, guarded, print_json, study_of_plan, writable
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.arrays import Array
    from elastocal.programs.robot_program import RobotProgram
    from elastocal.programs.writers import Settings
    from elastocal.robot.chain import Robot
    from elastocal.study.study import Study


@app.command()
@guarded
def export(
    plan_file: Annotated[Path, typer.Argument(metavar="PLAN", help="Plan (JSON or CSV).")],
    to: Annotated[str, typer.Option(help="krl, rapid, fanuc, urscript, ros or csv.")],
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder, or a file whose name is the program's.")
    ] = Path("."),
    study: Annotated[
        Path | None, typer.Option(help="Study, if not the one embedded in the plan.")
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
    as_json: Json = False,
) -> None:
    """Write the plan as a robot program; refuse a plan that breaks a constraint."""
    import numpy as np

    from elastocal.files.plans.proposal_file import read_proposal
    from elastocal.programs.campaign_program import campaign_program
    from elastocal.programs.writers import Settings

    what = study_of_plan(plan_file, study)
    proposal = read_proposal(plan_file, what)
    folder, name = _place(out, to)
    program = campaign_program(
        what,
        proposal.load_cases,
        proposal.repeats,
        name=name or what.name,
        home=_home(what, home),
        prebias=float(np.radians(prebias_deg)),
        prebias_sliding=prebias_mm / 1e3,
        settle=settle_s,
        speed=speed_percent / 100.0,
        digest=_digest(plan_file),
        via=proposal.via,
    )
    settings = Settings(
        coupling=what.controller,
        external=None if external is None else tuple(external.replace(",", " ").split()),
        trigger=trigger,
    )
    files = write_program(program, to, settings, folder, name, plan_file, study)
    if as_json:
        print_json({"program": program.name, "files": [str(path) for path in files]})
        return
    from elastocal.terminal.programs import show_program

    show_program(program, to, coupled=settings.coupling is not None)
    print("wrote " + " and ".join(str(path) for path in files))


def _home(study: Study, text: str | None) -> Array | None:
    """Home as given; that of the study where motions are watched; else none."""
    if text is not None:
        return study.coupling.to_model(home_values(text, study.robot)[None])[0]
    return study.pace.home if study.motion_space.clearances else None


def write_program(
    program: RobotProgram,
    to: str,
    settings: Settings,
    folder: Path,
    name: str,
    *inputs: Path | None,
) -> list[Path]:
    """Write a program for a controller; refuse a file name that the controller does not take."""
    from elastocal.files.texts import write_text
    from elastocal.programs.writers import export as texts

    files = {folder / file: text for file, text in texts(program, to, settings).items()}
    made = next(iter(files)).stem
    if name and made != name:
        raise InputError(f"{folder / name}: not a program name for {to}, {made!r} would be one")
    given = [path for path in inputs if path is not None]
    for path in files:
        writable(path, *given)
    for path, text in files.items():
        write_text(path, text)
    return list(files)


def _place(out: Path, to: str) -> tuple[Path, str]:
    """Folder and program name; no name if `out` is a folder."""
    from elastocal.programs.writers import ENDINGS, WRITERS

    if to not in WRITERS:
        raise InputError(f"no export to {to!r}; there are {', '.join(WRITERS)}")
    if out.is_dir():
        return out, ""
    if out.suffix.lower() != ENDINGS[to]:
        missing = " (there is no such folder)" if not out.suffix and not out.exists() else ""
        raise InputError(f"{out}: expected a folder{missing}, or a name that ends in {ENDINGS[to]}")
    return out.parent, out.stem


def home_values(text: str, robot: Robot, what: str = "home") -> Array:
    """(n,) joint values of "A1=0deg A2=-90deg rail=500mm", every joint once [rad or m]."""
    from elastocal.arrays import frozen

    values: dict[str, float] = {}
    for part in text.replace(",", " ").split():
        found = re.fullmatch(r"([^=]+)=([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)(deg|mm)", part)
        if not found:
            raise InputError(f"{what}: expected name=value with deg or mm, found {part!r}")
        name, number, unit = found.groups()
        joint = robot.joints[robot.index([name])[0]]
        if unit != joint.kind.key:
            raise InputError(
                f"{what}: joint {name!r} is given in {unit}, expected {joint.kind.key}"
            )
        if name in values:
            raise InputError(f"{what}: joint {name!r} is given twice")
        try:
            value = float(number)
        except ValueError:
            raise InputError(f"{what}: expected a number, found {number!r}") from None
        values[name] = joint.kind.si * value
    missing = [name for name in robot.joint_names if name not in values]
    if missing:
        raise InputError(f"{what}: joint {missing[0]!r} is missing")
    return frozen([values[name] for name in robot.joint_names])


def _digest(path: Path) -> str:
    """SHA-256 of a file."""
    import hashlib

    return hashlib.sha256(path.read_bytes()).hexdigest()
