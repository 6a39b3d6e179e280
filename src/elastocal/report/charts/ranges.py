"""Picture of where the configurations lie in the ranges of the joints.

In: configurations and limits. Out: SVG with one row a joint.
"""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from elastocal.drawing.svg import Scale, drawing, line, tag, text
from elastocal.planning.plan import Plan
from elastocal.robot.chain import Joint
from elastocal.wording.numbers import fixed

_RADIUS = 8.5


def range_chart(plan: Plan, width: float) -> Markup:
    """Numbered configurations within the joint ranges the study allows."""
    joints = plan.study.robot.joints
    narrow = width < 500.0
    longest = max(len(_short(joint.name)) for joint in joints)
    room = 66.0 + 8.5 * longest + (24.0 if plan.study.robot.prismatic.any() else 0.0)
    left, right = (16.0, width - 16.0) if narrow else (room, width - 70.0)
    parts: list[Markup] = []
    y = 4.0
    for j in range(len(joints)):
        row, y = _row(plan, j, y, left, right, narrow)
        parts += row
    about = "Joint values of every configuration within the allowed ranges"
    return drawing(width, y + 2.0, about, *parts, class_="chart")


def _row(
    plan: Plan, j: int, y: float, left: float, right: float, narrow: bool
) -> tuple[list[Markup], float]:
    """Range of joint `j` from the height `y` down, and where the next one begins."""
    study, joint = plan.study, plan.study.robot.joints[j]
    assert study.limits is not None
    low, high = (float(limit) for limit in study.limits[:, j])
    if study.held[j]:
        return _held(joint, low, y, left, narrow)
    scale = Scale(low, high, left, right)
    places = [scale(min(max(float(v), low), high)) for v in plan.load_cases.q[:, j]]
    levels = _levels(places)
    step = 2.0 * _RADIUS + 1.0
    middle = y + (20.0 if narrow else 4.0) + step * max(levels) + _RADIUS + 2.0
    parts = _names(joint, low, high, left, right, y + 15.0 if narrow else middle + 4.5, narrow)
    parts.append(line(left, middle, right, middle, "range"))
    if low < 0.0 < high:
        parts.append(line(scale(0.0), middle - 6.0, scale(0.0), middle + 6.0, "zero"))
    for i, (x, level) in enumerate(zip(places, levels, strict=True)):
        height = middle - level * step
        parts.append(tag("circle", cx=x, cy=height, r=_RADIUS, class_="dot"))
        parts.append(text(x, height + 4.0, str(i + 1), "in-dot", "middle"))
    return parts, middle + _RADIUS + 9.0


def _held(
    joint: Joint, value: float, y: float, left: float, narrow: bool
) -> tuple[list[Markup], float]:
    """A joint without a range, and where the next one begins."""
    said = f"held at {fixed(joint.kind.scale * value, 2)}{joint.kind.suffix}"
    name, height = _short(joint.name), y + 15.0
    if narrow:
        return [text(left, height, f"{name}: {said}", "lane")], y + 24.0
    words = [text(4.0, height, name, "lane strong"), text(left, height, said, "tick")]
    return words, y + 24.0


def _names(
    joint: Joint, low: float, high: float, left: float, right: float, y: float, narrow: bool
) -> list[Markup]:
    """Name and limits: above the range where it is narrow, else beside it."""
    kind = joint.kind
    ends = [f"{fixed(kind.scale * limit, 0)}{kind.suffix}" for limit in (low, high)]
    name = _short(joint.name)
    if narrow:
        ends[0] = f"{name}: from {ends[0]}"
        return [text(left, y, ends[0], "lane"), text(right, y, f"to {ends[1]}", "lane", "end")]
    return [
        text(4.0, y, name, "lane strong"),
        text(left - 12.0, y, ends[0], "tick", "end"),
        text(right + 12.0, y, ends[1], "tick"),
    ]


def _short(name: str) -> str:
    return name if len(name) <= 16 else name[:15] + "…"


def _levels(places: list[float]) -> list[int]:
    """Height of each dot over its line, so that no two cover each other."""
    levels = [0] * len(places)
    taken: list[float] = []
    for i in np.argsort(places):
        free = [k for k, edge in enumerate(taken) if places[i] - edge >= 2.0 * _RADIUS + 1.0]
        level = free[0] if free else len(taken)
        if free:
            taken[level] = places[i]
        else:
            taken.append(places[i])
        levels[i] = level
    return levels
