"""Picture of where the configurations lie in the ranges of the joints.

In: configurations and limits. Out: SVG with one row a joint.
"""

from __future__ import annotations

import numpy as np
from markupsafe import Markup

from elastocal.planning import Plan
from elastocal.report.svg import Scale, drawing, line, tag, text
from elastocal.report.units import fixed, joint_unit

_RADIUS = 8.5


def range_chart(plan: Plan, width: float) -> Markup:
    """Numbered configurations within the joint ranges the study allows."""
    study = plan.study
    assert study.limits is not None
    narrow = width < 500.0
    names = [joint.name if len(joint.name) <= 16 else joint.name[:15] + "…"
             for joint in study.robot.joints]
    longest = max(len(name) for name in names)
    left = 16.0 if narrow else 66.0 + min(8.5 * longest, 140.0)
    right = width - (16.0 if narrow else 70.0)
    parts: list[Markup] = []
    y = 4.0
    for j, joint in enumerate(study.robot.joints):
        low, high = (float(limit) for limit in study.limits[:, j])
        scale = Scale(low, high, left, right)
        places = [scale(min(max(float(v), low), high)) for v in plan.load_cases.q[:, j]]
        levels = _levels(places)
        top = y + (20.0 if narrow else 4.0)
        middle = top + (2.0 * _RADIUS + 1.0) * max(levels) + _RADIUS + 2.0
        unit, factor = joint_unit(joint.prismatic), 1e3 if joint.prismatic else 180.0 / np.pi
        ends = [f"{fixed(factor * limit, 0)}{' mm' if unit == 'mm' else unit}" for limit in (low, high)]
        if narrow:
            parts.append(text(left, y + 15.0, f"{names[j]}   {ends[0]}", "lane"))
            parts.append(text(right, y + 15.0, ends[1], "lane", "end"))
        else:
            parts.append(text(4.0, middle + 4.5, names[j], "lane strong"))
            parts.append(text(left - 12.0, middle + 4.5, ends[0], "tick", "end"))
            parts.append(text(right + 12.0, middle + 4.5, ends[1], "tick"))
        parts.append(line(left, middle, right, middle, "range"))
        if low < 0.0 < high:
            parts.append(line(scale(0.0), middle - 6.0, scale(0.0), middle + 6.0, "zero"))
        for i, (x, level) in enumerate(zip(places, levels, strict=True)):
            height = middle - level * (2.0 * _RADIUS + 1.0)
            parts.append(tag("circle", cx=x, cy=height, r=_RADIUS, class_="dot"))
            parts.append(text(x, height + 4.0, str(i + 1), "in-dot", "middle"))
        y = middle + _RADIUS + 9.0
    about = "Joint values of every configuration within the allowed ranges"
    return drawing(width, y + 2.0, about, *parts, class_="chart")


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
