"""Leverage: how much every experiment decides, and how far it is from what the others say.

In: leverage, left-out residuals, Cook's distances. Out: SVG with the most influential named.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.svg import Scale, drawing, line, tag
from elastocal.report.charts.axes import axis_below, axis_left, named_points

_WIDTH, _HEIGHT = 400.0, 330.0
_LEFT, _RIGHT, _TOP, _BOTTOM = 48.0, 390.0, 34.0, 282.0
_MOST = 600  # experiments drawn


def leverage_chart(
    leverage: Array, left_out: Array, cook: Array, names: Sequence[str], expected: float
) -> Markup:
    """Experiments as circles with areas in proportion to Cook's distance.

    Args:
        leverage: (N,) leverages.
        left_out: (N,) root mean square of the residuals when left out [σ].
        cook: (N,) Cook's distances; NaN where an experiment alone carries an unknown.
        names: Names of the experiments.
        expected: Mean leverage.
    """
    weight = np.where(np.isfinite(cook), cook, np.nanmax(np.append(cook, 0.0)))
    order = np.argsort(-weight)[:_MOST]
    most = 1.12 * float(max(leverage.max(), 1.2 * expected))
    across = Scale(0.0, most, _LEFT, _RIGHT)
    up = Scale(0.0, 1.15 * float(max(left_out.max(), 1.0)), _BOTTOM, _TOP)
    parts = axis_below(across, _TOP, _BOTTOM, "leverage: how many unknowns it decides", 5)
    parts += axis_left(up, _LEFT, _RIGHT, "RMS residual when left out [σ]")
    parts.append(line(across(expected), _TOP, across(expected), _BOTTOM, "median"))
    radius = np.clip(14.0 * np.sqrt(weight), 2.5, 22.0)
    for i in reversed(order.tolist()):
        r = float(radius[i])
        parts.append(
            tag("circle", cx=across(leverage[i]), cy=up(left_out[i]), r=r, class_="bubble")
        )
    top = order[:6]
    points = np.array([[across(leverage[i]), up(left_out[i])] for i in top])
    parts += named_points(points, [names[i] for i in top.tolist()], across, up, radius[top])
    about = "Leverage of every experiment and its residual when it is left out"
    return drawing(_WIDTH, _HEIGHT, about, *parts, class_="chart")
