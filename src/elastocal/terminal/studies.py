"""What a study means."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from elastocal.arrays import Array
from elastocal.elastic.allowed_loads import FixedVector, InPlane, Load, ThereOrNot
from elastocal.measuring.common_errors import CommonErrors
from elastocal.measuring.instrument import Instrument, tracker_of
from elastocal.planning.study_check import Checkup
from elastocal.robot.controller_axes import shown_values
from elastocal.study.known import Known
from elastocal.study.study import Study, TestPose
from elastocal.study.test_path import TestPath
from elastocal.terminal.console import numbers, out
from elastocal.terminal.nuisance import show_nuisance
from elastocal.wording import ended, worded
from elastocal.wording.blind import never_seen_sentence
from elastocal.wording.lists import counted, springs_in_short
from elastocal.wording.numbers import short
from elastocal.wording.plans import told
from elastocal.wording.watch import watch


def show_check(study: Study, found: Checkup) -> None:
    """What the study means."""
    robot, e = study.robot, study.experiments
    out.print(
        f"[bold]{escape(study.name)}[/bold]: robot {escape(robot.name)}, {len(robot.joints)} joints"
    )
    table = Table(title="Joints", title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("joint", "moves", "planned between", "compliance"):
        table.add_column(Text(column))
    for j, joint in enumerate(robot.joints):
        low, high = joint.kind.scale * study.limits[:, j]
        room = f"held at {low:.6g}" if study.held[j] else f"{low:.6g} … {high:.6g}"
        room += f" {joint.kind.shown_unit}"
        role = _role(study, joint.name)
        table.add_row(Text(joint.name), joint.kind.moves, room, role)
    out.print(table)
    if shows := shown_values(robot, study.coupling):
        rows = ", ".join(f"{name} as {value}" for name, value in shows.items())
        out.print(Text(f"The controller shows {rows}, in joint values of the model; others as is"))
    points = ", ".join(
        f"{name} {numbers(1e3 * point)} mm"
        for name, point in zip(e.tool.marker_names, e.tool.markers, strict=True)
    )
    measured = ", and the rotation of the flange" if e.tool.rotation else ""
    out.print(
        Text(
            f"Calibration tool {e.tool.name!r}: load at {numbers(1e3 * e.tool.load_point)} "
            f"mm of the flange, measured: {points}{measured}"
        )
    )
    out.print(Text(f"Load: {_load(e.force, 'N')}; torque: {_load(e.moment, 'N·m')}; base frame"))
    if study.known is not None:
        out.print(Text(known_phrase(study.known)))
    show_nuisance(robot, study.nuisance)
    for pose in study.test_poses:
        kind = "path" if isinstance(pose, TestPath) else "pose"
        weight = f"weight {pose.weight:g}" if pose.weight else "judged only"
        out.print(Text(f"Test {kind} {pose.name!r} ({weight}): {_pose(study, pose)}"))
    least = (
        f", at most {counted(e.max_configurations, 'configuration')}"
        if e.max_configurations
        else ""
    )
    out.print(
        f"{counted(e.count, 'experiment')}{least}; criterion {study.criterion}; "
        f"{instrument_phrase(study.instrument)}"
    )
    out.print(
        f"The load point reaches {found.reach:.3f} m from the base; "
        f"{100 * found.feasible_share:.3g} % of random configurations are feasible"
        + (f", most are refused by: {escape(found.bottleneck)}" if found.bottleneck else "")
        + (
            f", {short(100 * found.within_share)} % of these by: {escape(found.within)}"
            if found.within
            else ""
        )
    )
    _show_known_poses(study, found)
    for marker, share in found.seen.items():
        out.print(
            Text(f"The tracker sees {marker} in {100 * share:.3g} % of random configurations")
        )
    home = [f"{v + 0.0:.6g}" for v in robot.shown_scale * study.pace.home]
    out.print(Text(f"Home: q = {' '.join(home)}, where the campaign starts and ends"))
    out.print(Text(watch(found.watch.watched, found.watch.unwatched, keys=True)))
    for made_do in found.watch.made_do:
        out.print(Text(ended(worded(made_do)[:1].upper() + worded(made_do)[1:])))
    for contacts in found.unwatched:
        out.print(Text(f"Contact not watched, {ended(worded(contacts))}"))
    paths = [pose for pose in study.test_poses if isinstance(pose, TestPath)]
    remarks = [remark for path in paths for remark in path.remarks]
    for remark in (*robot.remarks, *remarks):
        out.print(Text(f"Note: {ended(remark)}", style="yellow"))
    for doubt in found.doubts:
        out.print(Text(told(doubt, ended(worded(doubt))), style="yellow"))
    never = found.never_seen
    if said := never_seen_sentence(never.effects, never.aslant, never.markers):
        out.print(Text(f"Note: {said}", style="yellow"))
    if found.problem is None:
        out.print(f"[green]Identifiable:[/green] {escape(', '.join(study.springs.names))}")


def known_phrase(known: Known) -> str:
    """What is known of further springs, and from where."""
    springs = known.model.springs
    names = ", ".join(springs_in_short(springs.names, springs.of_joints))
    if known.planned:
        return f"{names}: known as well as {known.source} promises; errors count in every number"
    exact = "" if known.uncertain.names else " exactly"
    source = known.source or "a model"
    said = f"{names}: known{exact} from {source}; errors count in every number"
    if known.left_out:
        said += (
            f"; what it tells of {', '.join(known.left_out)} is left out, for the study identifies "
            "that itself: as a `prior` it would count"
        )
    return said


def _role(study: Study, joint: str) -> str:
    """What the study does with the compliance of a joint."""
    if joint in study.springs.names:
        return "to identify"
    if study.known is not None and joint in study.known.model.names:
        return "will be known" if study.known.planned else "known"
    return "taken as rigid"


def instrument_phrase(instrument: Instrument) -> str:
    """How well is measured, in a few words."""
    rotation = instrument.sigma_rotation
    turned = "" if rotation is None else f"; rotation σ = {1e3 * rotation:g} mrad per axis"
    if isinstance(instrument, CommonErrors):
        sizes = (instrument.translation, "mm"), (instrument.rotation, "mrad")
        shared = " and ".join(f"{1e3 * size:g} {unit}" for size, unit in sizes if size)
        return f"{instrument_phrase(instrument.own)}; {shared} common to the readings of a pose"
    tracker = tracker_of(instrument)
    if tracker is None:
        return f"σ = {1e3 * instrument.sigma:g} mm per coordinate{turned}"
    along, across = tracker.deviations(np.array(tracker.typical_range))
    return (
        f"tracker at {numbers(1e3 * tracker.position)} mm; of one reading at "
        f"{tracker.typical_range:g} m σ = {1e6 * along:.3g} µm along and "
        f"{1e6 * across:.3g} µm across the beam{turned}"
    )


def _show_known_poses(study: Study, found: Checkup) -> None:
    """What the poses read off at the robot say of the model."""
    if found.poses is None:
        return
    table = Table(title="Check poses", title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("pose", "model minus robot [mm]", "distance [mm]"):
        table.add_column(Text(column))
    for pose, off in zip(study.known_poses, 1e3 * found.poses.deviations, strict=True):
        each = "  ".join(f"{v:+.2f}" for v in off)
        table.add_row(Text(pose.name), each, f"{np.linalg.norm(off):.2f}")
    out.print(table)
    if found.poses.fits:
        out.print("[green]The model fits the robot in the check poses[/green]")
    if found.poses.untold:
        out.print(
            Text(
                f"Note: the check poses do not tell the sign of {', '.join(found.poses.untold)}; "
                "a pose in which these joints move the position would.",
                style="yellow",
            )
        )


def _load(load: Load, unit: str) -> str:
    if isinstance(load, FixedVector):
        return f"fixed [{numbers(load.value)}] {unit}" if load.size else "none"
    if isinstance(load, ThereOrNot):
        return f"[{numbers(load.value)}] {unit}, or none"
    if isinstance(load, InPlane):
        normal = " ".join(f"{v:g}" for v in load.normal)
        return f"up to {load.largest:g} {unit} in the plane across [{normal}]"
    where = (
        f"within {np.degrees(load.half_angle):g}° of [{' '.join(f'{v:g}' for v in load.axis)}]"
        if load.is_cone
        else "in any direction"
    )
    return f"up to {load.largest:g} {unit} {where}"


def _pose(study: Study, pose: TestPose | TestPath) -> str:
    if pose.case is None or pose.tool is None:
        return "given as a matrix"
    scale = study.robot.shown_scale
    values = " ".join(f"{v:z.1f}" for v in scale * pose.case.q[0])
    if isinstance(pose, TestPath):
        force = np.linalg.norm(pose.cases.wrench[:, :3], axis=1)
        size = f"{force.max():.4g}" if np.ptp(force) < 1e-3 * force.max() else _range(force)
        return (
            f"{len(pose.cases)} points from q = {values}, force of {size} N at {pose.tool.name!r}"
        )
    return f"q = {values}, force {numbers(pose.case.wrench[0, :3])} N at {pose.tool.name!r}"


def _range(values: Array) -> str:
    return f"{values.min():.4g} to {values.max():.4g}"
