"""`init` and `check`: a study to start from, and what it means."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from elastocal.cli.common import (
    Json,
    Overwrite,
    Planned,
    StudyPath,
    app,
    demo_file,
    print_json,
    replaceable,
    writable,
)
from elastocal.errors import InputError

if TYPE_CHECKING:
    from elastocal.measuring.measurements import Measurements
    from elastocal.measuring.placement import Placement
    from elastocal.measuring.positions import Positions
    from elastocal.planning.study_check import Checkup
    from elastocal.robot.chain import Robot
    from elastocal.study.study import Study


@app.command("init")
def init_command(
    path: Annotated[Path, typer.Argument(help="File to write.")] = Path("study.yaml"),
    force: Overwrite = False,
) -> None:
    """Write a commented study file to start from."""
    from elastocal.files.texts import read_text
    from elastocal.writing import write_text

    text = _with_nuisance(read_text(demo_file("study.yaml")))
    writable(path)
    replaceable(path, "study", force=force, text=text)
    write_text(path, text)
    print(f"wrote {path}: edit it, then run 'elastocal check {path}'")


def _with_nuisance(text: str) -> str:
    """The study of the paper, which knows none, with what every arm has besides."""
    place = "\nconstraints:"
    assert text.count(place) == 1
    return text.replace(place, f"\n{_NUISANCE}{place}")


_NUISANCE = """\
nuisance: typical                     # foot, bearings, links, bracket, friction, errors of loads:
                                      # usual sizes, scaled with the joints; none leaves them out
"""


@app.command("check")
def check_command(
    study_file: StudyPath,
    picture: Annotated[
        Path | None, typer.Option(help="Draw the robot to this file (.svg or .html).")
    ] = None,
    measurements: Annotated[
        list[Path] | None, typer.Option(help="Say what was understood of these readings instead.")
    ] = None,
    mapping: Annotated[
        Path | None, typer.Option(help="What their columns mean (YAML).", show_default=False)
    ] = None,
    plan: Planned = None,
    force: Overwrite = False,
    as_json: Json = False,
) -> None:
    """Say what a study means: robot, reach, units, loads, what is identifiable."""
    if mapping is not None and not measurements:
        raise InputError("--mapping needs --measurements")
    if plan is not None and not measurements:
        raise InputError("--plan needs --measurements")
    if measurements:
        _check_measurements(study_file, measurements, mapping, plan, as_json)
        return
    from elastocal.files.study.absolute_file import is_absolute, says_what_to_plan

    if is_absolute(study_file) and not says_what_to_plan(study_file):
        from elastocal.cli.absolute import describe_command

        if picture is not None:
            raise InputError("to draw the cell, the study must say 'count' and 'test_poses'")
        describe_command(study_file, as_json=as_json)
        return
    from elastocal.cli.inputs import sources_of
    from elastocal.files.doubt_entries import doubt_entries
    from elastocal.files.plans.blind_section import blind_entry
    from elastocal.files.study.nuisance_entries import nuisance_entries
    from elastocal.files.study.study_file import read_study
    from elastocal.planning.study_check import check
    from elastocal.robot.controller_axes import shown_values
    from elastocal.wording import worded

    if picture is not None:
        writable(picture, study_file)
        if picture.suffix.lower() not in (".svg", ".html"):
            raise InputError(f"{picture}: expected a name that ends in .svg or .html")
    study = read_study(study_file)
    if picture is not None:
        writable(picture, *sources_of(study, study_file))
        replaceable(picture, "picture", force=force)
        _draw(study, picture)
    checkup = check(study)
    if as_json:
        print_json(
            {
                "reach_mm": 1e3 * checkup.reach,
                "feasible_share": checkup.feasible_share,
                "seen_share": dict(checkup.seen),
                "bottleneck": checkup.bottleneck,
                "bottleneck_within": checkup.within,
                "bottleneck_within_share": checkup.within_share,
                "controller_shows": shown_values(study.robot, study.coupling),
                "remarks": [*study.robot.remarks, *map(worded, checkup.doubts)],
                "doubts": doubt_entries(checkup.doubts),
                "never_seen": [blind_entry(e) for e in checkup.never_seen.effects],
                "check_poses": _pose_deviations(study, checkup),
                "watched": list(checkup.watch.watched),
                "not_watched": list(checkup.watch.unwatched),
                "watched_as": [worded(made_do) for made_do in checkup.watch.made_do],
                "unwatched_contacts": [worded(contacts) for contacts in checkup.unwatched],
                "nuisance": nuisance_entries(study.robot, study.nuisance),
                "problem": None if checkup.problem is None else str(checkup.problem),
            }
        )
    else:
        from elastocal.terminal.studies import show_check

        show_check(study, checkup)
    if picture is not None and not as_json:
        print(f"wrote {picture}")
    if checkup.problem is not None:
        raise checkup.problem


def _check_measurements(
    study_file: Path, paths: list[Path], mapping: Path | None, plan: Path | None, as_json: bool
) -> None:
    """Say what was understood of measurement files, and then whether it cannot be."""
    from elastocal.files.measurements.measurement_file import read_measurements
    from elastocal.files.study.absolute_file import is_absolute, read_absolute_study
    from elastocal.files.study.study_file import read_study
    from elastocal.identification.impossible import refuse_impossible_readings

    if is_absolute(study_file):
        from elastocal.files.measurements.positions_file import read_positions

        known = read_absolute_study(study_file)
        _show_positions(read_positions(paths, known, mapping, plan), known.robot, as_json)
        return
    study = read_study(study_file)
    data = read_measurements(paths, study, mapping, plan)
    _show_measurements(data, study, as_json)
    refuse_impossible_readings(data, study.robot)


def _show_measurements(data: Measurements, study: Study, as_json: bool) -> None:
    """What was understood of measurements, on the screen or for programs."""
    if as_json:
        import numpy as np

        from elastocal.files.doubt_entries import doubt_entries
        from elastocal.wording import worded

        size = np.linalg.norm(data.deflection, axis=1)
        turned = {"largest_rotation_mrad": 1e3 * float(size[data.rotations].max(initial=0.0))}
        print_json(
            {
                "experiments": len(data.cases),
                "readings": len(data),
                "own_uncertainty": data.own_uncertainty,
                "largest_deflection_mm": 1e3 * float(size[~data.rotations].max(initial=0.0)),
                **(turned if data.tool.rotation else {}),
                "unloaded_markers": None if data.placement is None else _beside_arm(data.placement),
                "sha256": data.sha256,
                "remarks": [*data.remarks, *map(worded, data.doubts)],
                "doubts": doubt_entries(data.doubts),
            }
        )
        return
    from elastocal.terminal.measurements import show_measurements

    show_measurements(data, study.robot)


def _show_positions(data: Positions, robot: Robot, as_json: bool) -> None:
    """What was understood of absolute readings, on the screen or for programs."""
    if not as_json:
        from elastocal.terminal.measurements import show_positions

        show_positions(data, robot)
        return
    from elastocal.files.doubt_entries import doubt_entries
    from elastocal.wording import worded

    print_json(
        {
            "poses": len(data.cases),
            "readings": len(data),
            "orientations": int(data.rotations.sum()),
            "stations": list(data.stations),
            "mountings": list(data.mountings),
            "foot_readings": 0 if data.foot is None else len(data.foot),
            "own_uncertainty": data.own_uncertainty,
            "from_drawing_mm": None if data.apart != data.apart else 1e3 * data.apart,
            "sha256": data.sha256,
            "remarks": [*data.remarks, *map(worded, data.doubts)],
            "doubts": doubt_entries(data.doubts),
        }
    )


def _beside_arm(found: Placement) -> dict[str, float | int | bool]:
    """How far unloaded markers are from where joints and tool put them."""
    import numpy as np

    return {
        "rms_mm": 1e3 * found.rms,
        "without_fit_mm": 1e3 * found.apart,
        "turned_by_deg": float(np.degrees(found.turn)),
        "turn_error_deg": float(np.degrees(found.turn_error)),
        "readings": found.count,
        "by_best_fit": found.chosen,
    }


def _draw(study: Study, path: Path) -> None:
    """Write the picture of the robot, alone or as a page."""
    from elastocal.drawing.check_picture import check_page, check_picture
    from elastocal.writing import write_text

    drawn = check_page if path.suffix.lower() == ".html" else check_picture
    write_text(path, drawn(study))


def _pose_deviations(study: Study, checkup: Checkup) -> dict[str, float]:
    """How far the model is off in each check pose [mm], by its name."""
    import numpy as np

    if checkup.poses is None:
        return {}
    sizes = 1e3 * np.linalg.norm(checkup.poses.deviations, axis=1)
    return {p.name: float(size) for p, size in zip(study.known_poses, sizes, strict=True)}
