"""Picture of ρ0 over the hours of a campaign, for few or many configurations.

In: curves of plans. Out: SVG.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from elastocal.drawing.svg import Scale, drawing, polyline, tag, text
from elastocal.planning.trade_off import TimeCurve
from elastocal.report.charts.axes import axis_below, axis_left, legend, legend_height, sign
from elastocal.wording.numbers import length, length_unit

_WIDTH, _LEFT, _RIGHT, _TOP, _BOTTOM = 400.0, 52.0, 386.0, 30.0, 236.0
_SIGNS = ("ring", "square", "dot")


def hours_chart(curves: Sequence[TimeCurve], own: tuple[float, float]) -> Markup:
    """ρ0 over hours.

    Args:
        curves: At most three curves.
        own: Hours and error [m] of the plan of this report, marked.
    """
    errors = np.concatenate([*(c.rho0 for c in curves), [own[1]]])
    hours = np.concatenate([*(c.hours for c in curves), [own[0]]])
    factor, unit = length_unit(errors.tolist())
    across = Scale(0.0, 1.06 * float(hours.max()), _LEFT, _RIGHT)
    up = Scale(0.0, 1.12 * factor * float(errors.max()), _BOTTOM, _TOP)
    parts = axis_left(up, _LEFT, _RIGHT, f"ρ₀ [{unit}]")
    parts += axis_below(across, _TOP, _BOTTOM, "hours at the cell")
    items = []
    for curve, kind in zip(curves, _SIGNS, strict=False):
        points = np.array(
            [(across(h), up(factor * r)) for h, r in zip(curve.hours, curve.rho0, strict=True)]
        )
        parts.append(polyline(points, "curve"))
        parts += [sign(kind, x, y) for x, y in points]
        items.append((kind, named(curve)))
    x, y = across(own[0]), up(factor * own[1])
    diamond = f"{x},{y - 9} {x + 9},{y} {x},{y + 9} {x - 9},{y}"
    parts.append(tag("polygon", points=diamond, class_="mark own"))
    parts.append(text(min(x, _RIGHT - 22.0), y - 16.0, "this plan", "value own", "middle"))
    top = _BOTTOM + 60.0
    parts += legend(items, _LEFT, top, _RIGHT)
    about = f"Root mean square position error over hours; this plan {length(own[1])}"
    height = top + legend_height(items, _LEFT, _RIGHT)
    return drawing(_WIDTH, height, about, *parts, class_="chart")


def named(curve: TimeCurve) -> str:
    """What a curve is called."""
    if curve.configurations is None:
        return "any number of configurations"
    plural = "" if curve.configurations == 1 else "s"
    return f"{curve.configurations} configuration{plural}"
