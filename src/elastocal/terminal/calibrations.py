"""Calibrations from absolute readings as tables: models that grow, unknowns, what is not told."""

from __future__ import annotations

import numpy as np
from rich import box
from rich.table import Table
from rich.text import Text

from elastocal.arrays import Array
from elastocal.calibration.arm_model import ArmModel
from elastocal.calibration.calibrate import Calibration, values_of
from elastocal.calibration.doubts import doubts
from elastocal.calibration.nested import Ladder
from elastocal.calibration.parameters import BASE, PAYLOAD, PROBE, TOOL
from elastocal.calibration.redundancy import together
from elastocal.calibration.validate import Check
from elastocal.study.absolute import AbsoluteStudy
from elastocal.terminal.console import micrometres, out, whole
from elastocal.wording import ended, worded
from elastocal.wording.calibration import combination
from elastocal.wording.lists import counted
from elastocal.wording.numbers import length, number

_BAR = 24  # characters of a drawn error


def show_calibration(found: Calibration, grown: Ladder) -> None:
    """What was found, model by model and unknown by unknown."""
    _show_ladder(found, grown)
    _show_unknowns(found)
    _show_redundancy(found)
    odd = doubts(found, grown)
    for doubt in odd:
        out.print(Text(f"Note: {ended(worded(doubt))}", style="yellow"))


def _show_ladder(found: Calibration, grown: Ladder) -> None:
    """Errors by model."""
    p = found.positions
    title = (
        f"{counted(len(p), 'reading')} of {counted(len(p.cases), 'pose')}: how far positions are "
        "from the model (RMS)"
    )
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("model", "unknowns", "told", "fit mm", "poses left out mm"):
        left = column == "model"
        table.add_column(column, justify="left" if left else "right", no_wrap=True)
    table.add_column("", no_wrap=True)
    widest = max(rung.left_out for rung in grown.rungs if np.isfinite(rung.left_out))
    for i, rung in enumerate(grown.rungs):
        if rung.calibration is None:
            table.add_row(Text(rung.name), "", "", "–", "does not come to rest", "")
            continue
        bar = "─" * max(1, round(_BAR * rung.left_out / widest))
        mark = "  proposed" if i == grown.proposed else ""
        table.add_row(
            Text(("+ " if i else "") + rung.name),
            str(rung.unknowns),
            str(rung.calibration.redundancy.told),
            f"{1e3 * rung.error:.4f}",
            f"{1e3 * rung.left_out:.4f}",
            Text(bar + mark),
        )
    whole(table)


def _show_unknowns(found: Calibration) -> None:
    """Values with intervals; what the readings do not tell by itself has none."""
    p, error = found.parameters, found.standard_error
    width, values = found.width, values_of(found)
    table = Table(title="Unknowns", title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("unknown", "value", "± error", "95 % interval", "unit"):
        left = column in ("unknown", "unit")
        table.add_column(column, justify="left" if left else "right", no_wrap=True)
    shown = [u for u in range(len(p)) if p.block[u] not in (BASE, PROBE) and not p.held[u]]
    for u in shown:
        factor, unit = p.shown(u)
        value = factor * values[u]
        if not found.redundancy.seen[u]:
            table.add_row(Text(p.names[u]), f"{value:.4f}", "", "not told by itself", unit)
            continue
        half = width * factor * error[u]
        table.add_row(
            Text(p.names[u]),
            f"{value:.4f}",
            number(factor * float(error[u]), 2),
            f"{value - half:.4f} … {value + half:.4f}",
            unit,
        )
    whole(table)


def _show_redundancy(found: Calibration) -> None:
    """What the readings tell, and scatter."""
    p, told = found.parameters, found.redundancy
    free = len(p) - int(p.held.sum())
    out.print(
        Text(
            f"{told.told} of {free} combinations of the unknowns move readings, and {told.well} "
            "are known better from them than before; the rest keeps its prior"
            f"{_ending(told.open, p.names)}"
        )
    )
    noise = found.noise
    for s, name in enumerate(found.positions.stations):
        station = f"Station {name}: the" if len(found.positions.stations) > 1 else "The"
        off = float(np.hypot(noise.own[s], noise.shared[s]))
        if off > 0.0:
            out.print(
                Text(
                    f"{station} model is off by {length(off)} in each coordinate beyond the noise "
                    "of the instrument; the intervals count it."
                )
            )


def _ending(open_: Array, names: tuple[str, ...]) -> str:
    """': A and B do the same; …', or a full stop."""
    if not len(open_):
        return "."
    return f": {'; '.join(map(combination, together(open_, names)))}."


def show_check(found: Check) -> None:
    """A calibrated robot on other readings."""
    p = found.positions
    how = (
        f"base and tool from {counted(len(found.set_up), 'pose')} of them"
        if found.set_up
        else "with the base and the tool of the calibration"
    )
    read = f"{counted(int(found.points.sum()), 'position')} of {counted(len(p.cases), 'pose')}"
    out.print(
        Text(
            f"{read} not used, {how}: {1e3 * found.rms:.4f} mm (RMS) from the model, "
            f"{1e3 * found.expected:.4f} mm expected; at most {micrometres(found.largest)}."
        )
    )


def show_absolute_study(study: AbsoluteStudy, model: ArmModel) -> None:
    """The robot, what is sought, and what is on the flange."""
    robot, scale = study.robot, study.robot.shown_scale
    table = Table(title=Text(f"Robot {robot.name}"), title_justify="left", box=box.SIMPLE_HEAD)
    for column in ("joint", "moves", "from", "to", "mass kg", "sought"):
        left = column in ("joint", "moves", "sought")
        table.add_column(column, justify="left" if left else "right")
    for i, joint in enumerate(robot.joints):
        mass = sum(b.mass for b in robot.masses if b.body == robot.place[i] + 1)
        errors = [n for n in model.errors.names if n.split(" ", 1)[1] == joint.name]
        sought = [name.split(" ", 1)[0] for name in errors]
        sought += ["compliance"] * (joint.name in study.springs.names)
        low, high = (scale[i] * value for value in (joint.lower, joint.upper))
        ends = [f"{v:.6g}{joint.kind.suffix}" if np.isfinite(v) else "–" for v in (low, high)]
        cells = f"{mass:.4g}" if mass else "–", ", ".join(sought)
        table.add_row(Text(joint.name), joint.kind.moves, *ends, *cells)
    whole(table)
    others = [block for block in study.blocks if block in (BASE, TOOL, PAYLOAD)]
    springs = [name for name in study.springs.names if name not in robot.joint_names]
    besides = ", ".join([*others, *springs])
    if besides:
        out.print(Text(f"Sought besides: {besides}"))
    markers = zip(study.tool.marker_names, study.tool.markers, strict=True)
    places = [f"{name} [{', '.join(f'{1e3 * v:.6g}' for v in at)}]" for name, at in markers]
    known = "thought to be at" if TOOL in study.blocks else "at"
    out.print(Text(f"Reflectors in the flange frame, {known}: {', '.join(places)} mm"))
    for payload in study.payloads:
        doubt = f" ± {payload.mass_error:.4g}" if payload.mass_error else ""
        center = ", ".join(f"{1e3 * v:.6g}" for v in payload.center)
        out.print(Text(f"Payload {payload.name}: {payload.mass:.6g}{doubt} kg at [{center}] mm"))
    gravity = ", ".join(f"{v:.5g}" for v in study.gravity)
    heavy = bool(robot.masses) or bool(study.payloads)
    bends = "" if heavy else "; no masses are known, so nothing bends the arm"
    out.print(Text(f"Gravity [{gravity}] m/s², base frame{bends}"))
    out.print(Text(f"σ = {1e3 * study.instrument.sigma:g} mm for a coordinate of a reading"))
    for remark in robot.remarks:
        out.print(Text(f"Note: {ended(remark)}", style="yellow"))
    out.print(
        Text(
            "Readings are compared with the arm by --measurements. To plan, 'count' in experiments "
            "and 'test_poses' are missing."
        )
    )
