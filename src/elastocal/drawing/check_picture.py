"""The robot of a study at home and in its test poses: axes, signs, names, tool points.

In: a study. Out: one SVG that stands alone. It is for holding beside the robot: does this joint
turn this way, is the tool where it should be?
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.joint_glyphs import Glyph, glyphs
from elastocal.drawing.labels import Labels
from elastocal.drawing.palette import COLOURS
from elastocal.drawing.policy import policy
from elastocal.drawing.projection import Projection
from elastocal.drawing.silhouette import hull, solid_points
from elastocal.drawing.skeleton import Skeleton, skeletons
from elastocal.drawing.svg import join, line, polyline, tag, text
from elastocal.drawing.traces import trace
from elastocal.robot.chain import Robot, Tool
from elastocal.robot.posture import Posture, forward_kinematics
from elastocal.study.study import Study
from elastocal.study.test_path import TestPath
from elastocal.wording.numbers import fixed, plain
from elastocal.writing import signature

_WIDTH, _HEIGHT, _TABLE, _GAP, _TOP = 620.0, 520.0, 250.0, 24.0, 76.0
_MARGINS = (70.0, 60.0, 50.0)
_ROW = 19.0
_GRID = 0.5
_SHOWN = 5  # test poses that are drawn
_HEADS = 8  # how much worse it is to cover a head than a line
_RADIUS = 30.0  # of the arcs [px]
_FORCE = 0.2  # length of a force over the size of the arm
_TRIAD = (("x", "#b3261e"), ("y", "#2e7d32"), ("z", "#1d5fa8"))


@dataclass(frozen=True)
class _Pose:
    """One panel: what is drawn, in the base frame [m]."""

    title: str
    tool: Tool
    q: Array
    force: Array
    arrow: Array
    skeleton: Skeleton
    solids: tuple[Array, ...]
    trace: Array

    @property
    def reach(self) -> Array:
        """(K, 3) points that must be in the picture."""
        tip = self.skeleton.tcp + self.arrow
        own = [self.skeleton.points, tip[None], np.zeros((1, 3)), self.trace]
        return np.vstack([*own, *self.solids])


def check_picture(study: Study) -> str:
    """The picture as the text of an SVG file."""
    poses = _poses(study)
    _, above, below = _MARGINS
    fitted = [Projection(pose.reach, _WIDTH, margins=_MARGINS) for pose in poses]
    scale = min(
        view.scale * min(1.0, (_HEIGHT - above - below) / (view.height - above - below))
        for view in fitted
    )
    panels, y = [], _TOP
    for pose in poses:
        panel, height = _panel(study, pose, scale)
        panels.append(tag("g", panel, transform=f"translate(0 {y:.0f})"))
        y += height + _GAP
    width = _WIDTH + _TABLE
    parts = [
        tag("style", Markup(_style())),
        tag("title", f"{study.name}: {study.robot.name} at home and in its test poses"),
        tag("rect", width=width, height=y + 48.0, fill=COLOURS["paper"]),
        text(24, 34, f"{study.name}: {study.robot.name}", "heading"),
        text(24, 56, _caption(study), "note"),
        *panels,
        *_legend(y),
    ]
    picture = tag(
        "svg",
        *parts,
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {width:.0f} {y + 48.0:.0f}",
        width=width,
        height=y + 48.0,
        class_="check",
    )
    return f"{picture}\n<!-- {signature('picture')} -->\n"


def check_page(study: Study) -> str:
    """The picture as an HTML page."""
    page = Markup(
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
        '<meta http-equiv="Content-Security-Policy" content="{}"><title>{}</title></head>\n'
        '<body style="margin:1rem">\n{}</body></html>\n'
    )
    return str(page.format(policy(), study.name, Markup(check_picture(study))))


def _poses(study: Study) -> list[_Pose]:
    """Home, then the test poses that are load cases."""
    home = np.clip(np.zeros(len(study.robot.joints)), study.limits[0], study.limits[1])
    at_zero = "Home: every joint at zero" if not home.any() else "Home: as near to zero as allowed"
    nowhere = np.zeros((0, 3))
    found = [_pose(study.robot, at_zero, study.experiments.tool, home, np.zeros(3), nowhere)]
    for pose in study.test_poses:
        if pose.tool is not None and pose.case is not None:
            own = pose.name.removeprefix("test pose ")
            title, force = f"Test pose {own}", pose.case.wrench[0, :3]
            if isinstance(pose, TestPath):
                title = f"Test path {own}"
            line = trace(study.robot, pose)
            found.append(_pose(study.robot, title, pose.tool, pose.case.q[0], force, line))
    return found[: 1 + _SHOWN]


def _pose(robot: Robot, title: str, tool: Tool, q: Array, force: Array, line: Array) -> _Pose:
    skeleton = skeletons(robot, tool, q[None])[0]
    posture = Posture(robot, q[None])
    solids = [solid_points(shape, posture, 0) for shape in robot.visuals]
    size = float(np.ptp(skeleton.points, axis=0).max())
    largest = float(np.linalg.norm(force))
    arrow = force * (_FORCE * size / largest) if largest else force
    return _Pose(title, tool, q, force, arrow, skeleton, tuple(s for s in solids if len(s)), line)


def _panel(study: Study, pose: _Pose, scale: float) -> tuple[Markup, float]:
    """One pose with the table of its joint values, and its height [px]."""
    robot, q, skeleton, arrow = study.robot, pose.q, pose.skeleton, pose.arrow
    view = Projection(pose.reach, _WIDTH, margins=_MARGINS, scale=scale)
    marks = glyphs(
        robot.joint_names,
        skeleton.centres,
        skeleton.axes,
        robot.prismatic,
        _RADIUS / view.scale,
        view,
    )
    flange = forward_kinematics(robot, q[None])[0]
    busy = [view(np.linspace(a, b, 12)) for a, b in _segments(skeleton)]
    busy += [view(mark.arrow) for mark in marks]
    busy += [view(np.repeat(mark.arrow[-1:], _HEADS, axis=0)) for mark in marks]
    busy.append(view(pose.trace))
    busy.append(view(np.repeat(skeleton.markers, _HEADS, axis=0)))
    busy.append(view(np.linspace(skeleton.tcp, skeleton.tcp + arrow, _HEADS)))
    labels = Labels(_WIDTH, view.height, np.vstack(busy))
    parts = list(_solids(view, pose.solids))
    parts += [polyline(view(part), "tool") for part in skeleton.tool]
    parts += [polyline(view(skeleton.arm), "limb-edge"), polyline(view(skeleton.arm), "limb")]
    if len(pose.trace):
        parts.append(polyline(view(pose.trace), "trace"))
    parts += [_triad(view, np.eye(4)), _triad(view, flange)]
    parts += [_glyph(view, mark) for mark in marks]
    if arrow.any():
        parts.append(_arrow(view, np.array([skeleton.tcp, skeleton.tcp + arrow]), "force"))
    parts += [_names(view, marks, labels), _tool(view, pose, skeleton, arrow, labels)]
    table, rows = _table(study, q)
    height = max(view.height, 64.0 + _ROW * rows)
    floor = tag("svg", _floor(view, pose.reach), y=-4, width=_WIDTH + 8.0, height=height)
    own = [floor, text(24, 20, pose.title, "title"), *parts, table]
    if len(pose.trace):
        own.append(text(24, 39, "the robot at its first point", "note"))
    frame = tag("rect", x=12, y=-4, width=_WIDTH + _TABLE - 24, height=height, class_="frame")
    return join([frame, *own]), height


def _segments(skeleton: Skeleton) -> list[tuple[Array, Array]]:
    lines = [skeleton.arm, *skeleton.tool]
    return [ends for points in lines for ends in pairwise(points)]


def _floor(view: Projection, points: Array) -> Markup:
    """The plane z = 0 in squares of half a metre, or of five metres under large machines."""
    span = float(np.ptp(points[:, :2], axis=0).max())
    grid = _GRID if span < 12.0 else 10.0 * _GRID
    low = np.floor(points[:, :2].min(axis=0) / grid) * grid
    high = np.ceil(points[:, :2].max(axis=0) / grid) * grid
    lines = [
        *([[x, low[1], 0], [x, high[1], 0]] for x in np.arange(low[0], high[0] + 1e-9, grid)),
        *([[low[0], y, 0], [high[0], y, 0]] for y in np.arange(low[1], high[1] + 1e-9, grid)),
    ]
    return join(polyline(view(np.array(ends)), "floor") for ends in lines)


def _solids(view: Projection, solids: tuple[Array, ...]) -> list[Markup]:
    """Silhouettes, the far ones first."""
    ordered = sorted(solids, key=lambda points: float(view.nearness(points).mean()))
    shown = []
    for points in ordered:
        corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in hull(view(points)))
        shown.append(tag("polygon", points=corners, class_="solid"))
    return shown


def _triad(view: Projection, frame: Array) -> Markup:
    """The axes of a frame (4, 4)."""
    parts = []
    length = 46.0 / view.scale
    for k, (name, colour) in enumerate(_TRIAD):
        ends = np.array([frame[:3, 3], frame[:3, 3] + length * frame[:3, k]])
        a, b = view(ends)
        parts.append(tag("line", x1=a[0], y1=a[1], x2=b[0], y2=b[1], stroke=colour, class_="triad"))
        tip = b + (b - a) / max(float(np.linalg.norm(b - a)), 9.0) * 9.0
        parts.append(text(tip[0], tip[1] + 4.0, name, "triad-name", "middle"))
    return join(parts)


def _glyph(view: Projection, mark: Glyph) -> Markup:
    a, b = view(mark.axis)
    return join([line(a[0], a[1], b[0], b[1], "joint-axis"), _arrow(view, mark.arrow, "turn")])


def _arrow(view: Projection, points: Array, class_: str) -> Markup:
    """A line with a head at its end."""
    seen = view(points)
    end = seen[-1]
    near = np.linalg.norm(seen - end, axis=1) > 7.0
    back = seen[np.flatnonzero(near)[-1]] if near.any() else seen[0]
    along = (end - back) / max(float(np.linalg.norm(end - back)), 1e-9)
    side = np.array([-along[1], along[0]])
    tip = end + 4.0 * along
    corners = (tip, tip - 12.0 * along + 5.2 * side, tip - 12.0 * along - 5.2 * side)
    head = " ".join(f"{x:.1f},{y:.1f}" for x, y in corners)
    return join([polyline(seen, class_), tag("polygon", points=head, class_=f"{class_}-head")])


def _names(view: Projection, marks: list[Glyph], labels: Labels) -> Markup:
    return join(
        labels.place(view(mark.centre[None])[0], f"{mark.name} +", "joint-name") for mark in marks
    )


def _tool(
    view: Projection, pose: _Pose, skeleton: Skeleton, arrow: Array, labels: Labels
) -> Markup:
    """The points of the tool and the force, named; points that coincide are named once."""
    points = [(skeleton.tcp, "TCP"), (skeleton.load_point, "load point")]
    points += [(p, n) for p, n in zip(skeleton.markers, pose.tool.marker_names, strict=True)]
    merged: list[tuple[Array, list[str]]] = []
    for point, name in points:
        same = [words for other, words in merged if np.linalg.norm(point - other) < 1e-6]
        if same and name not in same[0]:
            same[0].append(name)
        elif not same:
            merged.append((point, [name]))
    parts = []
    for point, words in merged:
        x, y = view(point[None])[0]
        parts.append(tag("circle", cx=x, cy=y, r=4.0, class_="point"))
        parts.append(labels.place(np.array([x, y]), ", ".join(words), "point-name"))
    if arrow.any():
        size = f"{plain(float(np.linalg.norm(pose.force)))} N"
        parts.append(labels.place(view((skeleton.tcp + arrow)[None])[0], size, "force-name"))
    return join(parts)


def _table(study: Study, q: Array) -> tuple[Markup, int]:
    """Joint values of the model, and of the controller where they differ."""
    robot = study.robot
    shown = study.coupling.to_controller(q[None])[0]
    differs = not study.coupling.is_identity
    x = _WIDTH + 8.0
    parts = [text(x, 44.0, "joint", "head")]
    parts.append(text(x + 150.0, 44.0, "model", "head", "end"))
    if differs:
        parts.append(text(x + 220.0, 44.0, "controller", "head", "end"))
    for i, joint in enumerate(robot.joints):
        scale, unit = joint.kind.shown
        y = 64.0 + _ROW * i
        parts.append(text(x, y, _short(joint.name), "cell"))
        parts.append(text(x + 150.0, y, f"{fixed(scale * q[i], 1)} {unit}", "cell", "end"))
        if differs:
            value = f"{fixed(scale * shown[i], 1)} {unit}"
            parts.append(text(x + 220.0, y, value, "cell", "end"))
    return join(parts), len(robot.joints) + 1


def _short(name: str) -> str:
    return name if len(name) <= 14 else name[:13] + "…"


def _caption(study: Study) -> str:
    about = "Arrows show the way a joint value of the model grows; compare each with the robot."
    turned = np.flatnonzero(np.diag(study.coupling.matrix) < 0.0)
    if len(turned):
        names = ", ".join(study.robot.joint_names[i] for i in turned)
        about += f" The controller counts {names} the other way."
    if any(shape.kind == "mesh" for shape in study.robot.visuals):
        about += " Meshes are not drawn."
    return about


def _legend(y: float) -> list[Markup]:
    """What the signs mean."""
    entries = (
        (24.0, "joint-axis", "axis of a joint"),
        (184.0, "turn", "positive direction"),
        (360.0, "limb-key", "arm, from base to flange"),
        (570.0, "tool", "tool"),
        (660.0, "force", "force on the robot"),
    )
    parts = []
    for x, class_, words in entries:
        parts.append(line(x, y + 14.0, x + 26.0, y + 14.0, class_))
        parts.append(text(x + 33.0, y + 18.0, words, "note"))
    return parts


def _style() -> str:
    c = COLOURS
    halo = f"paint-order: stroke; stroke: {c['paper']}; stroke-width: 4px; stroke-linejoin: round;"
    return f"""
.check text {{ font-family: system-ui, sans-serif; font-size: 13px; fill: {c["ink"]}; }}
.check polyline, .check line {{ fill: none; stroke-linecap: round; stroke-linejoin: round; }}
.check .heading {{ font-size: 21px; font-weight: 650; }}
.check .title {{ font-size: 15px; font-weight: 600; }}
.check .note, .check .head {{ fill: {c["muted"]}; }}
.check .cell {{ font-variant-numeric: tabular-nums; }}
.check .frame {{ fill: none; stroke: {c["line"]}; rx: 6px; }}
.check .floor {{ stroke: {c["line"]}; stroke-width: .8; }}
.check .solid {{ fill: {c["ghost"]}; fill-opacity: .28; stroke: {c["faint"]}; stroke-width: .8; }}
.check .limb-edge {{ stroke: {c["accent"]}; stroke-width: 8; opacity: .85; }}
.check .limb {{ stroke: {c["accent-mid"]}; stroke-width: 5; }}
.check .limb-key {{ stroke: {c["accent"]}; stroke-width: 7; }}
.check .tool {{ stroke: {c["muted"]}; stroke-width: 3; }}
.check .trace {{ stroke: {c["contrast"]}; stroke-width: 1.8; }}
.check .joint-axis {{ stroke: {c["ink"]}; stroke-width: 1.3; stroke-dasharray: 9 3 2 3; }}
.check .turn {{ stroke: {c["contrast"]}; stroke-width: 2.6; }}
.check .turn-head {{ fill: {c["contrast"]}; }}
.check .force {{ stroke: {c["ink"]}; stroke-width: 2.4; }}
.check .force-head, .check .point {{ fill: {c["ink"]}; }}
.check .triad {{ stroke-width: 2; }}
.check .triad-name {{ font-size: 11px; {halo} }}
.check .joint-name {{ fill: {c["contrast"]}; font-weight: 650; {halo} }}
.check .point-name, .check .force-name {{ {halo} }}
.check .leader {{ stroke: {c["faint"]}; stroke-width: .9; }}
"""
