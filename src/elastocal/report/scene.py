"""The robot in 3D, as data for plotly: one group of traces for every configuration.

In: stage. Out: a dict ready for JSON, in mm. Every trace carries a role in its `meta`,
by which `templates/scene.js` shows it. solid: with its configuration, or with all; crowd: only
with all; ghost: while another one is shown; detail: only with its own; limit-detail: likewise, if
limits are switched on; test, limit: by their own switch.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from elastocal.arrays import Array
from elastocal.drawing.palette import COLOURS
from elastocal.drawing.skeleton import Skeleton
from elastocal.drawing.solids import Mesh, arrow, ball, sphere, tube, union
from elastocal.drawing.stage import DrawnCase, Stage
from elastocal.drawing.surfaces import Surface, aperture, wall
from elastocal.planning.plan import Plan
from elastocal.report.section import Values
from elastocal.robot.chain import Robot
from elastocal.robot.posture import Posture
from elastocal.wording.numbers import words as words_of

Trace = dict[str, Any]

_LINK, _JOINT, _TOOL, _ARROW = 0.014, 0.027, 0.007, 0.006  # radii over the size of the robot
_LIGHT = {"ambient": 0.62, "diffuse": 0.6, "specular": 0.12, "roughness": 0.7, "fresnel": 0.1}


def scene(plan: Plan, stage: Stage) -> Values:
    """The configurations of a plan among test poses and constraints."""
    constraints, robot = plan.study.constraints, plan.study.robot
    traces: list[Trace] = []
    for constraint in constraints:
        surface = wall(constraint, stage)
        if surface is not None:
            traces += _surface(surface, "limit", -1)
    for figure in stage.tests:
        traces += _robot(figure, stage.size, "contrast", "test", -1)
    traces += _crowd(stage, robot)
    for i, figure in enumerate(stage.planned):
        alone = Posture(robot, plan.load_cases.q[i : i + 1])
        for constraint in constraints:
            at, length = figure.skeleton.load_point, 0.17 * stage.size
            opening = aperture(constraint, alone, at, length)
            if opening is not None:
                traces += _surface(opening, "limit-detail", i)
    return {"data": traces, "layout": _layout(stage), "count": len(stage.planned)}


def vector_scene(stage: Stage, robot: Robot) -> Values:
    """Configurations with the small vectors that begin at their markers."""
    traces = _crowd(stage, robot)
    for i, figure in enumerate(stage.planned):
        arrows = union([arrow(v.start, v.along, 0.005 * stage.size) for v in figure.vectors])
        halos = {tuple(np.round(v.start, 4)): v for v in figure.vectors if v.halo > 0.0}
        balls = union([sphere(v.start, v.halo) for v in halos.values()])
        for solid, colour, opacity in ((arrows, "contrast", 1.0), (balls, "muted", 0.2)):
            body = _mesh(solid, COLOURS[colour], "solid", i)
            if body is not None:
                traces.append(body | {"opacity": opacity})
    return {"data": traces, "layout": _layout(stage), "count": len(stage.planned)}


def path_scene(stage: Stage, robot: Robot, lines: Mapping[str, tuple[Array, str, int]]) -> Values:
    """One configuration, and lines (., 3) [m] with colour and width by the role of their switch."""
    traces = _crowd(stage, robot)
    for role, (points, colour, width) in lines.items():
        traces.append(_lines([points], COLOURS[colour], role, -1, width))
    every = np.vstack([points for points, _, _ in lines.values()])
    middle = 0.5 * (every.min(axis=0) + every.max(axis=0))
    half = 0.75 * max(float(np.ptp(every, axis=0).max()), 0.04)
    near = [[round(1e3 * (m - half), 1), round(1e3 * (m + half), 1)] for m in middle]
    return {"data": traces, "layout": _layout(stage), "count": len(stage.planned), "near": near}


def _crowd(stage: Stage, robot: Robot) -> list[Trace]:
    """Every planned figure: as a body, as a ghost, with the names of its joints."""
    traces: list[Trace] = []
    for i, figure in enumerate(stage.planned):
        traces += _robot(figure, stage.size, "accent", "solid", i)
        traces.append(_ghost(figure, i))
        traces.append(_names(figure.skeleton, robot.joint_names, stage.size, i))
    return traces


def _robot(figure: DrawnCase, size: float, colour: str, role: str, group: int) -> list[Trace]:
    """The solid robot with its load."""
    skeleton = figure.skeleton
    links, joints, tool = _bodies(skeleton, size, 1.0 if role == "solid" else 0.75)
    load = union(
        [
            arrow(skeleton.load_point, figure.force, _ARROW * size),
            arrow(skeleton.load_point, figure.moment, _ARROW * size),
            arrow(skeleton.load_point, 0.8 * figure.moment, _ARROW * size),
        ]
    )
    traces: list[Trace | None] = [
        _mesh(links, COLOURS[colour], role, group),
        _mesh(joints, COLOURS["ink"] if role == "solid" else "#7a3207", role, group),
        _mesh(tool, COLOURS["faint"], role, group),
        _mesh(load, COLOURS["ink"], role, group),
    ]
    if len(figure.trace):
        traces.append(_lines([figure.trace], COLOURS[colour], role, group, 6))
    traces += _labels(figure, colour, role, group)
    return [trace for trace in traces if trace is not None]


def _labels(figure: DrawnCase, colour: str, role: str, group: int) -> list[Trace]:
    """What is written at the arrow: all at once only numbers, alone the load as well."""
    skeleton, ink = figure.skeleton, COLOURS[colour]
    ends = [skeleton.load_point + v for v in (figure.force, figure.moment) if np.any(v)]
    at = ends[0] if ends else skeleton.load_point
    if role == "test":
        words = f"{_short(figure.label, 18)} · {figure.load}\u00a0\u00a0"
        side = "bottom center" if len(figure.trace) else "middle left"  # a path may start at a pose
        return [_text(skeleton.load_point[None], [words], ink, role, group, 13, side)]
    words = f"No. {figure.label}" + (f" · {figure.load}" if figure.load else "")
    return [
        _text(at[None], [figure.label], ink, "crowd", group, 15, "middle right"),
        _text(at[None], [words], ink, "detail", group, 13, "middle right"),
    ]


def _bodies(skeleton: Skeleton, size: float, thickness: float) -> tuple[Mesh, Mesh, Mesh]:
    """Links, joints and tool; thinner towards the flange, as arms are."""
    arm, n = skeleton.arm, len(skeleton.centres)
    taper = thickness * np.linspace(1.25, 0.8, len(arm))
    links = [
        tube(a, b, _LINK * size * r) for (a, b), r in zip(pairwise(arm), taper[1:], strict=True)
    ]
    links += [ball(point, _LINK * size * r) for point, r in zip(arm, taper, strict=True)]
    shrink = thickness * np.linspace(1.2, 0.7, n)
    half = _JOINT * size * shrink[:, None] * skeleton.axes
    joints = [
        tube(c - h, c + h, _JOINT * size * s * 0.85)
        for c, h, s in zip(skeleton.centres, half, shrink, strict=True)
    ]
    tool = [tube(a, b, _TOOL * size) for line in skeleton.tool for a, b in pairwise(line)]
    points = [skeleton.load_point, skeleton.tcp, *skeleton.markers]
    tool += [ball(point, 1.7 * _TOOL * size) for point in np.unique(points, axis=0)]
    return union(links), union(joints), union(tool)


def _ghost(figure: DrawnCase, group: int) -> Trace:
    """A configuration that is not the one looked at, as thin lines."""
    lines = [figure.skeleton.arm, *figure.skeleton.tool]
    return _lines(lines, COLOURS["ghost"], "ghost", group, 5)


def _names(skeleton: Skeleton, names: tuple[str, ...], size: float, group: int) -> Trace:
    """Joint names beside the joints; joints that share a place share a line of text."""
    places: list[Array] = []
    words: list[list[str]] = []
    for centre, name in zip(skeleton.centres, names, strict=True):
        near = [k for k, p in enumerate(places) if np.linalg.norm(p - centre) < 0.06 * size]
        if near:
            words[near[0]].append(name)
        else:
            places.append(centre)
            words.append([name])
    texts = [", ".join(together) for together in words]
    texts = ["\u00a0" * 5 + text for text in texts]  # beside the joint, not within it
    return _text(np.array(places), texts, COLOURS["ink"], "detail", group, 12, "middle right")


def _surface(surface: Surface, role: str, group: int) -> list[Trace]:
    """A limit: translucent, with its outline and its name."""
    body = _mesh(surface.solid, COLOURS["muted"], role, group)
    lines = list(surface.outlines)
    traces = [_lines(lines, COLOURS["faint"], role, group, 2)] if lines else []
    traces.append(
        _text(
            surface.label[None],
            [surface.name],
            COLOURS["muted"],
            role,
            group,
            11,
            "top left" if role == "limit" else "top right",
        )
    )
    if body is not None:
        body |= {"opacity": surface.opacity, "lighting": {"ambient": 1.0, "diffuse": 0.0}}
        traces.append(body)
    return traces


def _mesh(solid: Mesh, colour: str, role: str, group: int) -> Trace | None:
    """Triangles in mm, rounded to a tenth; None if there are none."""
    if not len(solid.triangles):
        return None
    x, y, z = np.round(1e3 * solid.vertices, 1).T.tolist()
    i, j, k = solid.triangles.T.tolist()
    return {
        "type": "mesh3d",
        "x": x,
        "y": y,
        "z": z,
        "i": i,
        "j": j,
        "k": k,
        "color": colour,
        "lighting": _LIGHT,
        "lightposition": {"x": 4000, "y": -9000, "z": 12000},
        "hoverinfo": "skip",
        "meta": {"role": role, "group": group},
    }


def _lines(lines: list[Array], colour: str, role: str, group: int, width: int) -> Trace:
    """Polylines (., 3) [m] in mm, with gaps between them."""
    gap = np.full((1, 3), np.nan)
    points = np.vstack([part for line in lines for part in (line, gap)])[:-1]
    x, y, z = (
        [None if np.isnan(value) else round(1e3 * value, 1) for value in column]
        for column in points.T
    )
    return {
        "type": "scatter3d",
        "mode": "lines",
        "x": x,
        "y": y,
        "z": z,
        "connectgaps": False,
        "line": {"color": colour, "width": width},
        "hoverinfo": "skip",
        "meta": {"role": role, "group": group},
    }


def _text(
    at: Array, words: list[str], colour: str, role: str, group: int, size: int, side: str
) -> Trace:
    """Words at points (K, 3) [m]."""
    x, y, z = np.round(1e3 * at, 1).T.tolist()
    return {
        "type": "scatter3d",
        "mode": "text",
        "x": x,
        "y": y,
        "z": z,
        "text": [_short(word) for word in words],
        "textposition": side,
        "textfont": {"color": colour, "size": size},
        "hoverinfo": "skip",
        "meta": {"role": role, "group": group},
    }


def _short(text: str, most: int = 34) -> str:
    """Text cut to what fits beside a figure, without signs that plotly may read as tags."""
    text = words_of(text).replace("<", "‹").replace(">", "›")
    return text if len(text) <= most else text[: most - 1] + "…"


def _layout(stage: Stage) -> Values:
    """Layout with equal scales, z up, seen from the front and the right."""
    axes = {}
    for name, low, high in zip("xyz", 1e3 * stage.lower, 1e3 * stage.upper, strict=True):
        axes[f"{name}axis"] = {
            "title": {"text": f"{name} [mm]", "font": {"size": 12, "color": COLOURS["muted"]}},
            "range": [round(low), round(high)],
            "tickfont": {"size": 10, "color": COLOURS["muted"]},
            "nticks": 6,
            "tickformat": "d",
            "showspikes": False,
            "backgroundcolor": COLOURS["wash"],
            "showbackground": name == "z",
            "gridcolor": COLOURS["line"],
            "zerolinecolor": COLOURS["ghost"],
        }
    return {
        "scene": {**axes, "aspectmode": "data", "dragmode": "orbit"},
        "showlegend": False,
        "margin": {"l": 0, "r": 0, "t": 0, "b": 0},
        "paper_bgcolor": COLOURS["paper"],
        "font": {"family": "system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif"},
    }
