"""What `export` and `compensate` do with calibrated robots.

Imported by the commands when they run.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from elastocal.arrays import Array
from elastocal.calibration.calibrated_robot import CalibratedRobot
from elastocal.calibration.for_controller import for_controller
from elastocal.calibration.placed import TCP, carried_point
from elastocal.cli.common import print_json, replaceable, writable
from elastocal.cli.corrected import path_program_of, refuse_undrivable
from elastocal.cli.inputs import joint_values, load, sources_of
from elastocal.cli.programs import converted
from elastocal.compensation.calibrated import compensate_calibrated
from elastocal.errors import InputError
from elastocal.files.models.calibration_file import read_calibration
from elastocal.files.paths.corrected_file import corrected_document, write_corrected
from elastocal.files.paths.path_file import read_path
from elastocal.files.robots.controller_table import KIND as TABLE
from elastocal.files.robots.controller_table import controller_table
from elastocal.files.robots.dh_file import KIND as DH
from elastocal.files.robots.dh_file import dh_text, far_words
from elastocal.files.robots.robot_document import KIND as DOCUMENT
from elastocal.files.robots.robot_document import robot_document
from elastocal.files.robots.urdf_file import KIND as URDF
from elastocal.files.robots.urdf_file import calibrated_urdf
from elastocal.files.study.absolute_file import is_absolute, read_absolute_study
from elastocal.files.study.study_file import read_study
from elastocal.files.texts import file_hash, json_text, text_hash
from elastocal.programs.writers import Settings
from elastocal.robot.sinks.dh import dh_table, refuse_unlike
from elastocal.study.absolute import AbsoluteStudy
from elastocal.study.study import Study
from elastocal.writing import write_text

KINDS = {
    "urdf": (".urdf", URDF),
    "dh": (".csv", DH),
    "mdh": (".csv", DH),
    "json": (".json", DOCUMENT),
    "table": (".csv", TABLE),
}
"""By word: how the file ends, and what we write it as."""


@dataclass(frozen=True)
class Task:
    """A path to correct, as the command line says it.

    Attributes:
        path: The file.
        force: Force of every point [N]; None if the file says, or nothing acts.
        torque: Torque of every point [N·m], likewise.
        start: Where to start, for paths of poses.
        station: Name of the station in whose frame the task is.
        tracker: Whether poses are given in that frame.
        mounting: Name of the mounting.
        payload: Name of what hangs on the flange, or none.
        point: The TCP, or a reflector.
    """

    path: Path
    force: tuple[float, float, float] | None
    torque: tuple[float, float, float] | None
    start: str | None
    station: str | None
    tracker: bool
    mounting: str | None
    payload: str | None
    point: str | None


@dataclass(frozen=True)
class _Made:
    """A text, and what to tell of it."""

    text: str
    told: tuple[str, ...]
    inputs: tuple[Path, ...] = ()


def export_calibrated(
    model: Path,
    to: str,
    out: Path,
    study_file: Path | None,
    refused: dict[str, bool],
    *,
    force: bool,
    as_json: bool,
) -> None:
    """Write a calibrated robot for another program.

    Raises:
        InputError: another format, options of robot programs, no study, a file that must stay.
    """
    if to not in KINDS:
        raise InputError(
            f"{model}: a calibrated robot is exported to {', '.join(KINDS)}; found {to!r}"
        )
    if given := [option for option, there in refused.items() if there]:
        raise InputError(f"{given[0]} is for robot programs, not for calibrated robots")
    study, calibrated, study_path = calibrated_with(model, study_file)
    path = _place(out, to, model)
    writable(path, model, study_path, *sources_of(study, study_path))
    replaceable(path, KINDS[to][1], force=force)
    about = [
        f"{calibrated.model.robot.name}, calibrated: {model.name} {file_hash(model)[:16]} of "
        f"{calibrated.source or 'unknown readings'}"
    ]
    if to == "urdf":
        made = _urdf(calibrated, study.text, study_path, path)
    elif to == "json":
        made = _Made(json_text(robot_document(calibrated)), ())
    elif to == "table":
        made = _Made(controller_table(for_controller(calibrated, study.coupling), about), ())
    else:
        made = _dh(calibrated, about, modified=to == "mdh")
    writable(path, *made.inputs)
    write_text(path, made.text)
    if as_json:
        print_json({"robot": calibrated.model.robot.name, "files": [str(path)]})
        return
    if to == "table":
        print("".join(line for line in made.text.splitlines(keepends=True) if line[0] == "#"))
    for line in made.told:
        print(line)
    print(f"wrote {path}")


def calibrated_with(
    model: Path, study_file: Path | None
) -> tuple[Study | AbsoluteStudy, CalibratedRobot, Path]:
    """A calibrated robot and the study that has its drawing; notes what is another study."""
    if study_file is None:
        raise InputError(
            f"{model}: a calibration counts from the robot as drawn; name its study with --study"
        )
    absolute = is_absolute(study_file)
    study = read_absolute_study(study_file) if absolute else read_study(study_file)
    calibrated = read_calibration(model, study.robot)
    was = calibrated.origin.study_sha256
    if was and was != text_hash(study.text):
        print(
            f"note: {study_file.name} is another study than {model.name} was made with; its robot "
            "is the same",
            file=sys.stderr,
        )
    return study, calibrated, study_file


def _place(out: Path, to: str, model: Path) -> Path:
    """The file to write."""
    ending = KINDS[to][0]
    if out.is_dir():
        word = "" if to == "urdf" else f".{'robot' if to == 'json' else to}"
        return out / f"{model.stem}{word}{ending}"
    if out.suffix.lower() != ending:
        missing = " (there is no such folder)" if not out.suffix and not out.exists() else ""
        raise InputError(f"{out}: expected a folder{missing}, or a name that ends in {ending}")
    return out


def _urdf(calibrated: CalibratedRobot, text: str, study_file: Path, path: Path) -> _Made:
    found = calibrated_urdf(calibrated, text, study_file)
    told = [f"The flange is link {found.tip!r}."]
    if found.source is None:
        told.append(
            "Inertia, effort and velocity are not known and stand as 0; shapes are left out."
        )
        return _Made(found.text, tuple(told))
    if found.changed:
        told.insert(0, f"Origins changed: {', '.join(found.changed)}.")
    elsewhere = path.parent.resolve() != found.source.parent.resolve()
    if elsewhere and "<mesh" in found.text and "package://" not in found.text:
        told.append(f"Its meshes are named from the folder of {found.source}: put it there.")
    return _Made(found.text, tuple(told), (found.source,))


def _dh(calibrated: CalibratedRobot, about: list[str], *, modified: bool) -> _Made:
    drawn = calibrated.model.robot
    table = dh_table(calibrated.robot, modified=modified, like=drawn)
    refuse_unlike(table, calibrated.robot)
    text = dh_text(table, dh_table(drawn, modified=modified), about)
    told = [f"Note: {line}." for line in far_words(table)]
    if _turned(table.T_base_first) or _turned(table.T_last_flange):
        told.append("Base and flange stand beside the rows: see its head.")
    return _Made(text, tuple(told))


def _turned(T: Array) -> bool:
    return bool(np.abs(T - np.eye(4)).max() > 1e-12)


def compensate_by_calibration(
    study_file: Path,
    model: Path,
    task: Task,
    out: Path,
    to: str | None,
    refused: Mapping[str, object],
    *,
    script_node: bool,
    force: bool,
    as_json: bool,
) -> None:
    """Correct a path for all that a calibration found.

    Raises:
        InputError: an option that does not go with it, a wrong name, a file that must stay.
        InfeasibleError: points that cannot be corrected.
    """
    if given := [option for option, value in refused.items() if value]:
        raise InputError(f"{given[0]} does not go with a calibrated robot, which has its own")
    inputs = [study_file, model, task.path]
    writable(out, *inputs, suffix=".csv")
    study, calibrated, _ = calibrated_with(model, study_file)
    inputs += sources_of(study, study_file)
    writable(out, *inputs)
    replaceable(out, "corrected path", force=force)
    station, mounting = calibrated.station(task.station), calibrated.mounting(task.mounting)
    carried = carried_point(calibrated, mounting, task.point or TCP)
    robot = calibrated.model.robot
    wanted = read_path(
        task.path,
        robot,
        replace(calibrated.model.tool, tcp=carried.meant),
        _start(study, task.start),
        load(task.force, task.torque),
        frame=np.linalg.inv(calibrated.state.base[station]) if task.tracker else None,
        idle=True,
    )
    done = compensate_calibrated(
        calibrated,
        wanted.cases,
        station=station,
        mounting=mounting,
        payload=_payload(calibrated, study, task.payload),
        point=carried.name,
    )
    if as_json:
        print_json(corrected_document(done, wanted))
    else:
        from elastocal.terminal.compensations import show_compensation

        show_compensation(done, wanted, None)
    refuse_undrivable(done, wanted)
    settings = Settings(coupling=converted(study), script_node=script_node)
    told = []
    if to:  # first, for it can be refused
        told = path_program_of(study, done, wanted, to, settings, out, inputs, [model], force=force)
    write_corrected(done, wanted, out)
    if not as_json:
        print("\n".join([*told, f"wrote {out}"]))


def _start(study: Study | AbsoluteStudy, text: str | None) -> Array:
    """Configuration near the first pose: as named, or the middle of the joint ranges."""
    robot = study.robot
    if text is not None:
        return joint_values(text, robot, "start")
    lower = np.where(np.isfinite(robot.lower), robot.lower, 0.0)
    upper = np.where(np.isfinite(robot.upper), robot.upper, 0.0)
    return np.asarray(0.5 * (lower + upper))


def _payload(calibrated: CalibratedRobot, study: Study | AbsoluteStudy, name: str | None) -> int:
    """Number of what hangs on the flange: as named, else what the study says, else nothing."""
    names = [payload.name for payload in calibrated.model.payloads]
    usual = study.payload if isinstance(study, AbsoluteStudy) else ""
    wanted = usual if name is None else name
    if wanted in ("", "none"):
        return -1
    if wanted not in names:
        raise InputError(f"no payload {wanted!r}; there are {', '.join([*names, 'none'])}")
    return names.index(wanted)
