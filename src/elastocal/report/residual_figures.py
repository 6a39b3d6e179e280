"""Residuals on the robot: every configuration with what the model leaves unexplained, magnified.

In: an identification. Out: a stage, and what is said under its pictures.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from elastocal.drawing.stage import Stage, Vector, boxed, posed
from elastocal.elastic.load_cases import LoadCases
from elastocal.identification.result import Identification
from elastocal.measuring.measurements import rms_of_groups
from elastocal.report.charts.axes import shortened
from elastocal.wording.numbers import small

_MOST_FIGURES, _MOST_VECTORS = 12, 24
_LONGEST = 0.17  # longest arrow over the size of the robot


@dataclass(frozen=True)
class ResidualFigures:
    """What is drawn.

    Attributes:
        stage: Configurations with their residuals.
        magnification: By how much they are magnified.
        captions: One for each configuration.
        noise: Standard deviation that the rings are drawn for, twice it [m].
        others: Configurations that are not drawn: those with smaller residuals.
        thinned: Whether some figures lack vectors.
    """

    stage: Stage
    magnification: float
    captions: tuple[str, ...]
    noise: float
    others: int
    thinned: bool


def residual_figures(found: Identification) -> ResidualFigures:
    """Figures of the configurations with the largest residuals, in the order they were measured."""
    data = found.measurements
    group = found.configuration[data.case]
    size = np.linalg.norm(found.residual, axis=1)
    count = int(found.configuration.max()) + 1
    each = [
        (rms_of_groups(found.residual[kind.readings], group[kind.readings], count), kind)
        for kind in data.quantities
    ]
    rms, drawn = each[0][0], ~data.rotations
    first = np.array([np.flatnonzero(found.configuration == g)[0] for g in range(count)])
    chosen = np.argsort(-rms)[:_MOST_FIGURES]
    chosen = chosen[np.argsort(first[chosen])]
    cases = LoadCases(data.cases.q[first[chosen]], np.zeros((len(chosen), 6)))
    figures = posed(found.arm.robot, data.tool, cases, [str(i + 1) for i in range(len(chosen))])
    reach = max(float(np.abs(f.skeleton.points).max()) for f in figures)
    shown = np.isin(group, chosen) & drawn
    longest = max(float(size[shown].max(initial=0.0)), 1e-12)
    magnification = _round(_LONGEST * reach / longest)
    positions = [kind for kind in data.quantities if kind.unit == "m"]
    noise = found.noise_factor * data.noise_of(positions[0]) if positions else 0.0
    posed_figures, captions, thinned = [], [], False
    short = shortened(data.names, 16)
    for figure, g in zip(figures, chosen.tolist(), strict=True):
        readings = np.flatnonzero((group == g) & drawn)
        thinned |= len(readings) > _MOST_VECTORS
        vectors = tuple(
            Vector(
                figure.skeleton.markers[data.marker[r]],
                magnification * found.residual[r],
                2.0 * magnification * noise,
            )
            for r in readings[np.argsort(-size[readings])][:_MOST_VECTORS]
        )
        posed_figures.append(replace(figure, vectors=vectors))
        names = [short[i] for i in np.flatnonzero(found.configuration == g)]
        sizes = (
            f"{'RMS' if kind.unit == 'm' else 'rotation'} {small(float(own[g]), kind.unit)}"
            for own, kind in each
        )
        captions.append(f"{_experiments(names)}: {', '.join(sizes)}")
    stage = boxed(tuple(posed_figures))
    return ResidualFigures(
        stage, magnification, tuple(captions), noise, count - len(chosen), thinned
    )


def _experiments(names: list[str]) -> str:
    if len(names) == 1:
        return f"experiment {names[0]}"
    if len(names) <= 4:
        return f"experiments {', '.join(names)}"
    return f"{len(names)} experiments, {names[0]} to {names[-1]}"


def _round(value: float) -> float:
    """The largest of 1, 2, 5, 10, … that is not above `value`."""
    power = 10.0 ** np.floor(np.log10(max(value, 1.0)))
    return float(max(s * power for s in (1.0, 2.0, 5.0) if s * power <= max(value, 1.0)))
