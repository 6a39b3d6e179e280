"""Section of virtual campaigns: the errors they leave, plans side by side, against prediction.

In: Monte Carlo, the plan's study for units. Out: sections.
"""

from __future__ import annotations

import numpy as np

from elastocal.report.charts.calibration import Statistic, calibration_chart
from elastocal.report.charts.cloud import cloud_chart
from elastocal.report.charts.histograms import histogram_chart
from elastocal.report.contents import Contents
from elastocal.report.layout import WIDE, alone, two_widths
from elastocal.report.section import Chapter, PageSection, Values
from elastocal.report.tables import BarTable, Row
from elastocal.simulation.campaigns import Campaigns, MonteCarlo, RandomCampaigns
from elastocal.simulation.prediction import (
    PROMISED,
    chance,
    cloud,
    doubts_of_campaigns,
    predicted_total,
    worst_pair,
)
from elastocal.wording import worded
from elastocal.wording.numbers import fixed, length, number, percent, shown_unit

_MOST_MARKS = 3  # plans with marks of their own


def monte_carlo_chapter(contents: Contents) -> Chapter | None:
    """The sections of the virtual campaigns."""
    found = contents.monte_carlo
    if found is None:
        return None
    sections = (
        PageSection("monte-carlo", "Virtual campaigns", _errors(found)),
        PageSection("coverage", "Estimates", _estimates(contents, found)),
    )
    return Chapter("Monte Carlo", sections)


def _errors(found: MonteCarlo) -> Values:
    """Errors found against those predicted."""
    predicted = [predicted_total(plan) for plan in found.plans]
    rows = [_row(p) for p in found.plans]
    if found.random is not None:
        rows.append(_row(found.random))
    sizes = (
        "Promised" if found.nuisance else "ρ₀ predicted",
        "RMS found",
        "Found / predicted",
        "Mean",
        "Median",
    )
    heads = ("Plan", "Experiments", *sizes, "90 %", "95 %", "99 %")
    return {
        "number": found.number,
        "seed": found.seed,
        "linear": found.linear,
        "nuisance": found.nuisance,
        "known": list(found.known),
        "poses": int((found.plans[0].weight > 0.0).sum()),
        "sigma": found.how.sigma,
        "chart": two_widths(
            lambda width: histogram_chart(found.plans, predicted, width, found.random)
        ),
        "table": BarTable(heads, tuple(rows)),
        "random": found.random,
        "compared": _compared(found),
        "remarks": tuple(map(worded, doubts_of_campaigns(found))),
    }


def _row(plan: Campaigns | RandomCampaigns) -> Row:
    """Sizes of the errors of a plan."""
    total = plan.total
    quantiles = [length(float(np.quantile(total, q))) for q in (0.5, 0.9, 0.95, 0.99)]
    cells = (
        plan.name,
        str(plan.experiments),
        length(plan.rho0),
        length(plan.rms),
        number(plan.rms / plan.rho0),
        length(float(total.mean())),
        *quantiles,
    )
    return Row(cells)


def _compared(found: MonteCarlo) -> str:
    """The best plan against the others."""
    if len(found.plans) < 2:
        return ""
    ordered = sorted(found.plans, key=lambda plan: plan.rms)
    best = ordered[0]
    said = [
        f"{number(other.rms / best.rms, 2)} times as large with {other.name}"
        for other in ordered[1:4]
    ]
    return f"The error is smallest with {best.name}; it is " + ", ".join(said) + "."


def campaigns_picture(found: MonteCarlo) -> str:
    """The histograms as the text of an SVG file that stands alone."""
    predicted = [predicted_total(plan) for plan in found.plans]
    return alone(histogram_chart(found.plans, predicted, WIDE, found.random))


def _estimates(contents: Contents, found: MonteCarlo) -> Values:
    """Estimates against what is predicted of them."""
    shown = found.plans[:_MOST_MARKS]
    allowed = chance(found.number)
    statistics = [
        Statistic("bias [standard errors]", 0.0, allowed.bias, np.array([p.bias for p in shown])),
        Statistic(
            "spread, found / predicted", 1.0, allowed.spread, np.array([p.spread for p in shown])
        ),
        Statistic(
            "coverage of 95 % intervals [%]",
            100.0 * PROMISED,
            (100.0 * allowed.coverage[0], 100.0 * allowed.coverage[1]),
            100.0 * np.array([p.coverage for p in shown]),
        ),
    ]
    names = [p.name for p in shown]
    rows = tuple(
        Row((spring, *(percent_of(float(p.coverage[i])) for p in found.plans)))
        for i, spring in enumerate(found.springs)
    )
    # Of robots that differ, fitted with bounds, no covariance is that of all estimates.
    tested = () if found.nuisance else found.plans
    tests = [(p.name, number(p.likelihood_ratio()[1], 2)) for p in tested]
    return {
        "chart": two_widths(lambda w: calibration_chart(statistics, found.springs, names, w)),
        "table": BarTable(("Coverage", *(p.name for p in found.plans)), rows),
        "clouds": _clouds(contents, found) if len(found.springs) > 1 else [],
        "tests": tests,
        "others": len(found.plans) - len(shown),
        "chance": [percent_of(v) for v in allowed.coverage],
    }


def percent_of(share: float) -> str:
    """A share with one decimal."""
    return f"{fixed(100.0 * share, 1)} %"


def _unit(contents: Contents, spring: str) -> str:
    """Unit of a compliance shown in 10⁻⁹ of SI."""
    if contents.plan is None or spring not in contents.plan.study.sought.names:
        return "10⁻⁹ SI"
    springs = contents.plan.study.sought
    return shown_unit(springs.kinds[springs.names.index(spring)].compliance)[1]


def _clouds(contents: Contents, found: MonteCarlo) -> list[Values]:
    """The two compliances that the first plan tells apart worst, for every plan, same axes."""
    pair = worst_pair(found.plans[0])
    first, second = (found.springs[k] for k in pair)
    units = _unit(contents, first), _unit(contents, second)
    shown = found.plans[:4]
    reach = np.max([3.4e9 * p.predicted_error[list(pair)] for p in shown], axis=0)
    clouds = [cloud(plan, pair) for plan in shown]
    return [
        {
            "name": plan.name,
            "chart": cloud_chart(1e9 * c.shift, 1e9 * c.ellipse, (first, second), units, reach),
            "inside": percent(c.inside),
        }
        for plan, c in zip(shown, clouds, strict=True)
    ]
