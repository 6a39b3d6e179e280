"""Readouts as HTML for the panel: small tables, states told by signs and not by colour alone.

In: values. Out: HTML; every text that comes from a file is escaped. Units are converted here.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from html import escape

import numpy as np

from elastocal.arrays import Array
from elastocal.constraints.watch import watch_of
from elastocal.drawing.palette import COLOURS
from elastocal.elastic.cartesian import CartesianCompliance
from elastocal.viewer.readout import Bending, Readout, Room
from elastocal.viewer.subject import Subject
from elastocal.wording.numbers import fixed, plain, vector, words
from elastocal.wording.stiffness import STIFFNESS, plus_minus
from elastocal.wording.watch import watch

_SIGNS = {"broken": "✕", "near": "!", "free": "✓"}
_SHADES = {"broken": COLOURS["alarm"], "near": COLOURS["contrast"], "free": "#2c7a4b"}
_BOX = "font-size:12.5px;line-height:1.45;padding:0.15em 0.75em 0.35em"
_MUTED = f"color:{COLOURS['muted']}"


def heading_html(subject: Subject, remarks: Sequence[str]) -> str:
    """What is shown, and what is missing from it."""
    study = subject.study
    lines = [f"<b>{escape(study.name)}</b>"]
    seen = watch_of(study.constraints)
    certificate = [subject.certificate] if subject.certificate else []
    about = (study.robot.name, watch(seen.watched, seen.unwatched), *certificate, *remarks)
    for text in about:
        lines.append(f"<span style='{_MUTED}'>{escape(text)}</span>")
    return f"<div style='{_BOX}'>{'<br>'.join(lines)}</div>"


def readout_html(readout: Readout, wrench: Array, magnification: float, moved: bool = False) -> str:
    """Load, worth, deflection, position and margins; `moved`: it is no longer at its pose."""
    rows = [_row("shown", "moved away from this pose", "shown")] if moved else []
    rows.append(_row("load", load_words(wrench), "load"))
    rows.append(_row(readout.place, f"{_vector(readout.position, 1)} mm", "position"))
    parts = [f"<table style='width:100%'>{''.join(rows)}</table>"]
    if readout.bending is not None:
        parts.append(_bending(readout.bending, magnification))
    if readout.cartesian is not None:
        parts.append(_stiffness(readout.cartesian))
    if readout.worth is not None:
        parts.append(_worth(readout.worth))
    parts.append(_rooms(readout.rooms))
    return f"<div style='{_BOX}' data-readout='all'>{''.join(parts)}</div>"


def load_words(wrench: Array) -> str:
    """A wrench (6,) [N, N·m] in words."""
    found = []
    for part, unit in ((wrench[:3], "N"), (wrench[3:], "N·m")):
        if np.any(part):
            numbers = ", ".join(fixed(float(v), 0 if abs(v) >= 100 else 1) for v in part)
            found.append(f"{plain(float(np.linalg.norm(part)))} {unit} [{numbers}]")
    return ", ".join(found) or "none"


def _vector(values: Array, decimals: int) -> str:
    """Three lengths [m] in mm."""
    return "[" + ", ".join(fixed(1e3 * float(v), decimals) for v in values) + "]"


def _row(name: str, value: str, key: str, style: str = "") -> str:
    return (
        f"<tr><td style='{_MUTED};white-space:nowrap;vertical-align:top'>{escape(words(name))}</td>"
        f"<td data-readout='{key}' style='text-align:right;{style}'>{escape(value)}</td></tr>"
    )


def _title(text: str) -> str:
    return f"<div style='margin-top:0.5em;font-weight:600'>{text}</div>"


def _bending(bending: Bending, magnification: float) -> str:
    """How far the watched points move."""
    scale = f"<span style='{_MUTED};font-weight:400'>shown {magnification:.3g}×</span>"
    title = _title(f"Deflection {scale}")
    if bending.problem:
        words_ = f"✕ {escape(bending.problem)}"
        style = f"color:{_SHADES['broken']}"
        return f"{title}<div data-readout='deflection' style='{style}'>{words_}</div>"
    rows = []
    for name, moved in zip(bending.points, bending.deflection, strict=True):
        size = f"{fixed(1e3 * float(np.linalg.norm(moved)), 3)} mm"
        rows.append(_row(name, f"{size} {_vector(moved, 3)}", "deflection"))
    return f"{title}<table style='width:100%'>{''.join(rows)}</table>"


def _stiffness(found: CartesianCompliance) -> str:
    """Stiffness at the TCP along the axes of the base, and where it is least."""
    scale = f"<span style='{_MUTED};font-weight:400'>{STIFFNESS[1]}, base axes</span>"
    softest = found.principal[0]
    lines = [*((f"along {line.name}", line) for line in found.axes), ("softest", softest)]
    rows = [_row(n, plus_minus(line.stiffness, STIFFNESS[0]), "stiffness") for n, line in lines]
    rows.append(_row("which is along", vector(softest.direction, 2), "softest"))
    if found.rigid:
        rows.append(_row("taken as rigid", ", ".join(found.rigid), "rigid"))
    title = _title(f"Stiffness at the TCP {scale}")
    return f"{title}<table style='width:100%'>{''.join(rows)}</table>"


def _worth(share: float) -> str:
    """Sensitivity as a bar."""
    shown = float(np.clip(share, 0.0, 1.0))
    bar = (
        f"<div style='background:{COLOURS['line']};height:6px;border-radius:3px;margin:2px 0'>"
        f"<div style='background:{COLOURS['accent']};height:6px;border-radius:3px;"
        f"width:{100.0 * shown:.1f}%'></div></div>"
    )
    row = _row("of one measurement more here", worth_words(share), "worth", "font-weight:600")
    return f"{_title('Worth')}<table style='width:100%'>{row}</table>{bar}"


def worth_words(share: float) -> str:
    """A sensitivity over its largest value, in words."""
    if share >= 0.995:
        return "as much as anywhere"
    return f"{fixed(100.0 * share, 0 if share >= 0.1 else 1)} % of the best place"


def _named(room: Room) -> str:
    """Name of a constraint, with room before its unit."""
    return escape(words(re.sub(r"(?<=\d)mm\b", " mm", room.name)))


def _rooms(rooms: Sequence[Room]) -> str:
    """Margins, the broken ones first; a long list scrolls, so that the sliders stay in sight."""
    broken = sum(room.state == "broken" for room in rooms)
    state = "all hold"
    if broken:
        state = f"<span style='color:{_SHADES['broken']}'>{broken} broken</span>"
    body = "".join(
        f"<tr data-state='{room.state}'><td style='color:{_SHADES[room.state]};width:1.2em;"
        f"vertical-align:top'>{_SIGNS[room.state]}</td><td>{_named(room)}</td>"
        f"<td data-readout='margin' style='text-align:right;white-space:nowrap;"
        f"color:{_SHADES[room.state]}'>{escape(room_words(room))}</td></tr>"
        for room in sorted(rooms, key=lambda room: room.state != "broken")
    )
    title = _title(f"Margins <span data-readout='margins' style='font-weight:400'>{state}</span>")
    scroll = "max-height:16em;overflow-y:auto"
    return f"{title}<div style='{scroll}'><table style='width:100%'>{body}</table></div>"


def room_words(room: Room) -> str:
    """A margin in degrees or millimetres."""
    if room.unit == "rad":
        return f"{fixed(float(np.degrees(room.margin)), 1)}°"
    if room.unit == "m":
        return f"{fixed(1e3 * room.margin, 0)} mm"
    return f"{room.margin:.4g} {room.unit}"
