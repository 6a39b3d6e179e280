"""What `identify` and `validate` do with studies of absolute readings.

Imported by the commands when they run.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from elastocal.calibration.calibrate import Calibration, calibrate
from elastocal.calibration.calibrated_robot import put_away
from elastocal.calibration.doubts import doubts
from elastocal.calibration.nested import Ladder, ladder
from elastocal.calibration.stations import station_motions, steadied
from elastocal.calibration.validate import check, check_set_up
from elastocal.cli.common import print_json, replaceable
from elastocal.errors import InputError
from elastocal.files.doubt_entries import doubt_entries
from elastocal.files.measurements.positions_file import read_positions
from elastocal.files.models.calibration_file import read_calibration
from elastocal.files.models.calibration_writing import calibration_document, write_calibration
from elastocal.files.study.absolute_file import read_absolute_study
from elastocal.files.texts import text_hash
from elastocal.fitting.robust import LOSSES
from elastocal.measuring.positions import Positions
from elastocal.study.absolute import AbsoluteStudy, arm_model, growing, unknowns_of
from elastocal.wording import ended, worded


def calibrate_command(
    study_file: Path,
    measurements: list[Path],
    mapping: Path | None,
    out: Path,
    loss: str,
    refused: Mapping[str, object],
    *,
    plan: Path | None = None,
    force: bool,
    as_json: bool,
) -> None:
    """Calibrate the robot of a study; write model.json."""
    for option, value in refused.items():
        if value is not None:
            raise InputError(f"{option} does not go with absolute readings")
    replaceable(out, "calibration", force=force)
    study = read_absolute_study(study_file)
    positions = _read(study, measurements, mapping, plan, quiet=as_json)
    found, grown = _fitted(study, positions, loss)
    robot = put_away(found, str(study_file), text_hash(study.text))
    write_calibration(robot, out)
    if as_json:
        odd = doubts(found, grown)
        print_json(
            calibration_document(robot)
            | {
                "models": _models(grown),
                "proposed": grown.rungs[grown.proposed].name,
                "remarks": [*positions.remarks, *map(worded, (*positions.doubts, *odd))],
                "doubts": doubt_entries((*positions.doubts, *odd)),
            }
        )
        return
    from elastocal.terminal.calibrations import show_calibration

    show_calibration(found, grown)
    print(f"wrote {out}")


def _fitted(study: AbsoluteStudy, positions: Positions, loss: str) -> tuple[Calibration, Ladder]:
    """The calibration of what a study seeks, and the models that grow to it."""
    model, weigher = arm_model(study), LOSSES[loss]
    found = calibrate(model, positions, unknowns_of(study, model, positions), loss=weigher)
    return found, ladder(growing(study, positions), positions, weigher, found)


def _models(grown: Ladder) -> list[dict[str, Any]]:
    """The models that grow, for programs."""
    return [
        {
            "name": rung.name,
            "unknowns": rung.unknowns,
            "told": None if rung.calibration is None else rung.calibration.redundancy.told,
            "fit_mm": 1e3 * rung.error,
            "left_out_mm": 1e3 * rung.left_out,
        }
        for rung in grown.rungs
    ]


def check_command(
    study_file: Path,
    model: Path,
    measurements: list[Path],
    mapping: Path | None,
    rows: int | None,
    *,
    plan: Path | None = None,
    as_json: bool,
) -> None:
    """Compare a calibrated robot with readings that it was not made from."""
    study = read_absolute_study(study_file)
    robot = read_calibration(model, study.robot)
    positions = _read(study, measurements, mapping, plan, quiet=as_json)
    if robot.origin.measurements_sha256 == positions.sha256 and positions.sha256:
        raise InputError(
            f"{model}: was made from these readings; give readings that were kept aside (what "
            "poses left out in turn say is shown by identify)"
        )
    found = check(robot, positions) if rows is None else check_set_up(robot, positions, rows)
    if as_json:
        print_json(
            {
                "elastocal": 1,
                "kind": "check",
                "poses": len(found.positions.cases),
                "error_mm": 1e3 * found.rms,
                "expected_mm": 1e3 * found.expected,
                "largest_mm": 1e3 * found.largest,
                "set_up": list(found.set_up),
                "remarks": [*positions.remarks, *map(worded, positions.doubts)],
            }
        )
        return
    from elastocal.terminal.calibrations import show_check

    show_check(found)


def _read(
    study: AbsoluteStudy,
    measurements: list[Path],
    mapping: Path | None,
    plan: Path | None,
    *,
    quiet: bool,
) -> Positions:
    """The readings as if trackers stood still, with what is odd in them said."""
    found = read_positions(measurements, study, mapping, plan)
    found = steadied(found, station_motions(found))
    if not quiet:
        for remark in found.remarks:
            print(f"note: {ended(remark)}", file=sys.stderr)
        for doubt in found.doubts:
            print(f"note: {ended(worded(doubt))}", file=sys.stderr)
    return found


def report_command(
    model: Path,
    study_file: Path | None,
    measurements: list[Path],
    mapping: Path | None,
    validation: list[Path],
    out: Path,
) -> None:
    """Write a page about a calibration, which is fitted again.

    Raises:
        InputError: study or readings are missing, or are not those of the calibration.
    """
    from elastocal.report import calibration_html
    from elastocal.report.sections.calibration import CalibrationContents
    from elastocal.writing import write_text

    if study_file is None or not measurements:
        raise InputError(
            f"{model}: a report of a calibration needs its --study and its --measurements"
        )
    study = read_absolute_study(study_file)
    robot = read_calibration(model, study.robot)
    positions = read_positions(measurements, study, mapping)
    motions = station_motions(positions)
    positions = steadied(positions, motions)
    if robot.origin.measurements_sha256 not in ("", positions.sha256):
        raise InputError(f"{model}: was not made from these measurements")
    found, grown = _fitted(study, positions, robot.loss)
    checked = None
    if validation:
        checked = check(robot, _read(study, validation, mapping, None, quiet=True))
    contents = CalibrationContents(study.name, found, grown, checked, motions)
    write_text(out, calibration_html(contents))
    print(f"wrote {out}")


def describe_command(study_file: Path, *, as_json: bool) -> None:
    """Say what a study of absolute readings means that says nothing of a plan."""
    from elastocal.terminal.calibrations import show_absolute_study

    study = read_absolute_study(study_file)
    model = arm_model(study)
    if as_json:
        print_json(
            {
                "elastocal": 1,
                "kind": "absolute study",
                "robot": study.robot.name,
                "joints": list(study.robot.joint_names),
                "blocks": list(study.blocks),
                "geometry": list(model.errors.names),
                "compliances": list(model.compliances.names),
                "reflectors": list(study.tool.marker_names),
                "payloads": [payload.name for payload in study.payloads],
                "mass_kg": sum(body.mass for body in study.robot.masses),
                "remarks": list(study.robot.remarks),
            }
        )
        return
    show_absolute_study(study, model)
