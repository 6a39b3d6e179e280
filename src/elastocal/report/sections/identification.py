"""Sections of an identification: compliances with intervals, residuals, influence, correlation.

In: identification, compliances from elsewhere. Out: sections.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from markupsafe import Markup

from elastocal.arrays import Array
from elastocal.drawing.picture import portrait
from elastocal.identification.doubts import SELDOM, doubts
from elastocal.identification.residuals import (
    left_out_rms,
    residual_quantiles,
    share_inside,
    twice_the_noise,
)
from elastocal.identification.result import Identification
from elastocal.identification.search import Searched
from elastocal.identification.validation import summary
from elastocal.measuring.measurements import Measurements, Quantity
from elastocal.report.charts.correlation import combinations_chart, correlation_chart
from elastocal.report.charts.forest import close_up, forest_chart
from elastocal.report.charts.leverage import leverage_chart
from elastocal.report.charts.quantiles import quantile_chart
from elastocal.report.charts.strips import Strips, strips_chart
from elastocal.report.contents import Contents
from elastocal.report.intervals import Family, families
from elastocal.report.layout import two_widths
from elastocal.report.residual_figures import residual_figures
from elastocal.report.scene import vector_scene
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.sections.nuisance import nuisance_section
from elastocal.report.tables import BarTable, Row
from elastocal.report.verdict import Tile
from elastocal.wording import worded
from elastocal.wording.identification import chance
from elastocal.wording.lists import counted
from elastocal.wording.numbers import fixed, length, number, percent, plain, probability, small
from elastocal.wording.numbers import sure as sure_of
from elastocal.wording.searches import candidate

_NEAREST = 5  # candidates shown
_WORST = 3  # combinations shown


def identification_chapter(contents: Contents) -> Chapter | None:
    """The sections of the identification."""
    found = contents.identification
    if found is None:
        return None
    figures = residual_figures(found)
    besides = () if found.nuisance is None else (nuisance_section(found),)
    sections = (
        PageSection("identification", "Compliances", _result(contents, found)),
        *besides,
        PageSection(
            "residuals",
            "Residuals",
            {
                "figures": figures,
                "magnification": plain(figures.magnification),
                "noise": length(2.0 * figures.noise),
                "gallery": [
                    (f.label, portrait(f, figures.stage), caption)
                    for f, caption in zip(figures.stage.planned, figures.captions, strict=True)
                ],
                **_residuals(found),
            },
            vector_scene(figures.stage, found.arm.robot),
        ),
        PageSection("influence", "Influence", _influence(found)),
        PageSection("correlation", "Correlation", _correlation(found)),
    )
    return Chapter("Identification", sections)


def remarks(found: Identification, beyond: Searched | None) -> tuple[str, ...]:
    """What looks odd in the readings, what is weak in the result, and what else explains them."""
    more = () if beyond is None else beyond.doubts
    return (*readings_remarks(found.measurements), *map(worded, (*doubts(found), *more)))


def readings_remarks(data: Measurements) -> tuple[str, ...]:
    """What the reader says of readings, and what looks odd in them."""
    return (*data.remarks, *map(worded, data.doubts))


def tiles(found: Identification) -> list[Tile]:
    """The numbers that matter most."""
    data = found.measurements
    rotation = " and the rotation" if data.tool.rotation else ""
    made = [
        Tile(
            "Readings",
            str(len(data)),
            f"of {counted(len(data.tool.markers), 'marker')}{rotation} in "
            f"{counted(len(data.cases), 'experiment')}, "
            f"{counted(int(found.configuration.max()) + 1, 'distinct load case')}.",
        )
    ]
    if np.isfinite(found.scale):
        each = [(n, data.noise_of(n.kind), n.kind.unit) for n in found.noise_of_kinds]
        promised = " and ".join(small(sigma, unit) for _, sigma, unit in each)
        made.append(
            Tile(
                "Noise found",
                " and ".join(small(n.scale * sigma, unit) for n, sigma, unit in each),
                f"Standard deviation of one coordinate, from {found.dof} degrees of freedom: "
                f"{number(found.scale, 2)} times what was promised, {promised}.",
            )
        )
    for kind in data.quantities:
        whole = summary(data.deflection[kind.readings]).rms
        left = summary(found.residual[kind.readings]).rms
        position = kind.unit == "m"
        made.append(
            Tile(
                "Explained" if position else "Rotations explained",
                percent(1.0 - left / whole) if whole > 0.0 else "–",
                f"{'Deflections' if position else 'Rotations'} of {small(whole, kind.unit)} (RMS) "
                f"leave residuals of {small(left, kind.unit)}.",
            )
        )
    return made


def _result(contents: Contents, found: Identification) -> Values:
    """The compliances, and what is weak in them."""
    kinds = families(found, contents.references)
    return {
        "tiles": tiles(found),
        "remarks": remarks(found, contents.searched),
        "lacks": _lacks(contents.searched),
        "families": [(family, _forest(family, contents, found)) for family in kinds],
        "how": _how(found),
        "references": list(contents.references),
        "confidence": sure_of(found.how.confidence),
        "open": any(row.state for family in kinds for row in family.table.rows),
    }


def _lacks(beyond: Searched | None) -> BarTable | None:
    """The candidates that come nearest, with and without which the readings are predicted."""
    if beyond is None or beyond.lacks is None:
        return None
    best = [one for one in beyond.lacks.tested if np.isfinite(one.left_out)][:_NEAREST]
    rows = [
        (
            candidate(*vars(one.candidate).values()),
            length(one.before),
            length(one.left_out),
            f"{fixed(100.0 * one.share, 0)} %",
            probability(one.p_value),
        )
        for one in best
        if one.physical
    ]
    head = (
        "with",
        "left-out error without it",
        "with it",
        "residual variance removed",
        "by chance",
    )
    return BarTable(head, tuple(Row(cells) for cells in rows)) if rows else None


def _forest(family: Family, contents: Contents, found: Identification) -> Any:
    """Intervals of one kind of springs."""
    panels = [
        (f"compliance [{family.unit}]", family.compliance),
        (f"stiffness [{family.stiffness_unit}]", family.stiffness),
        ("compliance, off the estimate [%]", close_up(family.compliance)),
    ]
    sure = sure_of(found.how.confidence)
    return two_widths(lambda width: forest_chart(panels, list(contents.references), sure, width))


def _how(found: Identification) -> list[str]:
    """How it was fitted, in words."""
    said = []
    if found.how.linear:
        said.append("Fitted by the linear model: deflections of the unloaded configuration.")
    else:
        shift = found.linear_shift
        worst = int(np.argmax(shift))
        said.append(
            f"Fitted on the nonlinear equilibrium in {counted(found.iterations, 'step')}. The "
            f"linear model would be off by up to {number(float(shift[worst]), 2)} standard errors "
            f"({found.identified[worst]})."
        )
    if not found.how.estimates_sigma:
        said.append("Intervals rest on the promised noise.")
    else:
        said.append(
            f"Intervals rest on the noise found, with Student's t for {found.dof} degrees of "
            "freedom."
        )
    if found.how.robust:
        said.append(f"Robust loss {found.how.loss}: outlying readings count less.")
    return said


def _residuals(found: Identification) -> Values:
    """How the residuals are spread."""
    data, quantiles = found.measurements, residual_quantiles(found)
    band = twice_the_noise(found)
    return {
        "strips": [
            reading_strips(found.residual, band, data, kind, "twice the noise")
            for kind in data.quantities
        ],
        "inside": percent(share_inside(found)),
        "estimated": found.how.estimates_sigma,
        "quantiles": None if quantiles is None else quantile_chart(quantiles),
        "lack": lack_of_fit_in_words(found),
    }


def reading_strips(
    error: Array, half: Array, data: Measurements, kind: Quantity, band: str
) -> tuple[Markup, str]:
    """Strips of the readings of a kind, and what is not drawn of them.

    Args:
        error: (R, 3) errors of all readings [m, rad].
        half: (R, 3) half widths of their bands.
        data: The readings.
        kind: Which are drawn.
        band: What the band is, in words.
    """
    own = kind.readings
    strips = Strips(error[own], half[own], data.case[own], data.names, band, kind.unit)
    return two_widths(lambda width: strips_chart(strips, width)), strips.remark


def lack_of_fit_in_words(found: Identification) -> str:
    """What repeats say of the model."""
    lack = found.lack_of_fit
    if lack is None:
        return "Nothing was measured twice, so noise and errors of the model cannot be told apart."
    said = (
        f"Repeats scatter {number(lack.pure_scale, 2)} times as much as promised "
        f"({lack.pure_dof} degrees of freedom)"
    )
    if not lack.fit_dof:
        return said + "; the model has as many unknowns as there are means, so they cannot test it."
    said += (
        f"; their means lie {number(lack.fit_scale, 2)} times the promised noise off the model "
        f"({lack.fit_dof}). "
    )
    if lack.beyond_chance:
        return said + f"That is {chance(lack.p_value)}: the model lacks something."
    if lack.p_value < SELDOM:
        return said + f"They are so far off {chance(lack.p_value)}: have an eye on the model."
    by_chance = probability(lack.p_value)
    return said + f"That is what chance does ({by_chance}): repeats do not contradict the model."


def _influence(found: Identification) -> Values:
    """What every experiment decides."""
    data, left_out = found.measurements, left_out_rms(found)
    count = len(data.cases)
    own = found.influence
    chart = leverage_chart(own.leverage, left_out, own.cook, data.names, float(own.leverage.mean()))
    cook = np.where(np.isfinite(own.cook), own.cook, np.inf)
    order = np.argsort(-cook)[:6]
    rows = [
        (
            data.names[i],
            number(float(own.leverage[i]), 2),
            number(float(left_out[i]), 2),
            number(float(cook[i]), 2),
        )
        for i in order
    ]
    return {"chart": chart, "rows": rows, "others": count - len(order)}


def _correlation(found: Identification) -> Values:
    """Which compliances are hard to tell apart."""
    p = len(found.identified)
    worst = np.arange(p)[::-1][: min(_WORST, max(p - 1, 1))]
    seen = found.singular_values[worst] / found.singular_values[0]
    return {
        "map": correlation_chart(found.correlation, found.identified) if p > 1 else None,
        "combinations": combinations_chart(found.combinations[worst], seen, found.identified)
        if p > 1
        else None,
        "many": p > 9,
        "strongest": _strongest(found) if p > 1 else "",
    }


def _strongest(found: Identification) -> str:
    """The two that are correlated most, in words."""
    correlation = np.abs(np.tril(found.correlation, -1))
    i, j = np.unravel_index(int(np.argmax(correlation)), correlation.shape)
    value = float(found.correlation[i, j])
    names = f"{found.identified[j]} and {found.identified[i]}"
    return f"The strongest correlation is that of {names}: {number(value, 2)}."
